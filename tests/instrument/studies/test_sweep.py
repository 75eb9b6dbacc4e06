"""A sweep gives the same on one process and on two, keeps what is finished, and leaves nothing behind."""

import json
import os
import signal
import subprocess
import sys
from multiprocessing import active_children
from pathlib import Path

import numpy as np
import pytest

from instrument.studies import Outcome, Simulated, Sweep, sweep
from tests.instrument.studies import tiny

ROOT = Path(__file__).parents[3]


def figures(done: Sweep) -> list[dict[str, float] | None]:
    return [None if outcome is None else outcome["one"].figures for outcome in done.outcomes]


def computed(folder: Path) -> list[str]:
    """What was computed, in alphabetical order, without the process."""
    return sorted(path.name.rsplit("-", 1)[0] for path in folder.iterdir())


@pytest.fixture
def marks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "marks"
    folder.mkdir()
    monkeypatch.setenv(tiny.MARKS, str(folder))
    return folder


def test_two_processes_give_the_same_as_one_to_the_bit_and_name_the_point_that_fails(
    tmp_path: Path, marks: Path
) -> None:
    heard: list[tuple[str, int, int]] = []
    serial = sweep(tiny.points(4, "refuse"), tmp_path / "one", workers=1)
    parallel = sweep(
        tiny.points(4, "refuse"),
        tmp_path / "two",
        workers=2,
        on_point=lambda point, k, n: heard.append((point.name, k, n)),
    )

    assert serial.failures == parallel.failures == {"tiny, seed 1": "ValueError: seed 1 is not liked"}
    assert [outcome is None for outcome in serial.outcomes] == [False, True, False, False]
    assert figures(parallel) == figures(serial)
    for ours, theirs in zip(parallel.outcomes, serial.outcomes, strict=True):
        if ours is not None and theirs is not None:
            np.testing.assert_array_equal(ours["one"].image, theirs["one"].image)
    assert sorted(name for name, _, _ in heard) == [f"tiny, seed {k}" for k in range(4)]
    assert [(k, n) for _, k, n in heard] == [(1, 4), (2, 4), (3, 4), (4, 4)]
    of_others = {path.name.rsplit("-", 1)[1] for path in marks.iterdir()} - {str(os.getpid())}
    assert len(of_others) in {1, 2}
    assert active_children() == []


def test_a_sweep_goes_on_where_it_was_ended(tmp_path: Path, marks: Path) -> None:
    first = sweep(tiny.points(2), tmp_path / "kept", workers=1)
    assert (first.kept, computed(marks)) == (0, ["25-0", "25-1"])
    for mark in marks.iterdir():
        mark.unlink()

    again = sweep(tiny.points(3), tmp_path / "kept", workers=1)

    assert (again.kept, computed(marks)) == (2, ["25-2"])
    assert figures(again)[:2] == figures(first)


def test_a_file_that_is_cut_off_is_computed_anew(tmp_path: Path, marks: Path) -> None:
    whole = sweep(tiny.points(1), tmp_path, workers=1)
    (file,) = tmp_path.glob("*.npz")
    file.write_bytes(file.read_bytes()[:-100])
    file.with_suffix(".77.part").write_bytes(b"left by one that was killed")

    assert figures(sweep(tiny.points(1), tmp_path, workers=1)) == figures(whole)
    assert computed(marks) == ["25-0"]
    assert [path.name for path in tmp_path.iterdir() if path.is_file()] == [file.name]


def test_other_settings_seeds_and_functions_have_other_keys() -> None:
    point = tiny.points(1)[0]
    others = [
        tiny.points(2)[1],
        tiny.points(1, "refuse")[0],
        type(point)("tiny, seed 0", "tiny", tiny.compute, Simulated(sigma=0.2), 0),
    ]
    assert len({point.key, *(other.key for other in others)}) == 4
    assert type(point)("another name", "tiny", tiny.compute, Simulated(), 0).key == point.key


SCRIPT = """
import sys
from pathlib import Path
from multiprocessing import active_children
from instrument.studies import sweep
from tests.instrument.studies import tiny

if __name__ == "__main__":
    try:
        sweep(tiny.points(4, "hang"), Path(sys.argv[1]), workers=2, on_point=lambda point, k, n: print(k, flush=True))
    except KeyboardInterrupt:
        print("interrupted", [child.pid for child in active_children()], flush=True)
        sys.exit(130)
"""


@pytest.mark.parametrize("by", [pytest.param(signal.SIGINT, marks=pytest.mark.thorough), signal.SIGKILL])
def test_an_interrupt_or_a_kill_leaves_no_process_and_what_is_finished(tmp_path: Path, marks: Path, by: int) -> None:
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    with subprocess.Popen(
        [sys.executable, str(script), str(tmp_path / "kept")],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        assert process.stdout is not None
        assert [process.stdout.readline() for _ in range(2)] == ["1\n", "2\n"]
        if by == signal.SIGINT:
            os.killpg(process.pid, by)  # as a terminal does: to all of them
        else:
            process.kill()
        said, complained = process.communicate(timeout=60)
    assert [
        line for line in complained.splitlines() if "resource_tracker" not in line and "warnings.warn" not in line
    ] == []
    if by == signal.SIGINT:
        assert (process.returncode, said) == (130, "interrupted []\n")
    # Every process of the session held the pipe: it is at its end when all are gone, which communicate() waited for.
    assert len(list((tmp_path / "kept").glob("*.npz"))) == 2
    assert len({path.name.rsplit("-", 1)[0] for path in marks.iterdir()} & {"25-0", "25-1"}) == 2


def test_figures_keep_every_bit_on_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    value = 0.1 + 0.2

    def third(settings: Simulated, seed: int) -> dict[str, Outcome]:
        return {"one": Outcome({"psnr_db": value}, np.full((2, 2), value))}

    monkeypatch.setattr(tiny, "compute", third)
    (outcome,) = sweep(tiny.points(1), tmp_path, workers=1).outcomes
    assert outcome is not None
    assert json.dumps(outcome["one"].figures) == '{"psnr_db": 0.30000000000000004}'
    assert outcome["one"].image.tolist() == [[value, value], [value, value]]
