"""A folder of recordings, made once."""

import shutil
from pathlib import Path

import pytest

from instrument import Instrument, MotionPlan, Plan
from tests.support.benches import bench_toml

SPEEDS = (10.0, 20.0, 30.0)


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three runs at 10, 20 and 30 mm/s, one in a folder of its own, and a file that is no recording."""
    folder = tmp_path_factory.mktemp("recorded")
    bench = bench_toml(folder, 'noise = { kind = "pixel", sigma = 0.05, seed = 1 }')
    runs = folder / "runs"
    (runs / "later").mkdir(parents=True)
    with Instrument.from_toml(bench) as instrument:
        for speed, place in zip(SPEEDS, ("slow.h5", "middle.h5", "later/fast.h5"), strict=True):
            plan = Plan(frames=80, image_size=32, superpixel=4, motion=MotionPlan(velocity_mm_s=speed))
            instrument.run(plan, runs / place)
    (runs / "none.h5").write_bytes(b"no recording")
    return runs


@pytest.fixture
def runs(recorded: Path, tmp_path: Path) -> Path:
    """A copy of these of one's own."""
    return Path(shutil.copytree(recorded, tmp_path / "runs"))


@pytest.fixture(scope="session")
def analysed_serially(recorded: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy whose recordings were analysed one by one."""
    from instrument import analyse_path

    folder = Path(shutil.copytree(recorded, tmp_path_factory.mktemp("serial") / "runs"))
    for name in ("slow.h5", "middle.h5", "later/fast.h5"):
        analyse_path(folder / name)
    return folder
