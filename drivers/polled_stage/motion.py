"""One motion: from the command to the position read back."""

from collections.abc import Callable
from typing import Final

from drivers.polled_stage.axis import Axis, Status
from protocols import Clock, DeviceError, DeviceTimeout, MotionProfile, StagePosition


class PolledMotion:
    """A motion under way, or over. Satisfies ``protocols.Motion``.

    It is over when the controller says that it stands, at the target; or, elsewhere, when it says so twice at the same place.
    """

    def __init__(
        self,
        axis: Axis,
        clock: Clock,
        device: str,
        *,
        start_mm: float,
        target_mm: float,
        profile: MotionProfile,
        limit_s: float,
        poll_s: float,
        ask: Callable[[], Status],
        stop_stage: Callable[[], None],
    ) -> None:
        """Note what was commanded.

        Args:
            axis: the controller.
            clock: the bench's.
            device: name that errors carry.
            start_mm: position before the motion.
            target_mm: where it is to end.
            profile: what the controller runs.
            limit_s: longest time from start to end.
            poll_s: time between two looks at a stage that moves.
            ask: asks the controller, in turn with others.
            stop_stage: stops the stage.
        """
        self._axis, self._clock, self._device = axis, clock, device
        self._start_mm, self._target_mm, self._profile = start_mm, target_mm, profile
        self._ask, self._stop_stage, self._poll_s = ask, stop_stage, poll_s
        self.limit_s: Final = limit_s
        self.started_s = clock.now_s()
        self._stopped_s: float | None = None
        self._end: Status | None = None

    @property
    def target_mm(self) -> float:
        """Position at which the motion is to end, in millimetres."""
        return self._target_mm

    @property
    def stopping(self) -> bool:
        """Whether a stop has been sent for this motion."""
        return self._stopped_s is not None

    @property
    def over(self) -> bool:
        """Whether it was found to be over. Asks nothing."""
        return self._end is not None

    @property
    def done(self) -> bool:
        """Whether the controller has said that the stage stands."""
        if self._end is None:
            self._look()
        return self._end is not None

    def stop_sent(self) -> None:
        """Take note that a stop is on its way."""
        if self._stopped_s is None:
            self._stopped_s = self._clock.now_s()

    def stop(self) -> None:
        """Stop this motion; nothing happens where it is over."""
        if self._end is None:
            self._stop_stage()

    def predicted_mm(self) -> float:
        """Where the profile has the stage now; after a stop, where it had it when the stop was sent."""
        until_s = self._clock.now_s() if self._stopped_s is None else self._stopped_s
        return self._start_mm + self._profile.travelled_mm(self._target_mm - self._start_mm, until_s - self.started_s)

    def wait(self, timeout_s: float | None = None) -> StagePosition:
        """Return the position, read back, when the stage stands.

        Raises:
            DeviceTimeout: the stage still moves; names the distance covered.
            DeviceError: the motion ended elsewhere: a stop, a limit switch, a stall; with the controller's own words.
        """
        self.stand(timeout_s)
        return self._outcome()

    def stand(self, timeout_s: float | None = None) -> None:
        """Wait until the stage stands, at the target or elsewhere.

        Raises:
            DeviceTimeout: the stage still moves; names the distance covered.
        """
        asked_s = self._clock.now_s()
        while not self.done:
            now_s = self._clock.now_s()
            if now_s >= (self._deadline_s() if timeout_s is None else asked_s + timeout_s):
                raise self._timeout(now_s)
            self._clock.sleep_s(self._poll_s)

    def _look(self) -> None:
        try:
            status = self._ask()
            if status.moving or status.mm is None:
                return
            if not self._same(status.mm, self._target_mm):
                self._clock.sleep_s(self._poll_s)
                first_mm, status = status.mm, self._ask()
                if status.moving or status.mm is None or not self._same(status.mm, first_mm):
                    return
        except DeviceTimeout:
            return  # an answer was lost: asked again at the next look, until the time is over
        self._end = status

    def _same(self, one_mm: float, other_mm: float) -> bool:
        return abs(one_mm - other_mm) <= self._axis.tolerance_mm

    def _deadline_s(self) -> float:
        if self._stopped_s is None:
            return self.started_s + self.limit_s
        return self._stopped_s + 1.2 * self._profile.velocity_mm_s / self._profile.acceleration_mm_s2 + 1.0

    def _outcome(self) -> StagePosition:
        end = self._end
        assert end is not None  # noqa: S101 (called when done)
        assert end.mm is not None  # noqa: S101 (a motion ends where its place is known)
        if self._same(end.mm, self._target_mm):
            return StagePosition(time_s=end.time_s, commanded_mm=self._target_mm, reported_mm=end.mm)
        why = f"; the controller says: {end.trouble}" if end.trouble else ""
        raise DeviceError(
            device=self._device,
            saw=f"the motion over at {end.mm:g} mm{', after a stop' if self.stopping else ''}{why}",
            expected=f"{self._target_mm:g} mm",
            remedy="start the next move when it is safe"
            if self.stopping
            else "look at the limit switches and for what blocks the stage, move away from it, and home: steps may be lost",
        )

    def _timeout(self, now_s: float) -> DeviceTimeout:
        try:
            told_mm = self._ask().mm
        except DeviceTimeout:
            told_mm = None
        here_mm, how = (self.predicted_mm(), "predicted: no answer") if told_mm is None else (told_mm, "reported")
        done_mm, whole_mm = here_mm - self._start_mm, self._target_mm - self._start_mm
        return DeviceTimeout(
            self._device,
            awaited=f"the end of the {'stopped ' if self.stopping else ''}motion to {self._target_mm:g} mm",
            waited_s=now_s - self.started_s,
            progress=f"{done_mm:.3f} of {whole_mm:.3f} mm done ({how})",
            remedy="stop the stage, then read its position; a new move is refused until then",
        )
