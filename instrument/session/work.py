"""What the thread of a run does: prepare, acquire, come to rest, close the file."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Final

from instrument.acquisition import AlignedBlock, Devices, Outcome, Phase, acquire, prepare
from instrument.config import DetectorSection, OnAbort
from instrument.frame_times import frame_middle_s
from instrument.plan import Plan
from instrument.recording import TimingReport
from instrument.schemes import scheme_of
from instrument.session.aborting import AbortRequest
from instrument.session.errors import RunAborted, RunStopped
from instrument.session.events import BlockEvent, Event, FindingEvent, PhaseEvent, UploadEvent
from instrument.session.safety import make_safe, stop_at_once
from instrument.session.stop_rules import Light, StopRules
from instrument.storage import Keeper, RecordingWriter, Rescue, made_in_time
from protocols import CountBlock, ModulatorTiming, Motion, PatternSequence, SafeStateFailed

_FINDINGS: Final = 20  # patterns told one by one; all are in the timing report


@dataclass(frozen=True, eq=False)
class Job:
    """A run that has passed its checks, and has not begun."""

    plan: Plan
    sequence: PatternSequence
    devices: Devices
    path: Path
    overwrite: bool
    on_abort: OnAbort
    description: str
    """JSON of the bench."""

    detector: DetectorSection | None = None
    """What was measured of the detector, which counts more than what its driver states."""


@dataclass(frozen=True, eq=False)
class Ending:
    """How a run ended."""

    error: BaseException | None
    """What ended it early."""

    kept: str
    """What was kept, in words."""

    path: Path | None = None
    """The recording; None where nothing is kept."""

    report: TimingReport | None = None
    """The timing audit; None where the run broke before it."""


class _Host:
    """``acquisition.Host``: hands blocks over to be kept first, then tells whoever listens; ends the run that is aborted."""

    def __init__(self, job: Job, publish: Callable[[Event], None], abort: AbortRequest) -> None:
        self._job = job
        self._publish = publish
        self._findings = 0
        self.abort = abort
        self.keeper: Keeper | None = None
        self.stored = 0
        """Patterns handed over to be kept."""
        self._rules = StopRules(job.plan, _light(job))
        self._stopped: RunStopped | None = None
        self._photon_counts = False

    def tell(self, phase: Phase) -> None:
        self._publish(PhaseEvent(phase=phase))

    def phase(self, phase: Phase) -> None:
        self.checkpoint()
        self.tell(phase)

    def uploaded(self, stored: int, total: int) -> None:
        self._publish(UploadEvent(stored=stored, total=total))
        self.checkpoint()

    def raw(self, block: CountBlock) -> None:
        self._photon_counts = block.photon_counts
        if self.keeper is not None:
            self.keeper.raw(block)

    def placed(self, block: AlignedBlock) -> None:
        if self.keeper is not None:
            self.stored += len(block.values)
            self.keeper.placed(block.values, block.edge_time_s)
        self._publish(BlockEvent.of(block))
        if self._stopped is None:
            self._stopped = self._rules.see(block.values, block.valid, photon_counts=self._photon_counts)
        if self.keeper is not None and self.keeper.writer.name_taken is not None:
            raise self.keeper.writer.name_taken
        for message in chain(
            (f"pattern {k}: its sync edge is missing" for k in block.gaps.tolist()),
            (f"pattern {k}: a surplus sync edge came" for k in block.doubles.tolist()),
            (f"pattern {k}: its length is off by more than a quarter" for k in block.irregular.tolist()),
        ):
            if self._findings < _FINDINGS:
                self.find(message)

    def find(self, message: str) -> None:
        self._findings += 1
        self._publish(FindingEvent(message=message))

    def checkpoint(self) -> None:
        self.abort.check()
        if self.keeper is not None:
            self.keeper.check()
        if self._stopped is not None and self.stored < self._job.sequence.n_patterns:
            raise self._stopped

    def broke(self) -> None:
        stop_at_once(self._job.devices, self._job.on_abort)


def carry_out(
    job: Job,
    publish: Callable[[Event], None],
    abort: AbortRequest,
    on_file: Callable[[RecordingWriter], None] = lambda _writer: None,
) -> Ending:
    """Carry out a run to whatever end, and leave devices at rest and the file closed.

    Nothing is raised: what ended the run early is in the ending, with notes that say what is kept. Devices are made safe
    before the file is closed.

    Args:
        job: what to do.
        publish: told of everything; must return at once and never raise.
        abort: may end it.
        on_file: called with the writer of the recording, to be looked at and not to be called.
    """
    host = _Host(job, publish, abort)
    if job.devices.scene is not None:
        job.devices.scene.use_grid(job.sequence.grid)
    try:
        host.checkpoint()
        timing = prepare(job.plan, job.sequence, job.devices, host)
        host.checkpoint()  # an older recording is not overwritten for nothing
        writer = _writer(job, timing)
        host.keeper = keeper = Keeper(writer)
        on_file(writer)
        for left in writer.removed:
            host.find(f"{left} was left behind by a program that ended early, and is removed")
    except BaseException as early:  # noqa: BLE001 - it is told to whoever waits
        abort.close()
        ended_by = _at_rest(job, host, early, None)
        ended_by.add_note(kept := "nothing was recorded")
        return Ending(ended_by, kept)
    outcome = acquire(
        job.plan,
        timing,
        job.devices,
        host,
        patterns=job.sequence.n_patterns,
        patterns_per_frame=job.plan.patterns_per_frame,
        scheme=scheme_of(job.plan),
    )
    abort.close()
    error = outcome.error
    if error is not None:
        error = _at_rest(job, host, error, outcome.motion)
    host.tell("storing")
    for note in outcome.report.notes:
        host.find(note)
    return _stored(job, host, keeper, outcome, error)


def _light(job: Job) -> Light:
    """What the bench has for too bright and for dark: what was measured counts more than what the driver states."""
    limits, found = job.devices.counter.limits, job.detector
    return Light(limits.max_count_rate_hz, limits.dark_rate_hz if found is None else found.dark_rate_hz.value)


def _writer(job: Job, timing: ModulatorTiming) -> RecordingWriter:
    limits, found = job.devices.counter.limits, job.detector
    dead_time = None if found is None else found.dead_time_s
    make = partial(
        RecordingWriter,
        job.path,
        job.plan,
        picture_time_s=timing.picture_time_us * 1e-6,
        bench=job.description,
        devices=job.devices.identities(),
        dead_time_s=limits.dead_time_s if dead_time is None else dead_time.value,
        dark_rate_hz=_light(job).dark_rate_hz,
        with_truth=job.devices.scene is not None,
        overwrite=job.overwrite,
    )
    return made_in_time(job.path, make)


def _stored(job: Job, host: _Host, keeper: Keeper, outcome: Outcome, error: BaseException | None) -> Ending:
    """Close the file, after the devices are at rest; what ended the run early may be that."""
    report, writer, rescue = outcome.report, keeper.writer, None
    if not host.stored and not report.bins_received:
        keeper.discard()
        kept, path = "nothing was recorded", None
    else:
        rescue = _finished(job, keeper, host.stored, outcome, error)
        kept, path = _kept(job, host.stored, report.bins_received, writer.path, rescue), writer.path
    failure = writer.name_taken if rescue is None else rescue.error
    if error is None and failure is not None:
        error = _at_rest(job, host, failure, outcome.motion)
    elif rescue is not None and error is not rescue.error and error is not None:
        error.add_note(str(rescue.error))
    if error is not None:
        error.add_note(kept)
    return Ending(error, kept, path, report)


def _kept(job: Job, stored: int, bins: int, path: Path, rescue: Rescue | None) -> str:
    """What is kept, in words."""
    if rescue is not None:
        return _saved(job, stored, path, rescue)
    if stored:
        return f"{stored} of {job.sequence.n_patterns} patterns are kept in {path}"
    return f"no pattern could be told apart; {bins} raw counts are kept in {path}"


def _saved(job: Job, stored: int, path: Path, rescue: Rescue) -> str:
    """What is kept of a run that the disk did not take, in words."""
    counted = f"{stored} of {job.sequence.n_patterns} patterns were counted"
    before = f"those before {rescue.kept_until} had been written to {path}"
    if rescue.lost:
        return f"{counted}; {before}, and all others are lost: they could be written nowhere ({rescue.lost})"
    if rescue.error.cut and rescue.journal is not None:
        files = " and ".join(str(file) for file in (rescue.journal, rescue.spill) if file is not None)
        return f"{counted}; they are in {files}; make the recording anew with `kinopix recover {path}`"
    if rescue.error.cut:
        after = "" if rescue.spill is None else f"; those from {rescue.kept_until} on are in {rescue.spill}"
        return f"{counted}; {before}, of which no more is left than the other program has left{after}"
    if rescue.spill is None:
        return f"{counted}, and had been written to {path}; close it with `kinopix recover {path}`"
    beside = "" if rescue.spill.parent == path.parent else f" --spill {rescue.spill}"
    doubt = f" (which may not survive a power cut: {rescue.doubt})" if rescue.doubt else ""
    return (
        f"{counted}; {before}, the others are in {rescue.spill}{doubt}; join them with `kinopix recover {path}{beside}`"
    )


def _at_rest(job: Job, host: _Host, broken_by: BaseException, motion: Motion | None) -> BaseException:
    """Make the bench safe after an error, and give what to raise: devices that could not be made safe are worse than it."""
    error = broken_by
    if host.abort.why is not None and not isinstance(error, RunAborted):
        error = RunAborted(host.abort.why)
        error.__cause__ = broken_by  # a motion that was stopped, a modulator that was halted
    host.tell("making safe")
    try:
        make_safe(job.devices, job.on_abort, motion)
    except SafeStateFailed as unsafe:
        unsafe.add_note(f"it came after: {error or type(error).__name__}")
        unsafe.__cause__ = error
        error = unsafe
    return error


def _finished(job: Job, keeper: Keeper, stored: int, outcome: Outcome, error: BaseException | None) -> Rescue | None:
    """Let the keeper finish the recording; give what became of it if the disk did not take it."""
    per_frame, scene = job.plan.patterns_per_frame, job.devices.scene
    frames = -(-stored // per_frame)
    frame_valid = outcome.frame_valid[:frames].copy()
    frame_valid[stored // per_frame :] = False  # what was counted and could not be stored
    middle_s = frame_middle_s(frames, per_frame * keeper.writer.picture_time_s)
    return keeper.finish(
        frame_valid=frame_valid,
        report=outcome.report.model_dump_json(),
        truth=scene.truth(middle_s) if scene is not None and frames else None,
        stage=None if outcome.stage is None else outcome.stage.rows,
        interrupted=_reason(error),
    )


def _reason(error: BaseException | None) -> str:
    """What the recording says of why it is partial; nothing for a run that came to its end."""
    if isinstance(error, RunStopped):
        return f"stopped: {error.why}"
    if isinstance(error, RunAborted):
        return f"aborted: {error.why}"
    return "" if error is None else str(error) or type(error).__name__
