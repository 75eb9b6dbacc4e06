"""A scheduler and two workers in processes of their own give the same as this process, by other paths."""

import os
import socket
import subprocess
import sys
from collections.abc import Generator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from instrument import Instrument, MotionPlan, Plan
from instrument.calibration import displacement_of_run, displacement_of_runs
from instrument.series import analyse_series, recordings_in
from instrument.storage import open_recording, program
from instrument.studies import sweep
from instrument.workers import Job, PathMap, Where, carry_out
from instrument.workers.job import done_by_the_same
from protocols import InputError, KinopixError
from tests.instrument.series.same import assert_same_analysis
from tests.instrument.studies import tiny
from tests.support.benches import bench_toml

pytest.importorskip("distributed", reason="distributed is not installed: no cluster")

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Generator[str]:
    """Start a scheduler and two workers; give the scheduler's address."""
    folder = tmp_path_factory.mktemp("dask")
    with ExitStack() as stack:

        def start(what: str, *words: str) -> "subprocess.Popen[str]":
            process = stack.enter_context(
                subprocess.Popen(
                    [sys.executable, "-m", f"distributed.cli.{what}", "--no-dashboard", *words],
                    cwd=folder,
                    env={**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"},
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.PIPE if what == "dask_scheduler" else subprocess.DEVNULL,
                    text=True,
                )
            )
            stack.callback(process.kill)
            return process

        scheduler = start("dask_scheduler", "--port", "0", "--host", "127.0.0.1")
        assert scheduler.stderr is not None
        found = next(line.split()[-1] for line in scheduler.stderr if "Scheduler at:" in line)
        for name in ("one", "two"):
            start("dask_worker", found, "--name", name, "--nthreads", "1", "--no-nanny")
        yield found


def test_two_workers_that_see_other_paths_give_the_same_to_the_bit(
    address: str, runs: Path, analysed_serially: Path, tmp_path: Path
) -> None:
    here = tmp_path / "here"
    here.symlink_to(runs)
    series = analyse_series(
        recordings_in([here]), where=Where(scheduler=address), path_map=PathMap.of([f"{here}={runs}"])
    )
    assert list(series.failures) == [here / "none.h5"]
    assert f"{runs}/none.h5" in series.failures[here / "none.h5"].why  # so the workers call it
    for name in ("slow.h5", "middle.h5", "later/fast.h5"):
        assert_same_analysis(runs / name, analysed_serially / name)
    again = analyse_series(recordings_in([here]), where=Where(scheduler=address))
    assert again.kept == set(series.found)


def test_a_calibration_is_measured_there_and_kept_here(address: str, runs: Path, tmp_path: Path) -> None:
    here = tmp_path / "here"
    here.symlink_to(runs)
    scene = 'px_per_mm = 2.0\nstart_px = [7.3, 8.1]\nnoise = { kind = "poisson", peak_counts = 3000, seed = 5 }'
    with Instrument.from_toml(bench_toml(tmp_path, scene)) as bench:
        motion = MotionPlan(start_mm=1.0, velocity_mm_s=35.0)
        bench.run(Plan(frames=300, image_size=32, superpixel=4, motion=motion), here / "moving.h5")
    recordings = [here / "moving.h5", here / "none.h5"]
    paths = PathMap.of([f"{here}={runs}"])
    there = displacement_of_runs(recordings, tmp_path / "there", where=Where(scheduler=address), path_map=paths)
    (found,) = there.found.values()
    serial = displacement_of_run(open_recording(here / "moving.h5"))
    assert found.model_dump(exclude={"date"}) == serial.model_dump(exclude={"date"})
    assert f"{runs}/none.h5" in there.failures[here / "none.h5"].why
    assert displacement_of_runs(recordings, tmp_path / "there").kept == {here / "moving.h5"}


def test_points_of_a_study_are_computed_there_and_kept_here(address: str, tmp_path: Path) -> None:
    there = sweep(tiny.points(3, "refuse"), tmp_path / "there", scheduler=address)
    here = sweep(tiny.points(3, "refuse"), tmp_path / "here")
    assert there.failures == here.failures == {"tiny, seed 1": "ValueError: seed 1 is not liked"}
    for ours, theirs in zip(there.outcomes, here.outcomes, strict=True):
        assert (ours is None) == (theirs is None)
        if ours is not None and theirs is not None:
            assert ours["one"].figures == theirs["one"].figures
            np.testing.assert_array_equal(ours["one"].image, theirs["one"].image)
    assert sweep(tiny.points(3), tmp_path / "there", workers=1).kept == 0  # of another function
    assert sweep(tiny.points(3, "refuse"), tmp_path / "there").kept == 2


def test_a_worker_with_another_program_refuses() -> None:
    result, failure = done_by_the_same(Job("one", len, ("abc",)), "kinopix 9.9 0123456789abcdef")
    assert result is None
    assert failure is not None
    assert "kinopix 9.9 01234567)" in failure.why
    assert done_by_the_same(Job("one", len, ("abc",)), program()) == (3, None)


def unheard(number: int, result: object, failure: object) -> None:
    pytest.fail(f"job {number} was done")


def test_an_address_where_nobody_answers_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("instrument.workers.cluster._ANSWER_S", 0.3)
    with pytest.raises(InputError, match="an address such as tcp://"):
        carry_out([Job("one", len, ("abc",))], Where(scheduler="nonsense://x"), unheard)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        nobody = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        with pytest.raises(KinopixError, match="no answer from a scheduler"):
            carry_out([Job("one", len, ("abc",))], Where(scheduler=nobody), unheard)
