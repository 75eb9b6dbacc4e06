"""``check_recording``: what a recording is held against, and what each kind of damage is called."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from instrument.acquisition.recount import recount
from instrument.session import Instrument, check_recording
from instrument.storage import layout
from protocols import InputError, KinopixError
from tests.support import plain_hdf5 as plain
from tests.support.benches import SMALL, bench_toml


def recorded(folder: Path, faults: str = "") -> Path:
    """A recording of 240 patterns; a run that broke is kept too."""
    toml = bench_toml(folder, faults)
    with Instrument.from_toml(toml) as bench, suppress(KinopixError):
        bench.run(SMALL, folder / "run.h5")
    return folder / "run.h5"


def outcomes(path: Path) -> tuple[dict[str, str], int]:
    report, code = check_recording(path)
    return {check.name: check.outcome for check in report.checks}, code


def test_a_good_recording_passes_every_check(tmp_path: Path) -> None:
    path = recorded(tmp_path)
    report, code = check_recording(path)
    assert code == 0
    assert {check.outcome for check in report.checks} == {"good"}
    said = {check.name: check.message for check in report.checks}
    assert said["completeness"].startswith("whole: 40 of 40 frames, from 20")
    assert said["checksums"] == "values and edge times agree with 2 checksums (CRC-32)"
    assert said["values against raw counts"] == "240 values counted again from 240 raw counts, all the same"


@pytest.mark.parametrize(
    ("faults", "timing"),
    [
        ('faults = [{ kind = "drop-edge", picture = 100 }]', "warning"),
        ('faults = [{ kind = "double-edge", picture = 100 }]', "warning"),
    ],
)
def test_lost_and_surplus_edges_are_counted_again_as_in_the_run(tmp_path: Path, faults: str, timing: str) -> None:
    found, code = outcomes(recorded(tmp_path, faults))
    assert found["values against raw counts"] == "good"
    assert found["timing audit"] == timing
    assert code == 0


def test_a_run_that_broke_is_sound_and_not_whole(tmp_path: Path) -> None:
    found, code = outcomes(recorded(tmp_path, 'faults = [{ kind = "stall", picture = 100 }]'))
    assert found["completeness"] == "error"
    assert found["timing audit"] == "warning"  # partial: what came before is sure
    assert found["values against raw counts"] == "good"
    assert code == 3


def test_a_recording_of_a_scheme_that_is_not_installed_cannot_be_trusted_here(tmp_path: Path) -> None:
    path = recorded(tmp_path)
    with plain.opened(path, "r+") as file:
        file["entry/plan"][()] = '{"scheme": "holography"}'
    report, code = check_recording(path)
    assert code == 2
    assert [check.outcome for check in report.checks] == ["good", "error"]
    assert report.checks[0].message.startswith("whole: 40 of ? frames")
    assert "holography" in report.checks[1].message


def test_a_value_that_was_changed_is_found_by_its_checksum(tmp_path: Path) -> None:
    path = recorded(tmp_path)
    with plain.opened(path, "r+") as file:
        file["entry/data/values"][3, 2] += 1
    found, code = outcomes(path)
    assert found["numbers"] == "error"
    assert code == 2


@pytest.mark.parametrize("what", [f"entry/{layout.VALUES}", f"entry/{layout.EDGE_TIME_S}"])
def test_without_checksums_a_change_is_found_by_counting_again(tmp_path: Path, what: str) -> None:
    path = recorded(tmp_path)
    with plain.opened(path, "r+") as file:
        del file["entry/checksum"]
        file[what][3, 2] += 1e-9
    report, code = check_recording(path)
    (wrong,) = [check for check in report.checks if check.outcome == "error"]
    assert wrong.message == "1 of 240 values that 240 raw counts do not give, the first is pattern 20"
    assert code == 2


def test_values_without_raw_counts_are_found(tmp_path: Path) -> None:
    path = recorded(tmp_path)
    with plain.opened(path, "r+") as file:
        for name in (layout.RAW_COUNTS, layout.RAW_EDGE_TIME_S):
            file[f"entry/{name}"].resize((238,))
    found, code = outcomes(path)
    assert found["values against raw counts"] == "error"
    assert code == 2


def test_what_is_no_recording_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.h5").write_bytes(b"no")
    with pytest.raises(InputError):
        check_recording(tmp_path / "x.h5")


def test_bins_are_placed_by_their_edges() -> None:
    """Edges at 0, 1, 3 (one is missing), 4 and a bounce at 4.3 periods."""
    values, edges = recount(
        np.array([1.0, 2.0, 3.0, 4.0, 5.0]), np.array([0.0, 1.0, 3.0, 4.0, 4.3]), picture_time_s=1.0, patterns=10
    )
    np.testing.assert_array_equal(values[:4], [1.0, 2.0, np.nan, 3.0])
    assert values[4] == 9.0
    np.testing.assert_array_equal(edges[:5], [0.0, 1.0, np.nan, 3.0, 4.0])


def test_bins_without_edge_times_keep_their_order_among_those_that_have_them() -> None:
    raw = np.arange(6.0)
    times = np.array([0.0, 1.0, np.nan, np.nan, 4.0, 5.0])
    values, edges = recount(raw, times, picture_time_s=1.0, patterns=5)
    np.testing.assert_array_equal(values, raw[:5])
    np.testing.assert_array_equal(edges, times[:5])
    assert len(recount(np.empty(0), np.empty(0), picture_time_s=1.0, patterns=5)[0]) == 0
