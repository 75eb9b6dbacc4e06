"""Every check that a recording can be given: whether it is whole, and whether it is what was measured."""

from pathlib import Path
from typing import Final

import numpy as np

from instrument.acquisition.check_report import Check, CheckReport
from instrument.acquisition.recount import recount
from instrument.recording import Recording, TimingReport
from instrument.storage import RawCounts, RecordingInfo, open_recording, raw_counts, recording_info
from protocols import Floats, InputError, Mask, ProtocolViolation

_WRONG: Final = 2
_NOT_WHOLE: Final = 3


def check_recording(path: str | Path) -> tuple[CheckReport, int]:
    """Verify a recording: structure, checksums, values against raw counts, timing audit, completeness. It is not changed.

    Returns:
        The checks, and the command's exit code for them: 0 where all is well; 3 for numbers that are sound but not a whole,
        good run; 2 for numbers that cannot be trusted.

    Raises:
        InputError: no recording, or one that cannot be read at all.
    """
    info = recording_info(path)
    checks = [_completeness(info)]
    try:
        recording, raw = open_recording(path), raw_counts(path)
    except InputError as error:
        return CheckReport((*checks, Check("numbers", "error", str(error), error))), _WRONG
    checks += [
        Check("structure", "good", f"{len(recording)} frames of {recording.plan.patterns_per_frame} patterns"),
        _checksums(raw),
        counted := _recount(recording, raw),
        _timing(recording.timing, whole=info.state == "complete"),
    ]
    report = CheckReport(tuple(checks))
    return report, _WRONG if counted.outcome == "error" else 0 if report.ok else _NOT_WHOLE


def _completeness(info: RecordingInfo) -> Check:
    planned = "?" if info.plan is None else info.plan.frames
    if info.state == "complete":
        return Check("completeness", "good", f"whole: {info.frames} of {planned} frames, from {info.start_time}")
    why = {
        "interrupted": f"interrupted: {info.interrupted}",
        "being recorded": f"being recorded by process {info.process_id}",
        "cut off": f"cut off: its program ended without closing it; `kinopix recover {info.path}` closes it",
    }[info.state]
    return Check("completeness", "error", f"{info.frames} of {planned} frames; {why}")


def _checksums(raw: RawCounts) -> Check:
    if not raw.checksums:
        return Check("checksums", "warning", "none: the file was not closed, or they were removed")
    return Check("checksums", "good", f"values and edge times agree with {raw.checksums} checksums (CRC-32)")


def _recount(recording: Recording, raw: RawCounts) -> Check:
    """Values and edge times must be what the raw counts give; of the last pattern the closing edge is not known."""
    name = "values against raw counts"
    if not len(raw.counts):
        return Check(name, "warning", "no raw counts are kept")
    patterns = recording.plan.patterns
    try:
        again, edges = recount(raw.counts, raw.edge_time_s, picture_time_s=recording.picture_time_s, patterns=patterns)
    except ProtocolViolation as error:
        return Check(name, "error", str(error), error)
    values = recording.values.ravel()
    known = np.flatnonzero(np.isfinite(values))
    stored = int(known[-1]) + 1 if len(known) else 0
    times = np.full(len(values), np.nan) if recording.edge_time_s is None else recording.edge_time_s.ravel()
    compared = max(0, min(stored, len(again)) - 1)
    wrong = np.flatnonzero(_differ(values, again, compared) | _differ(times, edges, compared))
    if stored > len(again) + 1:
        wrong = np.append(wrong, len(again))
    if len(wrong):
        saw = f"{len(wrong)} of {stored} values that {len(raw.counts)} raw counts do not give, the first is pattern {wrong[0]}"
        other = InputError(saw=saw, expected="the counts of the run", remedy="take the file from a backup")
        return Check(name, "error", saw, other)
    return Check(name, "good", f"{compared + 1} values counted again from {len(raw.counts)} raw counts, all the same")


def _differ(stored: Floats, again: Floats, compared: int) -> Mask:
    one, other = stored[:compared], again[:compared]
    return np.asarray((one != other) & ~(np.isnan(one) & np.isnan(other)))


def _timing(report: TimingReport | None, *, whole: bool) -> Check:
    if report is None:
        return Check("timing audit", "warning", "none is kept" if whole else "none: the run was cut off before it")
    told = f"{report.verdict}: {report.frames_masked} of {report.frames} frames masked"
    match report.verdict:
        case "good":
            return Check("timing audit", "good", told)
        case "flagged" | "partial":
            return Check("timing audit", "warning", told)
        case "failed":
            return Check("timing audit", "error", told)
