"""How much of a recording others find in its file, while the run goes on and after it."""

from pathlib import Path

from instrument import Instrument, Plan
from tests.support.benches import bench_toml
from tests.support.plain_hdf5 import array


def test_whole_frames_are_counted_when_they_are_in_the_file(tmp_path: Path) -> None:
    """Never fewer than before, and all at the end."""
    plan, out = Plan(frames=300, image_size=32, superpixel=4), tmp_path / "run.h5"
    with Instrument.from_toml(bench_toml(tmp_path)) as bench, bench.start(plan, out) as run:
        written = [run.written for _event in run.events()]
        run.wait()
    known = [one for one in written if one is not None]
    assert [one.frames for one in known] == sorted(one.frames for one in known)
    assert known[-1] == run.written
    assert (known[-1].path, known[-1].frames) == (out, 300)
    assert len(array(out, "/entry/data/values")) == 300
