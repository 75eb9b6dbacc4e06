"""What a recording is, told of every kind of file without reading the values."""

import os
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.session import Instrument
from instrument.storage import RecordingWriter, open_recording, recording_info, write_analysis
from protocols import InputError, TimingFault
from tests.instrument.storage import test_bad_files as bad
from tests.support import plain_hdf5 as plain
from tests.support.benches import SMALL, bench_toml

SCENE = 'noise = { kind = "poisson", peak_counts = 900, seed = 1 }'
TINY = Plan(frames=8, image_size=8)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole run on the simulated bench."""
    folder = tmp_path_factory.mktemp("whole")
    with Instrument.from_toml(bench_toml(folder, SCENE)) as bench:
        bench.run(SMALL, folder / "run.h5")
    return folder / "run.h5"


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """Eight frames, the least that a recording holds."""
    path = tmp_path / "run.h5"
    with RecordingWriter(path, TINY, picture_time_s=50e-6) as writer:
        writer.append(np.ones(48))
        writer.finish()
    return path


def test_a_whole_run(whole: Path) -> None:
    info, recording = recording_info(whole), open_recording(whole)
    assert (info.state, info.interrupted, info.process_id) == ("complete", "", None)
    assert (info.title, info.program, info.layout) == ("run", "kinopix", "1.3")
    assert info.version == plain.attribute(whole, "entry/program_name", "version")
    assert "2020" < info.start_time <= info.end_time
    assert info.file_bytes == whole.stat().st_size
    assert info.plan == SMALL
    assert info.picture_time_s == pytest.approx(50e-6)
    assert (info.frames, info.frames_masked) == (40, 0)
    assert (info.photon_counts, info.edge_times, info.truth) == (True, True, True)
    assert info.timing == recording.timing
    assert {role: (device.model, device.simulated) for role, device in info.devices.items()} == {
        "modulator": ("simulated DLP7000", True),
        "counter": ("simulated H10682 and counter", True),
        "stage": ("simulated KA400Z", True),
    }
    assert info.analysis is None


def test_an_analysis_is_told_with_its_figures(whole: Path, tmp_path: Path) -> None:
    path = Path(shutil.copy(whole, tmp_path))
    write_analysis(
        path,
        displacement_px=np.zeros((40, 2)),
        image=np.eye(32),
        table={"psnr_db": 31.25, "sigma_px": np.nan},
        settings={"method": "tv"},
    )
    analysis = recording_info(path).analysis
    assert analysis is not None
    assert analysis.program == "kinopix"
    assert dict(analysis.table) == {"psnr_db": 31.25, "sigma_px": None}
    assert dict(analysis.settings) == {"method": "tv"}


def test_a_run_that_broke_says_why_and_how_far_it_came(tmp_path: Path) -> None:
    """The modulator stalls on picture 100: 16 whole frames and a part of the next, which is masked."""
    scene = SCENE + '\nfaults = [{ kind = "stall", picture = 100 }]'
    with Instrument.from_toml(bench_toml(tmp_path, scene)) as bench, pytest.raises(TimingFault) as fault:
        bench.run(SMALL, tmp_path / "run.h5")
    info, recording = recording_info(tmp_path / "run.h5"), open_recording(tmp_path / "run.h5")
    assert info.state == "interrupted"
    assert info.interrupted == str(fault.value)
    assert info.frames == len(recording) < 40
    assert info.frames_masked == int((~recording.frame_valid).sum()) > 0
    assert info.timing is not None
    assert info.timing.verdict == "partial"


def test_a_run_that_goes_on_is_told_from_one_that_was_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with RecordingWriter(path, TINY, picture_time_s=50e-6) as writer:
        writer.append(np.ones(20))
        info = recording_info(path)
        assert (info.state, info.frames, info.frames_masked, info.end_time) == ("being recorded", 4, None, "")
        assert info.process_id == os.getpid()
        assert (info.edge_times, info.truth, info.timing) == (False, False, None)
        writer.close()
    info = recording_info(path)
    assert (info.state, info.process_id, info.frames, info.interrupted) == ("cut off", None, 4, "")


def test_a_reader_is_not_taken_for_a_writer(tiny: Path) -> None:
    with plain.opened(tiny):
        assert recording_info(tiny).state == "complete"


def test_a_recording_of_layout_1_0(tiny: Path) -> None:
    """There, what is not known is missing."""
    with plain.opened(tiny, "r+") as file:
        for name in ("timing", "end_time", "interrupted", "file_bytes"):
            del file["entry"][name]
        file["entry/definition"].attrs["version"] = "1.0"
    info = recording_info(tiny)
    assert (info.layout, info.state, info.end_time, info.frames) == ("1.0", "complete", "", 8)
    assert (info.frames_masked, info.timing, dict(info.devices)) == (None, None, {})
    with plain.opened(tiny, "r+") as file:
        file["entry"].attrs["complete"] = 0
    assert recording_info(tiny).state == "cut off"


@pytest.mark.parametrize(
    "harm",
    [
        bad.truncated,
        bad.empty,
        bad.text,
        bad.damaged,
        bad.foreign,
        bad.later,
        bad.no_values,
        bad.narrow,
        bad.short_mask,
        bad.gone,
        bad.folder,
    ],
    ids=lambda harm: harm.__name__,
)
def test_a_file_that_is_no_good_is_refused_as_by_whoever_reads_it(tiny: Path, harm: Callable[[Path], str]) -> None:
    what = harm(tiny)
    with pytest.raises(InputError, match=what) as told:
        recording_info(tiny)
    with pytest.raises(InputError) as read:
        open_recording(tiny)
    assert str(told.value) == str(read.value)


def test_a_scheme_that_is_not_installed_is_named_and_its_values_are_refused(tiny: Path) -> None:
    bad.strange_plan(tiny)
    info = recording_info(tiny)
    assert (info.plan, info.missing_scheme, info.frames) == (None, "holography", 8)
    with pytest.raises(InputError, match="holography"):
        open_recording(tiny)


@pytest.fixture
def long(tmp_path: Path) -> Iterator[Path]:
    """A million frames, 192 MB: as long as a run of five minutes, four times over."""
    path = tmp_path / "long.h5"
    plan = Plan(frames=1_000_000, image_size=8)
    with RecordingWriter(path, plan, picture_time_s=50e-6) as writer:
        for _ in range(10):
            writer.append(np.ones(600_000), np.ones(600_000))
        writer.finish(frame_valid=np.ones(1_000_000, np.bool_))
    yield path
    path.unlink()


def test_a_long_run_is_told_in_little_memory_and_time(long: Path) -> None:
    """The mask is read, a byte a frame; values and edge times, 96 bytes a frame, are not."""
    started_s = time.process_time()
    info = recording_info(long)
    took_s = time.process_time() - started_s
    assert (info.frames, info.frames_masked, info.edge_times) == (1_000_000, 0, True)
    assert info.file_bytes > 96e6
    assert took_s < 0.25
