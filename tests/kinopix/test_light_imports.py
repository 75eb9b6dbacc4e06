"""Each import in a fresh process: a script waits for what it uses, and for nothing else."""

from pathlib import Path

from instrument.plan import Plan
from instrument.storage import RecordingWriter
from tests.kinopix.fresh import loaded_by, loaded_by_command
from tests.support.benches import bench_toml, plan_toml


def test_kinopix_alone_loads_no_library(tmp_path: Path) -> None:
    assert loaded_by(tmp_path, "import kinopix") == set()


def test_a_plan_needs_neither_solver_nor_file(tmp_path: Path) -> None:
    assert loaded_by(tmp_path, "import kinopix\nkinopix.Plan(frames=3)") <= {"numpy", "pydantic"}


def test_reading_a_recording_loads_neither_solver_nor_plotting(tmp_path: Path) -> None:
    plan = Plan(frames=2, image_size=8)
    with RecordingWriter(tmp_path / "run.h5", plan, picture_time_s=50e-6) as writer:
        writer.finish()
    code = "from kinopix import open_recording\nassert open_recording('run.h5').plan.frames == 2"
    assert loaded_by(tmp_path, code) == {"h5py", "numpy", "pydantic"}


def test_help_is_answered_without_a_library(tmp_path: Path) -> None:
    assert loaded_by_command(tmp_path, "--help") & {"matplotlib", "numba", "numpy", "scipy"} == set()


def test_a_check_on_a_simulated_bench_loads_neither_solver_nor_plotting(tmp_path: Path) -> None:
    bench_toml(tmp_path)
    plan_toml(tmp_path)
    loaded = loaded_by_command(tmp_path, "check", "--bench", "bench.toml", "--plan", "plan.toml")
    assert loaded & {"matplotlib", "numba", "scipy"} == set()
