"""What a script passes by mistake is answered in a sentence that says what to pass, never by an error from within."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import kinopix
from instrument.plan import MotionPlan, Plan
from instrument.schemes import scheme_of
from instrument.session import Instrument
from protocols import DeviceError, InputError
from tests.support.benches import SMALL, bench_toml

NAMES: list[Any] = [None, 3, b"run.h5", "a\0b.h5", "x" * 300, "/".join(["folder"] * 800)]


@pytest.mark.parametrize("name", NAMES, ids=["none", "number", "bytes", "NUL", "long", "deep"])
def test_what_cannot_be_the_name_of_a_file_is_refused_wherever_one_is_asked_for(tmp_path: Path, name: Any) -> None:
    asked: list[Callable[[Any], object]] = [kinopix.open_recording, Plan.from_toml, Instrument.from_toml]
    for ask in asked:
        with pytest.raises(InputError, match="the name of a file"):
            ask(name)
    if name is not None:
        with Instrument.from_toml(bench_toml(tmp_path)) as bench, pytest.raises(InputError, match="the name of a file"):
            bench.run(SMALL, name)


def test_the_longest_name_that_a_file_can_have_is_only_not_there() -> None:
    with pytest.raises(InputError, match="no such file"):
        kinopix.open_recording("x" * 255)


@pytest.mark.parametrize("plan", ["plan.toml", None, {"frames": 3}])
def test_what_is_no_plan_is_refused(plan: Any) -> None:
    for ask in (kinopix.simulate, scheme_of):
        with pytest.raises(InputError, match="expected a plan"):
            ask(plan)


def test_an_instrument_of_nothing_is_refused() -> None:
    nothing: Any = None
    with pytest.raises(InputError, match="saw a NoneType; expected open devices"):
        Instrument(nothing)


@pytest.mark.parametrize("key", ["frames", "pattern_rate_hz", "image_size", "superpixel", "brightest_counts"])
def test_a_truth_value_is_no_number_of_a_plan(key: str) -> None:
    with pytest.raises(ValueError, match="is true, which is no number"):
        Plan.model_validate({"frames": 3, key: True})
    with pytest.raises(ValueError, match="is false, which is no number"):
        MotionPlan.model_validate({"velocity_mm_s": False})


def test_a_wait_by_another_name_is_told_the_right_one(tmp_path: Path) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench, bench.start(SMALL, tmp_path / "run.h5") as run:
        wait: Any = run.wait
        with pytest.raises(InputError, match=r"saw wait\(timeout=1\).*timeout_s"):
            wait(timeout=1)
        with pytest.raises(InputError, match=r"saw wait\('1'\)"):
            wait("1")
        assert len(wait(timeout_s=20)) == SMALL.frames


@pytest.mark.parametrize("edge_times", ["true", "false"])
def test_a_script_that_halts_the_modulator_in_mid_run_ends_the_run_with_what_happened(
    tmp_path: Path, edge_times: str
) -> None:
    """6,000 patterns at 20 kHz come in six blocks of 1,000; it is halted when the first is there."""
    plan = SMALL.model_copy(update={"frames": 1000})
    halted: list[str] = []

    with Instrument.from_toml(bench_toml(tmp_path, counter=f"edge_times = {edge_times}")) as bench:
        read = bench.counter.read

        def reading(timeout_s: float) -> Any:
            block = read(timeout_s)
            if len(block) and not halted:
                halted.append("now")
                bench.modulator.halt()
            return block

        bench.counter.read = reading  # type: ignore[method-assign]
        with pytest.raises(DeviceError, match="plays no more after 1000 of 6000 patterns") as ended:
            bench.run(plan, tmp_path / "run.h5")
    assert "who halted it" in ended.value.remedy
    recording = kinopix.open_recording(tmp_path / "run.h5")
    assert recording.timing is not None
    assert recording.timing.verdict == "partial"
    assert "the run ended early; 166 of its 1000 frames are good" in recording.timing.notes
