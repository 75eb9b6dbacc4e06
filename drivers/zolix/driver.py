"""The stage as the framework sees it: ``protocols.LinearStage`` on a Zolix controller."""

import math
from collections.abc import Callable
from typing import Final, Self

import serial

from drivers.serial_line import open_port
from drivers.zolix.controller import Controller, Reading
from drivers.zolix.events import BAUD, Codec
from drivers.zolix.mc600 import Mc600Codec
from drivers.zolix.motion import ZolixMotion
from drivers.zolix.probe import DialectName, probe
from drivers.zolix.sc300 import Sc300Codec
from drivers.zolix.settings import Ka400zSettings
from drivers.zolix.wire import Wire
from protocols import (
    BenchContext,
    DeviceBusy,
    DeviceError,
    DeviceIdentity,
    DeviceTimeout,
    InputError,
    MotionProfile,
    PlanError,
    StageLimits,
    StagePosition,
    WrongState,
)

_NAME: Final = "stage"

_BEGINS_S: Final = 2.0
"""Longest time from the call to the command on the line: a quiet line, a fence and the bytes themselves."""


class Ka400z:
    """A Zolix KA400Z on an MC600 or SC300 controller.

    ``context.transport``, where given, is an open pyserial port or a pyserial URL, and takes the place of ``settings.port``.

    Raises:
        InputError: neither port nor transport, or an axis that the controller has not.
        DriverUnavailable: the port cannot be opened, or no known controller answers.
    """

    def __init__(self, settings: Ka400zSettings, context: BenchContext) -> None:
        self._settings = settings
        self._clock = context.clock
        self._motion: ZolixMotion | None = None
        self._standing_mm: float | None = None
        self._homed = False
        self._closed = False
        self._stands_by_s = context.clock.now_s()
        port = open_port(settings.port, context.transport, device=_NAME, table="stage", baud=BAUD)
        try:
            dialect, firmware = probe(
                port,
                context.clock,
                device=_NAME,
                axis=settings.axis,
                dialect=None if settings.dialect == "auto" else settings.dialect,
                reply_s=settings.reply_margin_s,
                poll_s=settings.poll_s,
            )
            codec = _codec(dialect, settings)
            self._wire = Wire(
                port,
                codec,
                context.clock,
                device=_NAME,
                reply_margin_s=settings.reply_margin_s,
                poll_s=settings.poll_s,
            )
            self._controller = Controller(self._wire, codec, settings.scale)
            self._controller.set_up()
            self._standing()
        except BaseException:
            port.close()
            raise
        asks = settings.position_in_motion
        self._asks_in_motion = codec.answers_in_motion if asks == "auto" else asks == "ask"
        self._may_turn_out_mute = asks == "auto"
        self._identity = DeviceIdentity(
            name=_NAME,
            vendor="Zolix",
            model=f"KA400Z on {codec.name}",
            firmware=firmware,
            driver=f"ka400z ({dialect}), pyserial {serial.__version__}",
            simulated=context.transport is not None,
        )

    @property
    def identity(self) -> DeviceIdentity:
        """Identity of the stage and of its controller."""
        return self._identity

    @property
    def limits(self) -> StageLimits:
        """Travel, velocity, acceleration, as bench.toml allows them."""
        return self._settings.limits

    @property
    def homed(self) -> bool:
        """Whether the stage has been homed since it was opened, and no unexplained stop came after."""
        if self._motion is not None:
            _ = self._motion.done
        return self._homed

    @property
    def stands_by_s(self) -> float:
        """Moment by which every motion command that was sent is carried out, even if no stop is obeyed."""
        return self._stands_by_s

    def check(self, target_mm: float, profile: MotionProfile) -> None:
        """Raise what ``move_to`` would raise for this target and profile, and move nothing.

        Raises:
            TravelExceeded: the target is outside ``travel_mm``, or not a number.
            MotionTooFast: velocity, acceleration or start velocity too high.
            PlanError: so slow that it rounds to no pulse a second.
        """
        self.limits.check_target(target_mm, _NAME)
        self.limits.check_profile(profile, _NAME)
        velocity, acceleration = profile.velocity_mm_s, profile.acceleration_mm_s2
        scale = self._settings.scale
        if min(scale.pulses(velocity), scale.pulses(acceleration)) < 1:
            raise PlanError(
                device=_NAME,
                saw=f"{velocity:g} mm/s and {acceleration:g} mm/s^2",
                expected=f"at least {scale.mm(1):g} mm/s and mm/s^2, one pulse a second",
                remedy="raise velocity or acceleration in plan.toml",
            )

    def position(self) -> StagePosition:
        """Where the stage is now: asked where the controller answers, predicted (and marked so) where it is mute.

        Raises:
            DeviceTimeout: no answer; names what was awaited and what came.
            ProtocolViolation: answers that contradict each other.
        """
        with self._wire.turn:
            motion = self._motion
            if motion is not None and not motion.done:
                return self._on_the_way(motion)
            reading = self._standing()
        return StagePosition(
            time_s=reading.time_s,
            commanded_mm=reading.mm if motion is None else motion.target_mm,
            reported_mm=reading.mm,
        )

    def move_to(self, target_mm: float, profile: MotionProfile) -> ZolixMotion:
        """Start a move to an absolute position and return at once.

        After a stop, waits first until the stage stands. A move shorter than half a pulse is over at once; no motion
        command is sent for it.

        Raises:
            TravelExceeded, MotionTooFast: outside the limits; nothing was sent.
            DeviceBusy: another motion is under way.
            WrongState: not homed, where ``require_home`` is set.
            DeviceRefused: the controller does not take a command.
            DeviceTimeout: the controller does not answer; a stop has been sent where the move may have begun.
        """
        stops = self._wire.stops
        self.check(target_mm, profile)
        with self._wire.turn:
            self._free()
            return self._move(self._standing(), target_mm, profile, relative=False, stops=stops)

    def move_by(self, distance_mm: float, profile: MotionProfile) -> ZolixMotion:
        """Start a move relative to where the stage stands; as ``move_to`` otherwise."""
        stops = self._wire.stops
        with self._wire.turn:
            self._free()
            here = self._standing()
            self.check(here.mm + distance_mm, profile)
            return self._move(here, here.mm + distance_mm, profile, relative=True, stops=stops)

    def home(self) -> ZolixMotion:
        """Look for the origin. ``homed`` once the motion has ended at ``home_position_mm``.

        Raises:
            DeviceBusy, DeviceRefused, DeviceTimeout: as ``move_to``.
        """
        settings, stops = self._settings, self._wire.stops
        low, high = settings.travel_mm
        profile = MotionProfile(
            velocity_mm_s=settings.home_velocity_mm_s,
            acceleration_mm_s2=settings.max_acceleration_mm_s2,
            initial_velocity_mm_s=min(settings.initial_velocity_mm_s, settings.home_velocity_mm_s),
        )
        with self._wire.turn:
            self._free()
            motion = ZolixMotion(
                self._controller,
                start_mm=self._standing().mm,
                target_mm=settings.home_position_mm,
                profile=profile,
                limit_s=settings.home_timeout_s or _limit_s(profile, high - low),
                bounds_mm=(-math.inf, math.inf),  # homing may set the coordinate anew before it ends
                if_elsewhere="if the stage is at its origin, set home_position_mm to this; else look at its switches",
                stop_stage=self.stop,
                ended=self._home_ended,
            )
            self._homed = False
            self._start(motion, lambda: self._controller.begin_home(profile, stops=stops))
            return motion

    def stop(self) -> None:
        """Send the stop at once, from any thread; waits for no move, no lock of a reader, and no answer.

        Raises:
            DeviceDisconnected: the port is gone, so the stop could not be sent.
        """
        if self._closed:
            return
        self._wire.stop()
        if (motion := self._motion) is not None:
            motion.stop_sent()

    def __enter__(self) -> Self:
        """Give the open stage."""
        return self

    def __exit__(self, *exc: object) -> None:
        """Stop, and give the port back even if stopping fails."""
        if self._closed:
            return
        try:
            self.stop()
        finally:
            self._closed = True
            self._wire.close()

    def _move(
        self, here: Reading, target_mm: float, profile: MotionProfile, *, relative: bool, stops: int
    ) -> ZolixMotion:
        if self._settings.require_home and not self._homed:
            raise WrongState(
                device=_NAME,
                saw="a move of a stage that has not been homed",
                expected="homing first, as require_home asks",
                remedy="call home(), or set require_home = false in bench.toml",
            )
        speeds = self._settings.scale.speeds(self._own(profile))
        runs = self._settings.scale.profile(speeds)
        motion = ZolixMotion(
            self._controller,
            start_mm=here.mm,
            target_mm=target_mm,
            profile=runs,
            limit_s=_limit_s(runs, target_mm - here.mm),
            bounds_mm=(min(here.mm, target_mm), max(here.mm, target_mm)),
            if_elsewhere="look at the limit switches, move away from them and home: steps may be lost",
            stop_stage=self.stop,
            ended=self._move_ended,
        )
        scale = self._settings.scale
        if scale.pulses(target_mm) == scale.pulses(here.mm):
            self._motion = motion
            motion.finish_at(here)
            return motion
        self._controller.set_speeds(speeds)
        self._start(motion, lambda: self._controller.begin_move(here.mm, target_mm, relative=relative, stops=stops))
        return motion

    def _start(self, motion: ZolixMotion, begin: Callable[[], float]) -> None:
        self._motion = motion  # before the bytes leave, so that a stop from another thread finds it
        self._stands_by_s = self._clock.now_s() + _BEGINS_S + motion.limit_s
        try:
            motion.started_s = begin()
            self._stands_by_s = motion.started_s + motion.limit_s
        except DeviceTimeout:
            self.stop()  # the command may have arrived, though its answer did not
            raise
        except DeviceError:
            self._motion = None
            raise

    def _free(self) -> None:
        motion = self._motion
        if motion is None or motion.done:
            return
        if not motion.stopping:
            raise DeviceBusy(
                device=_NAME,
                saw=f"a motion to {motion.target_mm:g} mm under way",
                expected="a stage that stands",
                remedy="wait for that motion, or stop it",
            )
        motion.stand()

    def _standing(self) -> Reading:
        known = self._standing_mm
        reading = self._controller.ask_within(*((math.inf, -math.inf) if known is None else (known, known)))
        self._standing_mm = reading.mm
        return reading

    def _on_the_way(self, motion: ZolixMotion) -> StagePosition:
        if self._asks_in_motion:
            try:
                reading = self._controller.ask_within(*motion.bounds_mm)
            except DeviceTimeout:
                if not self._may_turn_out_mute:
                    raise
                self._asks_in_motion = False  # this controller is mute in motion: it is not asked again
            else:
                return StagePosition(time_s=reading.time_s, commanded_mm=motion.target_mm, reported_mm=reading.mm)
        now_s, here_mm = self._clock.now_s(), motion.predicted_mm()
        return StagePosition(time_s=now_s, commanded_mm=motion.target_mm, reported_mm=here_mm, predicted=True)

    def _move_ended(self, motion: ZolixMotion) -> None:
        self._standing_mm = motion.standing_mm
        if not (motion.reached or motion.stopping):
            self._homed = False  # an abrupt end may have lost steps

    def _home_ended(self, motion: ZolixMotion) -> None:
        self._standing_mm = motion.standing_mm
        self._homed = motion.reached

    def _own(self, profile: MotionProfile) -> MotionProfile:
        """``profile``, with the stage's own start velocity where it does not state one."""
        if "initial_velocity_mm_s" in profile.model_fields_set:
            return profile
        initial = min(self._settings.initial_velocity_mm_s, profile.velocity_mm_s)
        return profile.model_copy(update={"initial_velocity_mm_s": initial})


def _limit_s(profile: MotionProfile, distance_mm: float) -> float:
    return 1.2 * profile.duration_s(distance_mm) + 1.0


def _codec(dialect: DialectName, settings: Ka400zSettings) -> Codec:
    if dialect == "mc600":
        return Mc600Codec(settings.axis)
    if settings.axis == "T":
        raise InputError(
            device=_NAME,
            saw="axis T, and an SC300 on the line",
            expected="axis X, Y or Z",
            remedy="set axis in the [stage] table of bench.toml to the one the stage is plugged into",
        )
    return Sc300Codec(settings.axis)
