"""``protocols.LinearStage`` on any controller that can be asked at any time."""

from collections.abc import Callable
from threading import RLock
from typing import Final, Self

from drivers.polled_stage.axis import Axis, Status
from drivers.polled_stage.motion import PolledMotion
from protocols import (
    Clock,
    DeviceBusy,
    DeviceError,
    DeviceIdentity,
    DeviceTimeout,
    MotionProfile,
    StageLimits,
    StagePosition,
    WrongState,
)

_BEGINS_S: Final = 2.0
"""Longest time from the call to the command on the line, in seconds."""


class PolledStage:
    """A stage on an open axis. A stop takes no lock and waits for no answer."""

    def __init__(
        self,
        axis: Axis,
        clock: Clock,
        *,
        identity: DeviceIdentity,
        limits: StageLimits,
        home_mm: float,
        home_profile: MotionProfile,
        home_limit_s: float | None = None,
        require_home: bool = False,
        poll_s: float = 0.04,
    ) -> None:
        """Take over an open axis.

        Args:
            axis: closed when the stage is.
            clock: the bench's.
            identity: of stage and controller.
            limits: what bench.toml allows.
            home_mm: what the controller reports at its origin.
            home_profile: of homing.
            home_limit_s: longest time of homing; None takes the whole travel at ``home_profile`` plus 20 % plus one second.
            require_home: refuse moves until the controller knows its origin.
            poll_s: time between two looks at a stage that moves.
        """
        self._axis, self._clock = axis, clock
        self._identity, self._limits = identity, limits
        self._home_mm, self._home_profile, self._require_home = home_mm, home_profile, require_home
        low, high = limits.travel_mm
        self._home_limit_s = home_limit_s or _limit_s(home_profile, high - low)
        self._poll_s = poll_s
        self._turn = RLock()
        self._motion: PolledMotion | None = None
        self._closed = False
        self._stands_by_s = clock.now_s()

    @property
    def identity(self) -> DeviceIdentity:
        """Identity of the stage and of its controller."""
        return self._identity

    @property
    def limits(self) -> StageLimits:
        """Travel, velocity, acceleration, as bench.toml allows them."""
        return self._limits

    @property
    def homed(self) -> bool:
        """Whether the controller says that it knows its origin; it may know it from before this program began."""
        return self._ask().homed

    @property
    def stands_by_s(self) -> float:
        """Moment by which every motion command that was sent is carried out, even if no stop is obeyed."""
        return self._stands_by_s

    def check(self, target_mm: float, profile: MotionProfile) -> None:
        """Raise what ``move_to`` would raise for this target and profile, and move nothing.

        Raises:
            TravelExceeded: the target is outside ``travel_mm``, or not a number.
            MotionTooFast: velocity, acceleration or start velocity too high.
            PlanError: a profile that the controller cannot run.
        """
        self._limits.check_target(target_mm, self._identity.name)
        self._limits.check_profile(profile, self._identity.name)
        self._axis.check(profile)

    def position(self) -> StagePosition:
        """Where the stage is now, by the controller's own word; predicted where it is mute in a motion.

        Raises:
            DeviceTimeout: no answer; names what was awaited and what came.
        """
        status, motion = self._ask(), self._motion
        if status.mm is not None:
            commanded_mm = status.mm if motion is None else motion.target_mm
            return StagePosition(time_s=status.time_s, commanded_mm=commanded_mm, reported_mm=status.mm)
        if motion is None:
            raise WrongState(
                device=self._identity.name,
                saw=f"a controller that does not tell its position ({status.trouble})",
                expected="one that stands and can be asked",
                remedy="wait until what another program started is over, or reset the controller",
            )
        return StagePosition(
            time_s=status.time_s,
            commanded_mm=motion.target_mm,
            reported_mm=motion.predicted_mm(),
            predicted=True,
        )

    def move_to(self, target_mm: float, profile: MotionProfile) -> PolledMotion:
        """Start a move to an absolute position and return at once. After a stop, waits first until the stage stands.

        Raises:
            TravelExceeded, MotionTooFast, PlanError: as ``check``; nothing was sent.
            DeviceBusy: another motion is under way.
            WrongState: not homed, where ``require_home`` is set.
            DeviceRefused: the controller does not take a command.
            DeviceTimeout: it does not answer; a stop has been sent where the move may have begun.
        """
        stops = self._axis.stops
        self.check(target_mm, profile)
        with self._turn:
            return self._move(self._standing(), target_mm, profile, stops)

    def move_by(self, distance_mm: float, profile: MotionProfile) -> PolledMotion:
        """Start a move relative to where the stage stands; as ``move_to`` otherwise."""
        stops = self._axis.stops
        with self._turn:
            here = self._standing()
            target_mm = _place(here) + distance_mm
            self.check(target_mm, profile)
            return self._move(here, target_mm, profile, stops)

    def home(self) -> PolledMotion:
        """Look for the origin.

        Raises:
            DeviceBusy, DeviceRefused, DeviceTimeout: as ``move_to``.
        """
        stops = self._axis.stops
        with self._turn:
            here, profile = self._standing(), self._home_profile
            motion = self._new(here, self._home_mm, profile, self._home_limit_s)
            return self._start(motion, lambda: self._axis.begin_home(profile, stops=stops))

    def stop(self) -> None:
        """Stop at once. It overtakes everything but bytes that are being written."""
        motion = self._motion
        if motion is not None and not motion.over:
            motion.stop_sent()
        self._axis.send_stop()

    def __enter__(self) -> Self:
        """Give the open stage."""
        return self

    def __exit__(self, *exc: object) -> None:
        """Stop, and give the line back even if stopping fails."""
        if self._closed:
            return
        try:
            self.stop()
        finally:
            self._closed = True
            self._axis.close()

    def _ask(self) -> Status:
        with self._turn:
            return self._axis.status()

    def _standing(self) -> Status:
        """What the controller says when no motion is under way; waits for one that was stopped, by us or by who was here before.

        Raises:
            DeviceBusy: it moves.
        """
        motion = self._motion
        if motion is not None and not motion.done:
            if not motion.stopping:
                raise self._busy(f"a motion to {motion.target_mm:g} mm under way")
            motion.stand()
        until_s = self._clock.now_s() + _rest_s(self._limits)
        while (status := self._axis.status()).moving or status.mm is None:
            if self._clock.now_s() >= until_s:
                raise self._busy("a controller that moves by the order of another program")
            self._clock.sleep_s(self._poll_s)
        return status

    def _busy(self, saw: str) -> DeviceBusy:
        return DeviceBusy(
            device=self._identity.name,
            saw=saw,
            expected="a stage that stands",
            remedy="wait for that motion, or stop it",
        )

    def _move(self, here: Status, target_mm: float, profile: MotionProfile, stops: int) -> PolledMotion:
        if self._require_home and not here.homed:
            raise WrongState(
                device=self._identity.name,
                saw="a move of a stage that has not been homed",
                expected="homing first, as require_home asks",
                remedy="call home(), or set require_home = false in bench.toml",
            )
        runs = self._axis.runs(profile)
        motion = self._new(here, target_mm, runs, _limit_s(runs, target_mm - _place(here)))
        return self._start(motion, lambda: self._axis.begin_move(target_mm, profile, stops=stops))

    def _new(self, here: Status, target_mm: float, profile: MotionProfile, limit_s: float) -> PolledMotion:
        return PolledMotion(
            self._axis,
            self._clock,
            self._identity.name,
            start_mm=_place(here),
            target_mm=target_mm,
            profile=profile,
            limit_s=limit_s,
            poll_s=self._poll_s,
            ask=self._ask,
            stop_stage=self.stop,
        )

    def _start(self, motion: PolledMotion, begin: Callable[[], None]) -> PolledMotion:
        self._motion = motion  # before the bytes leave, so that a stop from another thread finds it
        self._stands_by_s = self._clock.now_s() + _BEGINS_S + motion.limit_s
        try:
            begin()
        except DeviceTimeout:
            self.stop()  # the command may have arrived, though its answer did not
            raise
        except DeviceError:
            self._motion = None
            raise
        motion.started_s = self._clock.now_s()
        self._stands_by_s = motion.started_s + motion.limit_s
        return motion


def _rest_s(limits: StageLimits) -> float:
    """Time in which a stage that slows down as hard as it may stands, plus 20 % plus a second."""
    return 1.2 * limits.max_velocity_mm_s / limits.max_acceleration_mm_s2 + 1.0


def _limit_s(profile: MotionProfile, distance_mm: float) -> float:
    return 1.2 * profile.duration_s(distance_mm) + 1.0


def _place(status: Status) -> float:
    assert status.mm is not None  # noqa: S101 (a stage that stands tells where)
    return status.mm
