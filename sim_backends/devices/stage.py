"""A simulated linear stage: trapezoidal motion that carries the object on the optical bench."""

import threading
from dataclasses import dataclass
from typing import Self

import numpy as np
from pydantic import model_validator

from protocols import (
    BenchContext,
    DeviceBusy,
    DeviceError,
    DeviceIdentity,
    DeviceTimeout,
    DriverPlugin,
    Floats,
    Frozen,
    MotionProfile,
    StageLimits,
    StagePosition,
    WrongState,
)
from sim_backends.bench import BenchClock, OpticalBench
from sim_backends.bench.bounds import LengthMm, PlaceMm, StepMm
from sim_backends.devices.place import place

_NAME = "stage"


class StageSettings(Frozen):
    """Keys of ``[stage]``. The defaults are those of a 400 mm stage with a 5 mm lead, with room to spare in speed."""

    travel_mm: tuple[PlaceMm, PlaceMm] = (0.0, 400.0)
    """Lowest and highest position, in millimetres."""

    max_velocity_mm_s: LengthMm = 50.0
    """Highest velocity, in mm/s."""

    max_acceleration_mm_s2: LengthMm = 200.0
    """Highest acceleration, in mm/s^2."""

    resolution_mm: StepMm = 0.0025
    """Length of one step in millimetres: targets and positions are whole steps."""

    position_mm: PlaceMm = 0.0
    """Position of the stage when it is opened, in millimetres."""

    homed: bool = True
    """Whether the stage knows its origin when it is opened."""

    @model_validator(mode="after")
    def _inside(self) -> Self:
        low, high = self.travel_mm
        if not low <= self.position_mm <= high:
            msg = f"position_mm = {self.position_mm:g} is outside travel_mm = [{low:g}, {high:g}]"
            raise ValueError(msg)
        return self


@dataclass(frozen=True)
class _Move:
    """A move from standing to standing, unless somebody cuts it short."""

    from_mm: float
    to_mm: float
    profile: MotionProfile
    start_s: float
    cut_s: float | None = None

    @property
    def end_s(self) -> float:
        """When the stage stands."""
        whole_s = self.start_s + self.profile.duration_s(self.to_mm - self.from_mm)
        return whole_s if self.cut_s is None else min(self.cut_s, whole_s)

    def at_mm(self, clock_s: float) -> float:
        """Position at a moment, the one where it stands for all later ones."""
        elapsed_s = min(clock_s, self.end_s) - self.start_s
        return self.from_mm + self.profile.travelled_mm(self.to_mm - self.from_mm, elapsed_s)

    def path_mm(self, clock_s: Floats) -> Floats:
        """Positions at many moments."""
        return np.array([self.at_mm(moment_s) for moment_s in clock_s.tolist()])


class SimulatedMotion:
    """``protocols.Motion``: a handle on one move."""

    def __init__(self, stage: "SimulatedStage", move: _Move) -> None:
        self._stage = stage
        self._move = move

    @property
    def target_mm(self) -> float:
        """Position at which the motion is to end, in millimetres."""
        return self._move.to_mm

    @property
    def done(self) -> bool:
        """Whether the stage stands."""
        return self._stage.clock.now_s() >= self._move.end_s

    def wait(self, timeout_s: float | None = None) -> StagePosition:
        """Return the position when the stage stands; see ``protocols.Motion.wait``."""
        clock, move = self._stage.clock, self._move
        if timeout_s is None:
            timeout_s = 1.2 * (move.end_s - move.start_s) + 1.0
        clock.advance_to(min(move.end_s, clock.now_s() + timeout_s))
        if not self.done:
            done_mm = abs(move.at_mm(clock.now_s()) - move.from_mm)
            raise DeviceTimeout(
                _NAME,
                awaited=f"the stage at {move.to_mm:g} mm",
                waited_s=timeout_s,
                progress=f"{done_mm:.3f} of {abs(move.to_mm - move.from_mm):.3f} mm",
                remedy="wait longer, or stop the motion",
            )
        stands_mm = move.at_mm(move.end_s)
        if self._move.cut_s is not None:
            raise DeviceError(
                device=_NAME,
                saw=f"the stage stopped at {stands_mm:.3f} mm",
                expected=f"{move.to_mm:.3f} mm",
                remedy="find out who stopped it, then move again",
            )
        return self._stage.position()

    def stop(self) -> None:
        """Stop this motion; nothing happens where it is over."""
        self._stage.cut(self)

    def cut(self, now_s: float) -> None:
        """End the move here."""
        if now_s < self._move.end_s:
            self._move = _Move(self._move.from_mm, self._move.to_mm, self._move.profile, self._move.start_s, now_s)

    @property
    def move(self) -> _Move:
        """The move as it is known now."""
        return self._move


class SimulatedStage:
    """``protocols.LinearStage`` on the optical bench. A stop is immediate, without a ramp."""

    def __init__(self, settings: StageSettings, bench: OpticalBench) -> None:
        self._settings = settings
        self._bench = bench
        self._lock = threading.Lock()
        self._homed = settings.homed
        self._closed = False
        profile = MotionProfile(velocity_mm_s=1.0, acceleration_mm_s2=1.0)
        at_mm = settings.position_mm
        self._motion = SimulatedMotion(self, _Move(at_mm, at_mm, profile, bench.clock.now_s()))
        self._homing: SimulatedMotion | None = None
        bench.carry(self._motion.move.path_mm)

    @property
    def clock(self) -> BenchClock:
        """The bench's clock."""
        return self._bench.clock

    @property
    def identity(self) -> DeviceIdentity:
        """Identity of the simulated device."""
        return DeviceIdentity(
            name=_NAME, vendor="Kinopix", model="simulated KA400Z", driver="simulated", simulated=True
        )

    @property
    def limits(self) -> StageLimits:
        """Travel, velocity and acceleration, as set."""
        settings = self._settings
        return StageLimits(
            travel_mm=settings.travel_mm,
            max_velocity_mm_s=settings.max_velocity_mm_s,
            max_acceleration_mm_s2=settings.max_acceleration_mm_s2,
        )

    @property
    def homed(self) -> bool:
        """Whether the origin is known; true from the end of a whole homing motion on."""
        homing = self._homing
        return self._homed or (homing is not None and homing.done and homing.move.cut_s is None)

    @property
    def stands_by_s(self) -> float:
        """Moment by which the last motion is over, had nobody cut it short."""
        move = self._motion.move
        return move.start_s + move.profile.duration_s(move.to_mm - move.from_mm)

    def check(self, target_mm: float, profile: MotionProfile) -> None:
        """Raise what ``move_to`` would raise, and move nothing."""
        self.limits.check_target(target_mm, _NAME)
        self.limits.check_profile(profile, _NAME)

    def position(self) -> StagePosition:
        """Where the stage is now, in whole steps."""
        now_s, move = self.clock.now_s(), self._motion.move
        return StagePosition(time_s=now_s, commanded_mm=move.to_mm, reported_mm=self._steps(move.at_mm(now_s)))

    def _steps(self, position_mm: float) -> float:
        step_mm = self._settings.resolution_mm
        return round(position_mm / step_mm) * step_mm

    def move_to(self, target_mm: float, profile: MotionProfile) -> SimulatedMotion:
        """Start a move; see ``protocols.LinearStage.move_to``."""
        self.check(target_mm, profile)
        with self._lock:
            if self._closed:
                raise WrongState(
                    device=_NAME,
                    saw="a move after the device was closed",
                    expected="an open device",
                    remedy="open it anew",
                )
            if not self._motion.done:
                raise DeviceBusy(
                    device=_NAME,
                    saw=f"a move while the stage is on its way to {self._motion.target_mm:g} mm",
                    expected="a stage that stands",
                    remedy="wait for the motion, or stop it",
                )
            now_s = self.clock.now_s()
            move = _Move(self._motion.move.at_mm(now_s), self._steps(target_mm), profile, now_s)
            self._motion = SimulatedMotion(self, move)
            self._bench.carry(move.path_mm)
            return self._motion

    def move_by(self, distance_mm: float, profile: MotionProfile) -> SimulatedMotion:
        """Start a move relative to where the stage stands."""
        return self.move_to(self.position().reported_mm + distance_mm, profile)

    def home(self) -> SimulatedMotion:
        """Go to the end of the travel nearest to zero, where the origin is, at half of the highest velocity."""
        settings = self._settings
        low, high = settings.travel_mm
        profile = MotionProfile(
            velocity_mm_s=settings.max_velocity_mm_s / 2, acceleration_mm_s2=settings.max_acceleration_mm_s2 / 2
        )
        self._homing = self.move_to(min(max(0.0, low), high), profile)
        return self._homing

    def cut(self, motion: SimulatedMotion) -> None:
        """End ``motion`` now, if it is the one under way."""
        with self._lock:
            if motion is self._motion and not motion.done:
                motion.cut(self.clock.now_s())
                self._bench.carry(motion.move.path_mm)

    def stop(self) -> None:
        """Stop at once."""
        self.cut(self._motion)

    def __enter__(self) -> Self:
        """Give the open device."""
        return self

    def __exit__(self, *exc: object) -> None:
        """Stop and close."""
        self.stop()
        self._closed = True


def open_stage(settings: StageSettings, context: BenchContext) -> SimulatedStage:
    """Open the simulated stage on the context's optical bench."""
    return SimulatedStage(settings, place(context, _NAME))


plugin = DriverPlugin(summary="simulated stage on the optical bench", settings=StageSettings, open=open_stage)
"""Found as ``kinopix.stages: simulated``."""
