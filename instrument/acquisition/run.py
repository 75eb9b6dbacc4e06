"""One run: load, arm, move, start, read until the last pattern, and tell what happened."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

from instrument.acquisition.alignment import AlignedBlock, Aligner
from instrument.acquisition.audit import TimingAudit
from instrument.plan import Plan
from instrument.recording import TimingReport
from protocols import (
    Clock,
    CountBlock,
    CounterReport,
    CounterRun,
    KinopixError,
    LinearStage,
    Mask,
    ModulatorTiming,
    Motion,
    PatternModulator,
    PatternSequence,
    PhotonCounter,
    TimingFault,
    TriggerMissed,
)

START_MARGIN_S: Final = 1.0
"""How long a modulator may take from ``start`` to its first picture."""

STALL_PERIODS: Final = 100
"""So many periods without an edge are a stall."""

STALL_MARGIN_S: Final = 0.2
"""What the host's own scheduling and the USB may add to that."""


@dataclass(frozen=True)
class Devices:
    """The three devices of a bench and the clock they share."""

    modulator: PatternModulator
    counter: PhotonCounter
    stage: LinearStage
    clock: Clock


class Sink(Protocol):
    """Where blocks go while the run goes on: the file first, then whoever looks on."""

    def raw(self, block: CountBlock) -> None:
        """Take a block as the counter gave it. Called before anything is done with it."""

    def placed(self, block: AlignedBlock) -> None:
        """Take the same block with its patterns in place."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a run gave beside its values."""

    report: TimingReport
    """The timing audit."""

    frame_valid: Mask
    """``(frames,)`` recorded; the last one may be begun only, and is then masked."""

    motion: Motion | None = None
    """The stage's motion, over or not; None where the plan has none."""

    error: BaseException | None = None
    """What ended the run early; what was recorded until then is good."""


def prepare(
    plan: Plan,
    sequence: PatternSequence,
    devices: Devices,
    on_upload: Callable[[int, int], None] | None = None,
) -> ModulatorTiming:
    """Load the patterns and bring the stage to where its motion starts.

    Args:
        plan: a plan that has passed its checks.
        sequence: its patterns, for the modulator's geometry.
        devices: open, and at rest.
        on_upload: told of patterns stored and patterns in all.

    Returns:
        The timing that the modulator will keep.

    Raises:
        KinopixError: the modulator refused to load, or the stage to move.
    """
    timing = devices.modulator.load(sequence, ModulatorTiming(picture_time_us=plan.picture_time_us), on_upload)
    if plan.motion is not None:
        devices.stage.move_to(plan.motion.start_mm, plan.motion.profile).wait()
    return timing


def acquire(
    plan: Plan, timing: ModulatorTiming, devices: Devices, sink: Sink, *, patterns: int, patterns_per_frame: int
) -> Outcome:
    """Carry out a plan that was prepared.

    An error or an interrupt does not lose the run: it comes back as ``Outcome.error``, with the audit of what was recorded.
    Making the devices safe afterwards is the caller's task.

    Args:
        plan: the run.
        timing: as ``prepare`` gave it.
        devices: prepared.
        sink: gets every block as it comes.
        patterns: in the play order, without the guard picture.
        patterns_per_frame: of the scheme.
    """
    period_s = timing.picture_time_us * 1e-6
    audit = TimingAudit(
        patterns=patterns,
        patterns_per_frame=patterns_per_frame,
        picture_time_s=period_s,
        max_count_rate_hz=devices.counter.limits.max_count_rate_hz,
    )
    reader = _Reader(devices, audit, sink, patterns, period_s)
    error: BaseException | None = None
    try:
        reader.run(plan)
    except (KinopixError, KeyboardInterrupt) as caught:
        error = caught
    try:
        told = devices.counter.disarm()
    except KinopixError as caught:
        told, error = CounterReport(bins_closed=reader.bins, notes=(str(caught),)), error or caught
    if isinstance(error, TriggerMissed) and not (audit.timed and _still_playing(devices.modulator)):
        # A stall leaves the patterns before it sure. Where all were played, or no edge was timed, any edge may be the lost one.
        audit.distrust(f"{patterns - audit.recorded} sync edges are missing and nothing tells which")
    report = audit.report(told, photon_counts=reader.photon_counts)
    return Outcome(report, audit.frame_valid(), reader.motion, error)


def _still_playing(modulator: PatternModulator) -> bool:
    try:
        return modulator.running
    except KinopixError:
        return True  # it broke off as well


class _Reader:
    """Reads one run to its end."""

    def __init__(self, devices: Devices, audit: TimingAudit, sink: Sink, patterns: int, period_s: float) -> None:
        self._devices = devices
        self._audit = audit
        self._sink = sink
        self._patterns = patterns
        self._aligner = Aligner(period_s)
        # Room for bins that surplus edges split, so that they do not take the last patterns' place.
        room = patterns + patterns // 100 + 16
        most = devices.counter.limits.max_bins
        self._armed = CounterRun(n_bins=room if most is None else min(room, most), period_s=period_s)
        self.bins = 0
        self.photon_counts = False
        self.motion: Motion | None = None

    def run(self, plan: Plan) -> None:
        modulator, counter, stage = self._devices.modulator, self._devices.counter, self._devices.stage
        counter.arm(self._armed)
        if plan.motion is not None:
            self.motion = stage.move_to(plan.motion.end_mm(plan.run_time_s), plan.motion.profile)
            self._devices.clock.sleep_s(plan.motion.run_up_s)
        modulator.start()
        self._read_all()
        modulator.wait(STALL_MARGIN_S + STALL_PERIODS * self._armed.period_s)
        if self.motion is not None:
            self.motion.wait()

    def _read_all(self) -> None:
        # Both waits follow from the run's own figures: the first edge may need START_MARGIN_S, any other STALL_PERIODS periods.
        patience_s = self._armed.latency_s + STALL_MARGIN_S + STALL_PERIODS * self._armed.period_s
        while self._aligner.patterns < self._patterns:
            waited_s = patience_s if self.bins else patience_s + START_MARGIN_S
            block = self._devices.counter.read(waited_s)
            if not len(block) and self.bins >= self._armed.n_bins:
                raise TimingFault(
                    device=self._devices.counter.identity.name,
                    saw=f"{self.bins} bins that make only {self._aligner.patterns} of {self._patterns} patterns",
                    expected="one sync edge a pattern",
                    remedy="look for bounces on the sync line, and compare the picture time with the counter's own timebase",
                )
            if not len(block):
                raise TriggerMissed(
                    self._devices.counter.identity.name,
                    bins_read=self._aligner.patterns,
                    bins_expected=self._patterns,
                    waited_s=waited_s,
                )
            self._take(block)

    def _take(self, block: CountBlock) -> None:
        self._sink.raw(block)
        self.photon_counts = block.photon_counts
        placed = self._aligner.place(block)
        self.bins += len(block)
        self._audit.see(placed, bins=len(block), photon_counts=self.photon_counts)
        self._sink.placed(placed)
