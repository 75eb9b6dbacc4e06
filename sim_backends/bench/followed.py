"""A stage that the bench knows nothing of, such as a third party's: it carries the object by what it says of its position."""

import time
from typing import Any, Self

import numpy as np

from protocols import (
    DeviceIdentity,
    DeviceTimeout,
    Floats,
    InputError,
    LinearStage,
    Motion,
    MotionProfile,
    StageLimits,
    StagePosition,
)
from sim_backends.bench.clock import BenchClock, VirtualClock

_STAMP_S = 1e-3
"""A stamp may be so much outside of the question and its answer."""


class FollowedStage:
    """A ``LinearStage`` that passes every call on, and remembers where it was whenever the bench looked.

    Between two looks the object moves evenly: a counter that asks 20 times a second leaves 0.016 mm at most in a ramp of
    50 mm/s^2, a t^2 / 8, and nothing at constant velocity.
    """

    def __init__(self, stage: LinearStage, clock: BenchClock) -> None:
        """Look at the stage once."""
        self._stage = stage
        self._clock = clock
        self._time_s: list[float] = []
        self._at_mm: list[float] = []
        self.look()

    # What the bench asks

    def look(self) -> float:
        """Ask the stage where it is.

        Returns:
            The time of the look before: what is later was a guess until now.

        Raises:
            InputError: the stage stamps its positions with another clock than the bench's.
        """
        before_s = self._clock.now_s()
        position = self._stage.position()
        after_s = self._clock.now_s()
        if not before_s - _STAMP_S <= position.time_s <= after_s + _STAMP_S:
            raise self._other_time(f"a position of the moment {position.time_s:.6g} s, asked for at {before_s:.6g} s")
        last_s = self._time_s[-1] if self._time_s else position.time_s
        if not self._time_s or position.time_s > last_s:
            self._time_s.append(position.time_s)
            self._at_mm.append(position.reported_mm)
        return last_s

    def position_mm(self, time_s: Floats) -> Floats:
        """``(n,)`` positions at ``(n,)`` clock times; later than the last look it goes on as between the last two."""
        known_s, at_mm = np.array(self._time_s), np.array(self._at_mm)
        found: Floats = np.interp(time_s, known_s, at_mm)
        if len(known_s) > 1:
            velocity_mm_s = (at_mm[-1] - at_mm[-2]) / (known_s[-1] - known_s[-2])
            found = found + velocity_mm_s * np.maximum(0.0, time_s - known_s[-1])
        return found

    def _other_time(self, saw: str) -> InputError:
        return InputError(
            device=self._stage.identity.name,
            saw=saw,
            expected="a stage that keeps the bench's time, which is virtual: it passes only while somebody waits on it",
            remedy="set realtime = true in [scene], or let the driver and its controller take all time from context.clock",
        )

    # LinearStage

    @property
    def identity(self) -> DeviceIdentity:
        """The stage's own."""
        return self._stage.identity

    @property
    def limits(self) -> StageLimits:
        """The stage's own."""
        return self._stage.limits

    @property
    def homed(self) -> bool:
        """As the stage says."""
        return self._stage.homed

    @property
    def stands_by_s(self) -> float:
        """As the stage says."""
        return self._stage.stands_by_s

    def check(self, target_mm: float, profile: MotionProfile) -> None:
        """See ``LinearStage.check``."""
        self._stage.check(target_mm, profile)

    def position(self) -> StagePosition:
        """See ``LinearStage.position``."""
        return self._stage.position()

    def move_to(self, target_mm: float, profile: MotionProfile) -> Motion:
        """See ``LinearStage.move_to``."""
        return self._watched(self._stage.move_to(target_mm, profile))

    def move_by(self, distance_mm: float, profile: MotionProfile) -> Motion:
        """See ``LinearStage.move_by``."""
        return self._watched(self._stage.move_by(distance_mm, profile))

    def home(self) -> Motion:
        """See ``LinearStage.home``."""
        return self._watched(self._stage.home())

    def stop(self) -> None:
        """See ``LinearStage.stop``."""
        self._stage.stop()

    def __enter__(self) -> Self:
        """Enter the stage."""
        self._stage.__enter__()
        return self

    def __exit__(self, *exc: object) -> None:
        """Leave the stage."""
        self._stage.__exit__(*exc)

    def __getattr__(self, name: str) -> Any:
        """What the stage has beyond the protocol."""
        return getattr(self.__dict__["_stage"], name)

    def _watched(self, motion: Motion) -> Motion:
        return (
            _WatchedMotion(motion, self._clock, self._other_time) if isinstance(self._clock, VirtualClock) else motion
        )


class _WatchedMotion:
    """A motion in virtual time. One that is late while the host's clock has hardly moved belongs to a stage in real time."""

    def __init__(self, motion: Motion, clock: VirtualClock, other_time: Any) -> None:
        self._motion, self._clock, self._other_time = motion, clock, other_time
        self._begun_s, self._host_s = clock.now_s(), time.monotonic()

    @property
    def target_mm(self) -> float:
        return self._motion.target_mm

    @property
    def done(self) -> bool:
        return self._motion.done

    def wait(self, timeout_s: float | None = None) -> StagePosition:
        try:
            return self._motion.wait(timeout_s)
        except DeviceTimeout as late:
            took_s, host_s = self._clock.now_s() - self._begun_s, time.monotonic() - self._host_s
            if timeout_s is not None or host_s > took_s / 2:
                raise
            raise self._other_time(f"{late.saw}, of which {host_s:.3g} s were real time") from late

    def stop(self) -> None:
        self._motion.stop()
