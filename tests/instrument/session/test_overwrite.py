"""A run and the recording that it is to replace: what fails before the first block costs nothing."""

from pathlib import Path

import numpy as np
import pytest

from instrument.session import Event, FindingEvent, Instrument
from instrument.storage import open_recording
from protocols import CountBlock, DeviceError, InputError, KinopixError
from tests.support.benches import SMALL, bench_toml

LONG = SMALL.model_copy(update={"frames": 400})
"""2,400 patterns: three blocks of 50 ms."""


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """A recording of an earlier run."""
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        bench.run(SMALL, tmp_path / "run.h5")
    return tmp_path / "run.h5"


def test_a_counter_that_does_not_arm_leaves_the_old_recording(
    tmp_path: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = out.read_bytes()

    def refuse(*_arguments: object, **_options: object) -> None:
        raise DeviceError(device="counter", saw="no answer", expected="an answer", remedy="look at the cable")

    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        monkeypatch.setattr(bench.counter, "arm", refuse)
        with pytest.raises(KinopixError, match="no answer") as caught:
            bench.run(SMALL, out, overwrite=True)
    assert caught.value.__notes__ == ["nothing was recorded"]
    assert out.read_bytes() == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bench.toml", "run.h5"]


def test_an_interrupt_before_the_first_block_blocks_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.h5"

    def interrupt(*_arguments: object, **_options: object) -> None:
        raise KeyboardInterrupt

    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        with monkeypatch.context() as patch:
            patch.setattr(bench.counter, "arm", interrupt)
            with pytest.raises(KeyboardInterrupt):
                bench.run(SMALL, path)
        assert sorted(left.name for left in tmp_path.iterdir()) == ["bench.toml"]
        assert len(bench.run(SMALL, path)) == 40


def test_a_second_bench_is_refused_while_the_first_one_records(
    tmp_path: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It asks before the first block of the first bench, and after it."""
    said: list[str] = []
    with Instrument.from_toml(bench_toml(tmp_path)) as bench, Instrument.from_toml(bench_toml(tmp_path)) as other:
        read = bench.counter.read

        def reading(timeout_s: float) -> CountBlock:
            with pytest.raises(InputError) as caught:
                other.start(SMALL, out, overwrite=True)
            said.append(caught.value.saw)
            return read(timeout_s)

        monkeypatch.setattr(bench.counter, "read", reading)
        recording = bench.run(LONG, out, overwrite=True)
    assert len(said) > 2
    assert all("run.h5, which is being recorded by process" in each for each in said)
    np.testing.assert_array_equal(open_recording(out).values, recording.values)
    assert len(recording) == 400


def test_counts_are_kept_beside_a_name_that_was_taken_meanwhile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.h5"
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        arm = bench.counter.arm

        def arming(*arguments: object, **options: object) -> object:
            path.write_text("mine")
            return arm(*arguments, **options)  # type: ignore[arg-type]

        monkeypatch.setattr(bench.counter, "arm", arming)
        run = bench.start(SMALL, path)
        with pytest.raises(InputError, match="another program has made since the run began") as caught:
            run.wait(20)
    assert path.read_text() == "mine"
    beside = next(tmp_path.glob("run-*.h5"))
    assert caught.value.__notes__ == [f"240 of 240 patterns are kept in {beside}"]
    assert len(open_recording(beside)) == 40


def test_what_a_program_that_died_left_is_a_finding(tmp_path: Path) -> None:
    left = tmp_path / f".run.h5.recorded-4321-{'a' * 16}.part"
    left.write_bytes(b"half")
    heard: list[Event] = []
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        bench.run(SMALL, tmp_path / "run.h5", listeners=[heard.append])
    found = [event.message for event in heard if isinstance(event, FindingEvent)]
    assert found[0] == f"{left} was left behind by a program that ended early, and is removed"
    assert not left.exists()
