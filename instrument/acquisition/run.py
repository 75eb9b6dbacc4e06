"""One run: load, arm, move, start, read until the last pattern, and tell what happened."""

import math
from dataclasses import dataclass
from typing import Final, Literal, Protocol, TypeAlias

from instrument.acquisition.alignment import AlignedBlock, Aligner
from instrument.acquisition.audit import TimingAudit
from instrument.acquisition.devices import Devices
from instrument.acquisition.stage_watch import StageWatch
from instrument.plan import Plan
from instrument.recording import StageLog, TimingReport
from instrument.roles import STAGE
from instrument.schemes import Scheme
from protocols import (
    CountBlock,
    CounterReport,
    CounterRun,
    DeviceError,
    KinopixError,
    Mask,
    ModulatorTiming,
    Motion,
    PatternModulator,
    PatternSequence,
    TimingFault,
    TriggerMissed,
)

START_MARGIN_S: Final = 1.0
"""How long a modulator may take from ``start`` to its first picture."""

STALL_PERIODS: Final = 100
"""So many periods without an edge are a stall."""

STALL_MARGIN_S: Final = 0.2
"""What the host's own scheduling and the USB may add to that."""

LONGEST_NAP_S: Final = 0.05
"""How long the run-up is slept through without a look at whether the run is to end."""


Phase: TypeAlias = Literal[
    "uploading", "positioning", "arming", "running up", "counting", "coming to rest", "making safe", "storing"
]
"""What a run is about, in this order; ``making safe`` only where it broke off."""


class Host(Protocol):
    """Whoever a run is carried out for: stores its blocks, is told how it goes, and may end it."""

    def phase(self, phase: Phase) -> None:
        """Take note of what begins now. What it raises ends the run."""

    def uploaded(self, stored: int, total: int) -> None:
        """Take note of unique patterns stored. What it raises ends the run."""

    def raw(self, block: CountBlock) -> None:
        """Take a block as the counter gave it. Called before anything is done with it."""

    def placed(self, block: AlignedBlock) -> None:
        """Take the same block with its patterns in place."""

    def checkpoint(self) -> None:
        """Raise what is to end the run now. Called wherever the run can be ended."""

    def broke(self) -> None:
        """Stop what moves and shows, at once: the run broke. Called before the counter is disarmed; never raises."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a run gave beside its values."""

    report: TimingReport
    """The timing audit."""

    frame_valid: Mask
    """``(frames,)`` recorded; the last one may be begun only, and is then masked."""

    motion: Motion | None = None
    """The stage's motion, over or not; None where the plan has none."""

    stage: StageLog | None = None
    """Where the stage was, as its controller told; None where it told nothing."""

    error: BaseException | None = None
    """What ended the run early; what was recorded until then is good."""


def prepare(
    plan: Plan,
    sequence: PatternSequence,
    devices: Devices,
    host: Host,
) -> ModulatorTiming:
    """Load the patterns and bring the stage to where its motion starts.

    Args:
        plan: a plan that has passed its checks.
        sequence: its patterns, for the modulator's geometry.
        devices: open, and at rest.
        host: told how it goes; may end it.

    Returns:
        The timing that the modulator will keep.

    Raises:
        KinopixError: the modulator refused to load, or the stage to move.
    """
    host.phase("uploading")
    timing = devices.modulator.load(sequence, ModulatorTiming(picture_time_us=plan.picture_time_us), host.uploaded)
    if plan.motion is not None:
        host.phase("positioning")
        moving = devices.stage.move_to(plan.motion.start_mm, plan.motion.profile)
        host.checkpoint()
        moving.wait()
    return timing


def acquire(
    plan: Plan,
    timing: ModulatorTiming,
    devices: Devices,
    host: Host,
    *,
    patterns: int,
    patterns_per_frame: int,
    scheme: Scheme | None = None,
) -> Outcome:
    """Carry out a plan that was prepared.

    Nothing is raised: whatever ends the run early comes back as ``Outcome.error``, with the audit of what was recorded. What
    moves and shows is stopped first then (``Host.broke``). Making the devices safe for good is the caller's task.

    Args:
        plan: the run.
        timing: as ``prepare`` gave it.
        devices: prepared.
        host: gets every block as it comes; may end the run.
        patterns: in the play order, without the guard picture.
        patterns_per_frame: of the scheme.
        scheme: by which the audit asks the values themselves whether they slipped; None asks the edges alone.
    """
    period_s = timing.picture_time_us * 1e-6
    audit = TimingAudit(
        patterns=patterns,
        patterns_per_frame=patterns_per_frame,
        picture_time_s=period_s,
        max_count_rate_hz=devices.counter.limits.max_count_rate_hz,
        scheme=scheme,
    )
    reader = _Reader(devices, audit, host, patterns, period_s)
    error: BaseException | None = None
    try:
        reader.run(plan)
    except BaseException as caught:  # noqa: BLE001 - whatever it is, what was recorded is kept and the caller is told
        error = caught
        # A stall leaves the patterns before it sure. Where all were played, or no edge was timed, any may be the lost one.
        sure = not isinstance(error, TriggerMissed) or (audit.timed and _still_playing(devices.modulator))
        host.broke()
        if isinstance(error, TriggerMissed):
            audit.edges_stayed_away()
        if not sure:
            audit.distrust(f"{patterns - audit.recorded} sync edges are missing and nothing tells which")
    try:
        told = devices.counter.disarm()
    except Exception as caught:  # noqa: BLE001 - as above
        told, error = CounterReport(bins_closed=reader.bins, notes=(str(caught),)), error or caught
    return Outcome(audit.report(told), audit.frame_valid(told), reader.motion, reader.watch.log, error)


def _still_playing(modulator: PatternModulator) -> bool:
    try:
        return modulator.running
    except KinopixError:
        return True  # it broke off as well


class _Reader:
    """Reads one run to its end."""

    def __init__(self, devices: Devices, audit: TimingAudit, host: Host, patterns: int, period_s: float) -> None:
        self._devices = devices
        self._audit = audit
        self._host = host
        self._patterns = patterns
        self._aligner = Aligner(period_s, patterns)
        # Room for bins that surplus edges split, so that they do not take the last patterns' place.
        room = patterns + patterns // 100 + 16
        most = devices.counter.limits.max_bins
        n_bins = room if most is None else min(room, most)
        self._armed = CounterRun(n_bins=n_bins, n_expected=min(patterns, n_bins), period_s=period_s)
        self.bins = 0
        self._plays_until_s = 0.0
        stage = devices.stage if STAGE.name in devices.by_role else None
        waiting = devices.counter.limits.max_unread_bins
        self.watch = StageWatch(stage, devices.clock, unread_s=math.inf if waiting is None else waiting * period_s)
        self.motion: Motion | None = None

    def run(self, plan: Plan) -> None:
        modulator, counter, host = self._devices.modulator, self._devices.counter, self._host
        host.phase("arming")
        self.watch.look()
        counter.arm(self._armed)
        if plan.motion is not None:
            host.phase("running up")
            self.motion = self._devices.stage.move_to(plan.motion.end_mm(plan.run_time_s), plan.motion.profile)
            self._run_up(plan.motion.run_up_s)
        host.phase("counting")
        modulator.start()
        self.watch.started()
        self._plays_until_s = self._devices.clock.now_s() + self._patterns * self._armed.period_s
        host.checkpoint()
        self._read_all()
        host.phase("coming to rest")
        modulator.wait(STALL_MARGIN_S + STALL_PERIODS * self._armed.period_s)
        if self.motion is not None:
            self.watch.take(self.motion.wait())

    def _run_up(self, run_up_s: float) -> None:
        clock = self._devices.clock
        end_s = clock.now_s() + run_up_s
        while (left_s := end_s - clock.now_s()) > 0:
            self._host.checkpoint()
            clock.sleep_s(min(left_s, LONGEST_NAP_S))

    def _read_all(self) -> None:
        # Both waits follow from the run's own figures: the first edge may need START_MARGIN_S, any other STALL_PERIODS periods.
        patience_s = self._armed.latency_s + STALL_MARGIN_S + STALL_PERIODS * self._armed.period_s
        while self._aligner.patterns < self._patterns:
            waited_s = patience_s if self.bins else patience_s + START_MARGIN_S
            block = self._read(waited_s)
            if len(block):
                self._take(block)
            if self.motion is not None and len(block):
                self.watch.look_again()
            self._host.checkpoint()
            if not len(block):
                self._aligner.place(block)  # which tells a block that was lost from edges that never came
                raise self._nothing_came(waited_s)

    def _read(self, patience_s: float) -> CountBlock:
        """Wait for a block. Where none comes for a moment, a modulator that was halted is not waited for any longer."""
        moment_s = self._armed.latency_s + STALL_PERIODS * self._armed.period_s
        if not self.bins or moment_s >= patience_s:
            return self._devices.counter.read(patience_s)
        block = self._devices.counter.read(moment_s)
        return block if len(block) or self._halted() else self._devices.counter.read(patience_s - moment_s)

    def _halted(self) -> bool:
        """Whether the modulator plays no more, though the time of its last picture has not come."""
        devices = self._devices
        return devices.clock.now_s() < self._plays_until_s and not _still_playing(devices.modulator)

    def _nothing_came(self, waited_s: float) -> KinopixError:
        if self.bins >= self._armed.n_bins:
            return TimingFault(
                device=self._devices.counter.identity.name,
                saw=f"{self.bins} bins that make only {self._aligner.patterns} of {self._patterns} patterns",
                expected="one sync edge a pattern",
                remedy="look for bounces on the sync line, and compare the picture time with the counter's own timebase",
            )
        if self._halted():
            return DeviceError(
                device=self._devices.modulator.identity.name,
                saw=f"a modulator that plays no more after {self._aligner.patterns} of {self._patterns} patterns",
                expected="a modulator that plays to its end",
                remedy="find out who halted it: a script must leave the devices alone while a run goes on",
            )
        return TriggerMissed(
            self._devices.counter.identity.name,
            bins_read=self._aligner.patterns,
            bins_expected=self._patterns,
            waited_s=waited_s,
        )

    def _take(self, block: CountBlock) -> None:
        self._host.raw(block)
        placed = self._aligner.place(block)
        self.bins += len(block)
        self._audit.see(placed, bins=len(block), photon_counts=block.photon_counts)
        self._host.placed(placed)
