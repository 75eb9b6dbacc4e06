"""One motion: from the command to the position read back.

A line that seems to end a motion (a completion line, an error, an ``OK``) is a claim, no more: it may be late, doubled or
garbled. The motion is over when the controller, asked, tells a position that agrees with the claim and the target, or the same
position twice with enough time between for a moving stage to have left it. A stop is such a claim too.
"""

import math
from collections.abc import Callable
from typing import Final

from drivers.zolix.controller import Controller, Reading
from drivers.zolix.events import Arrived, Position, Refused
from protocols import DeviceError, DeviceRefused, DeviceTimeout, MotionProfile, StagePosition

_POLL_S: Final = 0.01
_START_DELAY_S: Final = 0.05


class ZolixMotion:
    """A motion under way, or over. Satisfies ``protocols.Motion``."""

    def __init__(
        self,
        controller: Controller,
        *,
        start_mm: float,
        target_mm: float,
        profile: MotionProfile,
        limit_s: float,
        bounds_mm: tuple[float, float],
        if_elsewhere: str,
        stop_stage: Callable[[], None],
        ended: Callable[["ZolixMotion"], None],
    ) -> None:
        self._controller = controller
        self._clock = controller.wire.clock
        self.start_mm: Final = start_mm
        self.bounds_mm: Final = bounds_mm
        """Lowest and highest position between which the stage moves, in millimetres."""
        self._if_elsewhere = if_elsewhere
        self._target_mm = target_mm
        self._profile = profile
        self.limit_s: Final = limit_s
        """Longest time from the start to the end, in seconds."""
        self._stop_stage = stop_stage
        self._ended = ended
        self.started_s = self._clock.now_s()
        self._stopped_s: float | None = None
        self._claims: list[object] = []
        self._end: Reading | None = None

    @property
    def target_mm(self) -> float:
        """Position at which the motion is to end, in millimetres."""
        return self._target_mm

    @property
    def stopping(self) -> bool:
        """Whether a stop has been sent for this motion."""
        return self._stopped_s is not None

    @property
    def reached(self) -> bool:
        """Whether it is over, at its target."""
        return self._end is not None and self._controller.same(self._end.mm, self._target_mm)

    @property
    def done(self) -> bool:
        """Whether the controller has said that the stage stands. Looks at the line, and asks when something came."""
        with self._controller.wire.turn:
            if self._end is None:
                self._look()
            return self._end is not None

    @property
    def standing_mm(self) -> float | None:
        """Where the controller said, asked, that the stage stands; None as long as it has not."""
        return None if self._end is None else self._end.mm

    def wait(self, timeout_s: float | None = None) -> StagePosition:
        """Return the position, read back, when the stage stands.

        Raises:
            DeviceTimeout: the stage still moves; names the distance covered.
            DeviceRefused: the controller answered the move with an error.
            DeviceError: the motion ended elsewhere (a stop, a limit switch, a lost step).
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
            self._clock.sleep_s(_POLL_S)

    def stop(self) -> None:
        """Stop this motion; nothing happens where it is over."""
        if self._end is None:
            self._stop_stage()

    def stop_sent(self) -> None:
        """Take note that a stop is on its way."""
        if self._stopped_s is None:
            self._stopped_s = self._clock.now_s()

    def predicted_mm(self) -> float:
        """Where the profile has the stage now; after a stop, where it had it when the stop was sent.

        How an unknown controller slows down after a stop is not known: up to v^2 / 2a are missing from the latter.
        """
        until_s = self._clock.now_s() if self._stopped_s is None else self._stopped_s
        distance_mm = self._target_mm - self.start_mm
        return self.start_mm + self._profile.travelled_mm(distance_mm, until_s - self.started_s)

    def finish_at(self, reading: Reading) -> None:
        """Take ``reading`` as the end of this motion."""
        self._end = reading
        self._ended(self)

    def _look(self) -> None:
        wire = self._controller.wire
        wire.pump()
        self._claims += wire.endings
        wire.endings.clear()
        if not self._claims and not self.stopping:
            return
        try:
            reading = self._confirmed()
        except DeviceTimeout:
            return  # mute, so it still moves, or the answer was lost: asked again at the next look
        if reading is None:
            self._claims.clear()
        else:
            self.finish_at(reading)

    def _confirmed(self) -> Reading | None:
        """The position at which the stage stands, or None where it moves."""
        controller = self._controller
        first = controller.ask()
        claimed = [controller.scale.mm(c.pulses) for c in self._claims if isinstance(c, Arrived | Position)]
        if controller.same(first.mm, self._target_mm) and any(controller.same(mm, first.mm) for mm in claimed):
            return first
        self._clock.sleep_s(self._time_to_leave_s())
        second = controller.ask()
        return second if controller.same(first.mm, second.mm) else None

    def _time_to_leave_s(self) -> float:
        """Time in which a stage, from rest, goes farther than two positions may differ and be called the same."""
        distance_mm = 4 * self._controller.scale.tolerance_mm
        return _START_DELAY_S + 2 * math.sqrt(2 * distance_mm / self._profile.acceleration_mm_s2)

    def _deadline_s(self) -> float:
        if self._stopped_s is None:
            return self.started_s + self.limit_s
        rest_s = 1.2 * self._profile.velocity_mm_s / self._profile.acceleration_mm_s2 + 1.0
        return self._stopped_s + rest_s + 2 * self._time_to_leave_s()

    def _outcome(self) -> StagePosition:
        assert self._end is not None  # noqa: S101 (called when done)
        if self.reached:
            return StagePosition(time_s=self._end.time_s, commanded_mm=self._target_mm, reported_mm=self._end.mm)
        device = self._controller.wire.device
        refusals = [claim.code for claim in self._claims if isinstance(claim, Refused)]
        if refusals:
            raise DeviceRefused(
                device,
                code=refusals[0],
                saw=f"an error instead of the end of the move; the stage stands at {self._end.mm:g} mm",
                expected=f"{self._target_mm:g} mm",
                remedy="see whether a limit switch is held; the meaning of the codes is not published",
            )
        raise DeviceError(
            device=device,
            saw=f"the motion over at {self._end.mm:g} mm{', after a stop' if self.stopping else ''}",
            expected=f"{self._target_mm:g} mm",
            remedy="start the next move when it is safe" if self.stopping else self._if_elsewhere,
        )

    def _timeout(self, now_s: float) -> DeviceTimeout:
        try:
            here, how = self._controller.ask().mm, "reported"
        except DeviceTimeout:
            here, how = self.predicted_mm(), "predicted: the controller is mute"
        done_mm, whole_mm = here - self.start_mm, self._target_mm - self.start_mm
        return DeviceTimeout(
            self._controller.wire.device,
            awaited=f"the line that ends the {'stopped ' if self.stopping else ''}motion to {self._target_mm:g} mm",
            waited_s=now_s - self.started_s,
            progress=f"{done_mm:.3f} of {whole_mm:.3f} mm done ({how}), last bytes {self._controller.wire.seen!r},",
            remedy="stop the stage, then read its position; a new move is refused until then",
        )
