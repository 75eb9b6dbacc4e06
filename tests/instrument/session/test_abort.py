"""Runs that are aborted from another thread at random moments end safe, and what they kept is valid."""

import random
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from typing import Literal

import numpy as np
import pytest

from instrument.plan import MotionPlan, Plan
from instrument.session import Instrument, Run, RunAborted
from instrument.storage import open_recording
from protocols import CounterRun, SafeStateFailed
from tests.faults.bench import bench_toml, scene_of
from tests.faults.row import Row
from tests.support import plain_hdf5 as plain

PLAN = Plan(
    frames=20,
    image_size=8,
    pattern_rate_hz=1000,
    motion=MotionPlan(start_mm=1.0, velocity_mm_s=25.0, acceleration_mm_s2=200.0, field="may-leave"),
)
"""120 patterns of 1 ms: three blocks."""

BENCHES = {
    "simulated": Row(fault="none"),
    "alp, ni, mc600": Row(fault="none", modulator="alp", counter="ni", stage="mc600"),
    "alp, usb-ctr, sc300": Row(fault="none", modulator="alp", counter="usb-ctr", stage="sc300"),
}


@contextmanager
def aborted_at(run: Run, moment: int) -> Generator[None]:
    """Abort a run from a thread of its own when that many events have come, twice."""

    def abort() -> None:
        for count, _event in enumerate(feed):
            if count == moment:
                run.abort("the test")
                run.abort("the test, again")

    feed = run.events()
    aborting = Thread(target=abort)
    aborting.start()
    yield
    aborting.join()


def assert_safe(bench: Instrument) -> None:
    """The stage stands, nothing is shown, and the counter can be armed and disarmed, which one that is armed refuses.

    A stage that was stopped at 25 mm/s has ramped down after 0.125 s at 200 mm/s^2.
    """
    clock = bench.devices.clock
    assert not bench.modulator.running
    clock.sleep_s(0.5)
    at_mm = bench.stage.position().reported_mm
    clock.sleep_s(0.5)
    assert bench.stage.position().reported_mm == at_mm
    bench.counter.arm(CounterRun(n_bins=10, period_s=1e-3))
    assert bench.counter.disarm().bins_closed == 0


def assert_valid(path: Path, *, complete: bool) -> None:
    """It opens, by our reader and by plain h5py, and says why it is partial."""
    recording = open_recording(path)
    assert len(recording) <= PLAN.frames
    assert recording.timing is not None
    assert recording.timing.patterns_recorded == np.isfinite(recording.values).sum()
    assert (plain.attribute(path, "entry", "complete") == 1) == complete
    assert ("the test" in plain.text(path, "entry/interrupted")) == (not complete)


@pytest.mark.parametrize(
    ("name", "runs"),
    [
        ("simulated", 40),
        ("alp, ni, mc600", 20),
        ("alp, usb-ctr, sc300", 20),
        pytest.param("simulated", 100, marks=pytest.mark.thorough),
        pytest.param("alp, ni, mc600", 50, marks=pytest.mark.thorough),
        pytest.param("alp, usb-ctr, sc300", 50, marks=pytest.mark.thorough),
    ],
)
def test_a_run_that_is_aborted_at_a_random_moment_ends_safe_with_a_valid_recording(
    tmp_path: Path, name: str, runs: int
) -> None:
    """Eighty runs, two hundred in the thorough tests: each on a bench that has run before, so that nothing may stick."""
    chance, outcomes = random.Random(7), set[str]()
    with Instrument.from_toml(bench_toml(BENCHES[name], tmp_path)) as bench:
        for turn in range(runs):
            path = tmp_path / f"{turn}.h5"
            run = bench.start(PLAN, path)
            with aborted_at(run, chance.randrange(12)):
                try:
                    run.wait(20)
                except RunAborted as aborted:
                    assert any("kept" in note or "nothing" in note for note in aborted.__notes__)  # noqa: PT017
            outcomes.add(run.state)
            assert run.state in ("done", "aborted")
            assert_safe(bench)
            finished = run.snapshot.finished
            assert finished is not None
            assert path.exists() == (finished.path is not None)
            if path.exists():
                assert_valid(path, complete=run.state == "done")
    assert "aborted" in outcomes


@pytest.mark.parametrize("dialect", ["mc600", "sc300"])
@pytest.mark.parametrize(("frames", "left_s"), [(300, 2.0), (2000, 12.0)], ids=["soon over", "long"])
def test_a_stage_that_ignores_the_stop_is_never_called_safe_while_it_moves(
    tmp_path: Path, dialect: Literal["mc600", "sc300"], frames: int, left_s: float
) -> None:
    """Aborted as the counting begins: about the run's own time is left to move, 6 ms a frame, and 20 % and 1 s more are told.

    Where that is soon, the bench waits until the stage stands, and the run ends as any that was aborted.
    """
    deaf = Row(fault="deaf", stage=dialect, emulator='stop_works_moving = false\nbusy_policy = "mute"')
    plan = PLAN.model_copy(update={"frames": frames})
    with Instrument.from_toml(bench_toml(deaf, tmp_path)) as bench:
        clock, scene = bench.devices.clock, scene_of(bench)

        def place_mm(after_s: float = 0.0) -> float:
            return float(scene._carried[-1][1](np.array([clock.now_s() + after_s]))[0])

        run = bench.start(plan, tmp_path / "run.h5")
        for event in run.events():
            if event.kind == "block":
                run.abort("the test")
                break
        if left_s < 4.0:
            with pytest.raises(RunAborted):
                run.wait(20)
            assert place_mm() == place_mm(5.0)
        else:
            with pytest.raises(SafeStateFailed) as unsafe:
                run.wait(20)
            assert isinstance(unsafe.value.__cause__, RunAborted)
            assert place_mm() != place_mm(1.0)
            assert unsafe.value.stands_in_s is not None
            assert place_mm(unsafe.value.stands_in_s) == place_mm(30.0)
            assert left_s / 2 < unsafe.value.stands_in_s < 1.2 * (left_s + 1.0) + 1.0
            clock.sleep_s(unsafe.value.stands_in_s)
        assert open_recording(tmp_path / "run.h5").frame_valid.any()
