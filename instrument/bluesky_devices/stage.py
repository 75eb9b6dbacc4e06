"""The stage as bluesky's Movable: set, read, check limits, stop."""

import time

from bluesky.protocols import Checkable, Hints, Locatable, Location, Readable, Reading, Stoppable
from event_model.documents import DataKey

from instrument.bluesky_devices.named import Named
from instrument.bluesky_devices.status import WorkStatus
from instrument.session import Instrument
from protocols import DeviceError, LinearStage, Motion, MotionProfile


class KinopixStage(Named, Locatable[float], Readable[float], Stoppable, Checkable[float]):
    """The bench's stage, in millimetres. A run of the detector moves it too, by its plan; a ``set`` during a run is refused."""

    def __init__(self, bench: Instrument, name: str = "stage", *, profile: MotionProfile | None = None) -> None:
        """Wrap the stage of an open bench.

        Args:
            bench: open, with a stage.
            name: of the device in documents.
            profile: by which ``set`` moves; None takes 10 mm/s and 50 mm/s^2, or what the stage can do.
        """
        super().__init__(name)
        self._stage: LinearStage = bench.stage
        self.profile = profile or self._stage.limits.gentle_profile
        """By which ``set`` moves."""
        self._motion: Motion | None = None
        self._stopped_well = False

    @property
    def hints(self) -> Hints:
        """What a plot of the scan has on its axis."""
        return {"fields": [self.name]}

    def check_value(self, value: float) -> None:
        """Raise what ``set`` would raise for a target in millimetres, and move nothing.

        Raises:
            TravelExceeded: it is outside the travel.
            MotionTooFast: the profile is outside the limits.
        """
        self._stage.check(value, self.profile)

    def set(self, value: float) -> WorkStatus:
        """Start a move to a position in millimetres; the status is done when the controller says that the stage stands.

        Raises:
            TravelExceeded: the target is outside the travel; nothing was sent.
            DeviceBusy: it moves already, or a run moves it.
        """
        self._stopped_well = False
        motion = self._motion = self._stage.move_to(value, self.profile)

        def wait() -> None:
            try:
                motion.wait()
            except DeviceError:
                if not self._stopped_well:
                    raise

        return WorkStatus(wait, f"{self.name}-set")

    def stop(self, success: bool = True) -> None:  # noqa: FBT001, FBT002 - as bluesky calls it
        """Stop at once, where the stage is.

        Args:
            success: whether the move counts as well done, as when a plan is paused; otherwise its status fails.
        """
        self._stopped_well = success
        self._stage.stop()

    def locate(self) -> Location[float]:
        """Tell where the stage was sent, and where it is."""
        position = self._stage.position()
        return {"setpoint": position.commanded_mm, "readback": position.reported_mm}

    def read(self) -> dict[str, Reading[float]]:
        """Tell where the stage is. A controller that is mute in motion has its position predicted from the profile."""
        position = self._stage.position()
        return {self.name: {"value": position.reported_mm, "timestamp": time.time()}}

    def describe(self) -> dict[str, DataKey]:
        """Say what ``read`` gives."""
        low, high = self._stage.limits.travel_mm
        return {
            self.name: {
                "source": f"kinopix://{self._stage.identity.name}/position",
                "dtype": "number",
                "shape": [],
                "units": "mm",
                "limits": {"control": {"low": low, "high": high}},
            }
        }
