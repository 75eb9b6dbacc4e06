"""What is written comes back, however the run ended."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from instrument.plan import MotionPlan, Plan
from instrument.storage import RecordingWriter, open_recording, refuse_existing
from protocols import CountBlock, DeviceIdentity, Floats, InputError, Truth
from tests.support import plain_hdf5 as plain

PLAN = Plan(frames=8, image_size=8, motion=MotionPlan(velocity_mm_s=25))
COUNTS = np.arange(48, dtype=np.float64)


def block(values: Floats, first: int = 0) -> CountBlock:
    """Counts as a counter with edge times hands them over, one every 50 us."""
    edges = np.arange(first, first + len(values) + 1, dtype=np.float64) * 50e-6
    return CountBlock(first, values.astype(np.uint32), opening_edge_s=edges[:-1], closing_edge_s=float(edges[-1]))


def write_whole(path: Path) -> None:
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        whole = block(COUNTS)
        writer.append_raw(whole)
        writer.append(COUNTS, whole.opening_edge_s)
        writer.finish()


def test_a_whole_run_comes_back_with_all_its_figures(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    truth = Truth(displacement_px=np.arange(16.0).reshape(8, 2), image=np.eye(8))
    mask = np.arange(8) != 3
    with RecordingWriter(
        path, PLAN, picture_time_s=50e-6, dead_time_s=20e-9, dark_rate_hz=12.5, with_truth=True
    ) as writer:
        whole = block(COUNTS)
        writer.append_raw(whole)
        writer.append(COUNTS, whole.opening_edge_s)
        writer.finish(frame_valid=mask, truth=truth)

    recording = open_recording(path)

    assert recording.plan == PLAN
    np.testing.assert_array_equal(recording.values, COUNTS.reshape(8, 6))
    assert recording.edge_time_s is not None
    np.testing.assert_array_equal(recording.edge_time_s.ravel(), np.arange(48) * 50e-6)
    np.testing.assert_array_equal(recording.frame_valid, mask)
    assert (recording.picture_time_s, recording.dead_time_s, recording.dark_rate_hz) == (50e-6, 20e-9, 12.5)
    assert recording.photon_counts
    assert recording.truth is not None
    np.testing.assert_array_equal(recording.truth.displacement_px, truth.displacement_px)
    np.testing.assert_array_equal(recording.truth.image, truth.image)
    assert recording.truth.background is None
    assert recording.path == path


def test_the_background_of_a_truth_comes_back_and_stays_in_a_shorter_run(tmp_path: Path) -> None:
    background = np.arange(64.0).reshape(8, 8) / 64
    with RecordingWriter(tmp_path / "run.h5", PLAN, picture_time_s=50e-6, with_truth=True) as writer:
        whole = block(COUNTS)
        writer.append_raw(whole)
        writer.append(COUNTS, whole.opening_edge_s)
        writer.finish(truth=Truth(np.zeros((8, 2)), np.eye(8), background))

    for recording in (open_recording(tmp_path / "run.h5"), open_recording(tmp_path / "run.h5").first(3)):
        assert recording.truth is not None
        assert recording.truth.background is not None
        np.testing.assert_array_equal(recording.truth.background, background)
        assert recording.truth.displacement_px.shape == (len(recording), 2)


def test_a_truth_of_before_had_no_background(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6, with_truth=True) as writer:
        writer.append(COUNTS)
        writer.append_raw(block(COUNTS))
        writer.finish(truth=Truth(np.zeros((8, 2)), np.eye(8)))
    with plain.opened(path, "r+") as file:
        del file["entry/truth/background"]
    truth = open_recording(path).truth
    assert truth is not None
    assert truth.background is None


@settings(max_examples=25, deadline=None)
@given(
    values=hnp.arrays(np.float64, st.integers(1, 48), elements=st.floats(0, 1e6) | st.just(np.nan)),
    cuts=st.lists(st.integers(0, 48), max_size=6),
)
def test_any_split_into_blocks_gives_the_same_recording(
    tmp_path_factory: pytest.TempPathFactory, values: Floats, cuts: list[int]
) -> None:
    path = tmp_path_factory.mktemp("split") / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        for part in np.split(values, sorted(cuts)):
            writer.append(part)
        writer.finish()

    recording = open_recording(path)

    expected = np.full((-(-len(values) // 6), 6), np.nan)
    expected.ravel()[: len(values)] = values
    np.testing.assert_array_equal(recording.values, expected)
    np.testing.assert_array_equal(recording.frame_valid, ~np.isnan(expected).any(axis=1))
    assert recording.edge_time_s is None


def test_float_values_are_no_photon_counts(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "run.h5", PLAN, picture_time_s=50e-6) as writer:
        writer.append_raw(CountBlock(first_bin=0, counts=np.array([1.5])))
        writer.append(np.array([1.5]))
        writer.finish()
    assert not open_recording(tmp_path / "run.h5").photon_counts


def test_the_raw_counts_stay_in_order_of_arrival_when_the_audit_moves_values(tmp_path: Path) -> None:
    """One pattern was missed: 11 counts came, and the audit leaves a gap at pattern 4."""
    path = tmp_path / "run.h5"
    arrived = np.arange(11, dtype=np.float64)
    placed = np.insert(arrived, 4, np.nan)
    edges = np.insert(arrived * 50e-6, 4, np.nan)
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        for first in (0, 5):
            writer.append_raw(block(arrived[first : first + 6] if first else arrived[:5], first))
        writer.append(placed, edges)
        writer.finish()

    recording = open_recording(path)

    np.testing.assert_array_equal(recording.values.ravel(), placed)
    np.testing.assert_array_equal(recording.frame_valid, [False, True])
    with plain.opened(path) as file:
        np.testing.assert_array_equal(file["entry/instrument/counter/raw_counts"], arrived)
        np.testing.assert_array_equal(file["entry/instrument/counter/raw_edge_time_s"], arrived * 50e-6)


def test_the_file_names_devices_configuration_times_and_program(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    stage = DeviceIdentity(name="stage", vendor="Zolix", model="KA400Z", serial="7")
    with RecordingWriter(path, PLAN, picture_time_s=50e-6, bench='{"scene": null}', devices={"stage": stage}) as writer:
        writer.append(COUNTS)
        writer.finish(report='{"gaps": 0}')
    with plain.opened(path) as file:
        entry = file["entry"]
        assert entry["instrument/stage/model"].asstr()[()] == "KA400Z"
        assert entry["instrument/stage/simulated"][()] == 0
        assert entry["bench"].asstr()[()] == '{"scene": null}'
        assert Plan.from_json(entry["plan"].asstr()[()]) == PLAN
        assert entry["timing/report"].asstr()[()] == '{"gaps": 0}'
        assert entry["title"].asstr()[()] == "run"
        assert entry["start_time"].asstr()[()] <= entry["end_time"].asstr()[()]
        assert entry["program_name"].attrs["version"]
        assert entry.attrs["complete"] == 1


def break_off_after(values: Floats, path: Path) -> None:
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        writer.append(values)
        raise RuntimeError("the cable came off")


def test_an_error_during_the_run_leaves_a_partial_recording_that_says_why(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with pytest.raises(RuntimeError, match="cable"):
        break_off_after(COUNTS[:15], path)

    recording = open_recording(path)

    np.testing.assert_array_equal(recording.frame_valid, [True, True, False])
    np.testing.assert_array_equal(recording.values[2], [12, 13, 14, np.nan, np.nan, np.nan])
    with plain.opened(path) as file:
        assert file["entry"].attrs["complete"] == 0
        assert file["entry/interrupted"].asstr()[()] == "the cable came off"


def test_leaving_without_finish_is_a_partial_recording(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "run.h5", PLAN, picture_time_s=50e-6) as writer:
        writer.append(COUNTS)
    with plain.opened(tmp_path / "run.h5") as file:
        assert file["entry/interrupted"].asstr()[()] == "never finished"


def test_a_run_without_a_single_count_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="cable"):
        break_off_after(np.empty(0), tmp_path / "run.h5")
    assert list(tmp_path.iterdir()) == []


def test_counts_survive_when_closing_the_file_fails(tmp_path: Path) -> None:
    """The mask is wrong: the error is raised, and the values are there all the same."""
    path = tmp_path / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        writer.append(COUNTS)
        with pytest.raises(ValueError, match=r"frame_valid of shape \(3,\) for 8 frames"):
            writer.finish(frame_valid=np.ones(3, bool))
    np.testing.assert_array_equal(open_recording(path).values.ravel(), COUNTS)
    assert list(tmp_path.iterdir()) == [path]


def test_a_run_can_be_read_while_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        writer.append(COUNTS[:12])
        assert len(open_recording(path)) == 2
        writer.append(COUNTS[12:])
        assert len(open_recording(path)) == 8
        writer.finish()
    assert len(open_recording(path)) == 8


def test_more_values_than_the_plan_has_are_refused(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "run.h5", PLAN, picture_time_s=50e-6) as writer:
        writer.append(COUNTS[:47])
        with pytest.raises(ValueError, match="49 values for the 48 patterns"):
            writer.append(COUNTS[:2])
        with pytest.raises(ValueError, match="2 edge times for 1 values"):
            writer.append(COUNTS[:1], np.zeros(2))


def test_an_existing_file_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_whole(path)
    before = path.read_bytes()
    with pytest.raises(InputError, match=r"run\.h5, which exists.*--overwrite") as caught:
        RecordingWriter(path, PLAN, picture_time_s=50e-6)
    assert caught.value.exit_code == 2
    assert path.read_bytes() == before


def test_overwrite_replaces_a_recording_but_nothing_else(tmp_path: Path) -> None:
    path, notes = tmp_path / "run.h5", tmp_path / "plan.toml"
    write_whole(path)
    notes.write_text("frames = 8\n")
    with RecordingWriter(path, PLAN, picture_time_s=50e-6, overwrite=True) as writer:
        writer.append(COUNTS[:6])
        writer.finish()
    assert len(open_recording(path)) == 1
    with pytest.raises(InputError, match=r"plan\.toml, which is no HDF5 file"):
        refuse_existing(notes, overwrite=True)
    assert notes.read_text() == "frames = 8\n"


def test_a_missing_folder_is_an_error_before_anything_moves(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no folder .*nowhere"):
        refuse_existing(tmp_path / "nowhere" / "run.h5")


def test_a_file_that_cannot_be_created_is_an_input_error(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_whole(path)
    with plain.opened(path), pytest.raises(InputError, match="cannot be written"):
        RecordingWriter(path, PLAN, picture_time_s=50e-6, overwrite=True)
    assert path.stat().st_size > 0


def test_a_second_interrupt_while_it_finishes_is_the_error_that_is_seen(tmp_path: Path) -> None:
    """The values are there, and no other error hides the interrupt."""

    def interrupt(*_arguments: object) -> None:
        raise KeyboardInterrupt

    path = tmp_path / "run.h5"
    writer = RecordingWriter(path, PLAN, picture_time_s=50e-6, sync=interrupt)
    writer.append(COUNTS)
    with writer, pytest.raises(KeyboardInterrupt):
        writer.finish()
    np.testing.assert_array_equal(open_recording(path).values.ravel(), COUNTS)
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_without_room_is_an_error_before_anything_moves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """2 x 10,002 patterns x 32 bytes and a megabyte beside: 1.689 MB."""
    plan = Plan(frames=1667, image_size=8)
    room = SimpleNamespace(free=1_688_703)

    def disk_usage(folder: Path) -> SimpleNamespace:
        assert folder == tmp_path
        return room

    monkeypatch.setattr("instrument.storage.place.shutil.disk_usage", disk_usage)
    with pytest.raises(InputError, match=r"1\.7 MB for 10002 patterns"):
        RecordingWriter(tmp_path / "run.h5", plan, picture_time_s=50e-6)
    assert list(tmp_path.iterdir()) == []
    room.free += 1
    with RecordingWriter(tmp_path / "run.h5", plan, picture_time_s=50e-6):
        pass
