"""Each row of the table: the answer, what is kept, a safe bench, no hang, and the next run."""

import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from types import FrameType

import numpy as np
import pytest

from instrument.recording import Recording
from instrument.session import Instrument
from protocols import KinopixError, SafeStateFailed
from tests.faults.bench import Seen, bench_toml, carry_out, undisturbed
from tests.faults.row import Row
from tests.faults.table import TABLE

ROWS = [pytest.param(row, id=f"{device}: {row.fault}") for device, rows in TABLE.items() for row in rows]

PATIENCE_S = 10.0
"""More than an undisturbed run takes, on the bench's clock; every time-out of drivers and acquisition is far below."""


@pytest.fixture(autouse=True)
def _no_hang() -> Iterator[None]:
    """A loop in which the virtual clock stands still never ends: break it by the host's clock."""

    def give_up(_signal: int, _frame: FrameType | None) -> None:
        raise TimeoutError("the run hangs")

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(30)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("row", ROWS)
def test_every_fault_has_its_answer(row: Row, tmp_path: Path) -> None:
    if row.at_opening:
        with pytest.raises(KinopixError) as refused:
            Instrument.from_toml(bench_toml(row, tmp_path))
        check_error(row, refused.value)
        return
    bench = Instrument.from_toml(bench_toml(row, tmp_path))
    try:
        first = carry_out(bench, row, tmp_path / "first.h5")
        check(row, first)
        if row.again is not None:
            check_next(row, carry_out(bench, row, tmp_path / "second.h5"))
        if row.closing is None:
            bench.close()
        else:
            with pytest.raises(row.closing):
                bench.close()
    finally:
        with suppress(KinopixError):
            bench.close()


def check(row: Row, seen: Seen) -> None:
    if row.error is None:
        assert seen.error is None, seen.error
    else:
        assert isinstance(seen.error, KinopixError)
        check_error(row, seen.error)
    check_bench(row, seen)
    if row.patterns == 0:
        assert seen.recording is None or len(seen.recording) == 0
    else:
        assert seen.recording is not None
        check_recording(row, seen.recording)


def check_error(row: Row, error: KinopixError) -> None:
    assert type(error) is row.error, error
    assert error.exit_code in (2, 3)
    assert error.device
    assert error.remedy
    for part in row.says:
        assert part in str(error), error
    if isinstance(error, SafeStateFailed):
        assert type(error.__cause__) is row.after
    notes = " ".join(getattr(error, "__notes__", ()))
    if row.at_opening:
        return
    told = f"{row.patterns} of {6 * row.frames} patterns are kept" if row.patterns else "nothing was recorded"
    assert told in notes


def check_bench(row: Row, seen: Seen) -> None:
    assert seen.dark
    assert seen.drift_mm == 0.0
    assert seen.took_s < undisturbed(row.frames, row.pattern_rate_hz)[1] + PATIENCE_S


def check_recording(row: Row, recording: Recording) -> None:
    report, clean = recording.timing, undisturbed(row.frames, row.pattern_rate_hz)[0]
    assert report is not None
    assert (report.verdict, report.patterns_recorded) == (row.verdict, row.patterns)
    assert row.gaps in (report.gaps, None)
    assert row.doubles in (report.doubles, None)
    if row.error is None:
        for part in row.says:
            assert any(part in note for note in report.notes), report.notes
    frames = np.arange(len(recording))
    whole = frames < row.patterns // 6
    good = np.zeros(len(frames), bool) if row.masked == "all" else whole & ~np.isin(frames, row.masked)
    np.testing.assert_array_equal(recording.frame_valid, good)
    values = recording.values.ravel()
    assert np.isnan(values[row.patterns :]).all()
    ends_early = row.patterns < len(clean) and row.masked != "all"
    sure = np.arange(len(values)) < row.patterns if ends_early else np.repeat(good, 6)
    light = values * 1e3 if row.counter == "ni-analog" else values  # its emulator gives a millivolt for each count
    ours, theirs = light[sure], clean[: len(values)][sure]
    if row.counts == "same":
        np.testing.assert_array_equal(ours, theirs)
    elif row.counts == "alike":
        # six standard deviations of the difference of two Poisson numbers
        assert (np.abs(ours - theirs) <= 6 * np.sqrt(ours + theirs + 1)).all()
    else:
        assert (ours != theirs).any()


def check_next(row: Row, seen: Seen) -> None:
    if row.again == "as before":
        check(row, seen)
        return
    check_bench(row, seen)
    if row.again == "good":
        assert seen.error is None, seen.error
        assert seen.recording is not None
        check_recording(Row(fault=row.fault, frames=row.frames, pattern_rate_hz=row.pattern_rate_hz), seen.recording)
    else:
        assert type(seen.error) is row.again, seen.error
