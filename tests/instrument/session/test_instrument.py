"""A bench of simulated devices, used as a lab script uses it, and broken on purpose."""

import itertools
import os
import signal
from pathlib import Path
from threading import Event as ThreadEvent

import numpy as np
import pytest

from instrument.config import read_calibration
from instrument.plan import MotionPlan
from instrument.session import BlockEvent, Event, Instrument
from instrument.storage import open_recording
from protocols import (
    CountBlock,
    InputError,
    PatternMemoryFull,
    PlanError,
    SafeStateFailed,
    TravelExceeded,
    TriggerMissed,
)
from tests.support import plain_hdf5 as plain
from tests.support.benches import SMALL, bench_toml
from tests.support.calibrations import calibrated_bench_toml, displacement


def test_a_run_records_every_frame_and_the_truth(tmp_path: Path) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        recording = bench.run(SMALL, tmp_path / "run.h5")
    assert recording.values.shape == (40, 6)
    assert recording.frame_valid.all()
    assert recording.timing is not None
    assert recording.timing.verdict == "good"
    assert recording.truth is not None
    # 25 mm/s at 1.8 px/mm (32 px image) for 39 frames of 300 us, along the diagonal
    way_px = 25 * 1.8 * 39 * 300e-6 / np.sqrt(2)
    np.testing.assert_allclose(recording.truth.displacement_px[-1], [way_px, way_px], rtol=1e-3)


def test_the_sum_of_a_hadamard_pair_is_the_light_of_an_object_at_rest(tmp_path: Path) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        recording = bench.run(SMALL.model_copy(update={"motion": None}), tmp_path / "run.h5")
    assert recording.truth is not None
    np.testing.assert_allclose(recording.values[:, 4:].sum(axis=1), recording.truth.image.sum(), rtol=1e-9)


def test_the_same_seed_gives_the_same_counts_to_the_bit(tmp_path: Path) -> None:
    toml = bench_toml(tmp_path, 'noise = { kind = "poisson", peak_counts = 200, seed = 3 }')
    values: list[bytes] = []
    for name in ("a.h5", "b.h5"):
        with Instrument.from_toml(toml) as bench:
            values.append(bench.run(SMALL, tmp_path / name).values.tobytes())
    assert values[0] == values[1]


def test_whoever_looks_on_gets_every_pattern_once_and_in_order(tmp_path: Path) -> None:
    heard: list[Event] = []
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        recording = bench.run(SMALL, tmp_path / "run.h5", listeners=[heard.append])
    seen = [event.block for event in heard if isinstance(event, BlockEvent) and event.block is not None]
    assert [b.first_pattern for b in seen] == np.cumsum([0, *(len(b.values) for b in seen[:-1])]).tolist()
    np.testing.assert_array_equal(np.concatenate([b.values for b in seen]), recording.values.ravel())


def test_a_lost_edge_masks_its_frame_only(tmp_path: Path) -> None:
    toml = bench_toml(tmp_path, 'faults = [{ kind = "drop-edge", picture = 100 }]')
    with Instrument.from_toml(toml) as bench:
        recording = bench.run(SMALL, tmp_path / "run.h5")
    assert recording.timing is not None
    assert recording.timing.gaps == (100,)
    assert np.flatnonzero(~recording.frame_valid).tolist() == [16]  # patterns 96 to 101


def test_a_bounced_edge_costs_no_pattern_at_the_end(tmp_path: Path) -> None:
    toml = bench_toml(tmp_path, 'faults = [{ kind = "double-edge", picture = 50 }]')
    with Instrument.from_toml(toml) as bench:
        recording = bench.run(SMALL, tmp_path / "run.h5")
    assert recording.timing is not None
    assert recording.timing.doubles == (50,)
    assert recording.timing.patterns_recorded == 240
    assert np.flatnonzero(~recording.frame_valid).tolist() == [8]


def test_a_stall_is_a_typed_error_and_a_shorter_recording(tmp_path: Path) -> None:
    toml = bench_toml(tmp_path, 'faults = [{ kind = "stall", picture = 100 }]')
    out = tmp_path / "run.h5"
    with Instrument.from_toml(toml) as bench, pytest.raises(TriggerMissed, match="100 of 240 patterns") as caught:
        bench.run(SMALL, out)
    assert caught.value.exit_code == 3
    assert any("100 of 240 patterns are kept" in note for note in caught.value.__notes__)
    recording = open_recording(out)
    assert np.flatnonzero(recording.frame_valid).tolist() == list(range(16))


def interrupt_after_a_block(bench: Instrument, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let Ctrl-C come when the counter is read for the second time, and wait until the modulator was halted for it."""
    read, halt, reads, halted = bench.counter.read, bench.modulator.halt, itertools.count(), ThreadEvent()

    def reading(timeout_s: float) -> CountBlock:
        if next(reads) == 1:
            os.kill(os.getpid(), signal.SIGINT)
            assert halted.wait(10)
        return read(timeout_s)

    def halting() -> None:
        halt()
        halted.set()

    monkeypatch.setattr(bench.counter, "read", reading)
    monkeypatch.setattr(bench.modulator, "halt", halting)


def test_an_interrupt_keeps_what_was_recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "run.h5"
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        with monkeypatch.context() as patch:
            interrupt_after_a_block(bench, patch)
            with pytest.raises(KeyboardInterrupt) as caught:
                bench.run(SMALL.model_copy(update={"frames": 1000}), out)
        assert any("of 6000 patterns are kept in" in note for note in caught.value.__notes__)
        assert not bench.modulator.running
        assert bench.run(SMALL, tmp_path / "again.h5").frame_valid.all()
    assert len(open_recording(out)) > 0
    assert "Ctrl-C" in plain.text(out, "entry/interrupted")


def test_an_existing_file_is_refused_before_anything_moves(tmp_path: Path) -> None:
    out = tmp_path / "run.h5"
    out.write_text("mine")
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        before_mm = bench.stage.position().reported_mm
        with pytest.raises(InputError, match="exists"):
            bench.run(SMALL, out)
        assert bench.stage.position().reported_mm == before_mm
    assert out.read_text() == "mine"


def test_a_plan_beyond_the_travel_is_refused(tmp_path: Path) -> None:
    far = SMALL.model_copy(update={"motion": MotionPlan(start_mm=395, velocity_mm_s=25)})
    with Instrument.from_toml(bench_toml(tmp_path)) as bench, pytest.raises(TravelExceeded, match="0 to 400 mm"):
        bench.run(far, tmp_path / "run.h5")
    assert not (tmp_path / "run.h5").exists()


def test_a_plan_with_too_many_patterns_is_refused(tmp_path: Path) -> None:
    toml = bench_toml(tmp_path, modulator="unique_patterns = 50")
    with Instrument.from_toml(toml) as bench, pytest.raises(PatternMemoryFull, match="84 unique patterns"):
        bench.run(SMALL, tmp_path / "run.h5")


def test_all_that_is_wrong_with_a_plan_is_said_at_once(tmp_path: Path) -> None:
    bad = SMALL.model_copy(update={"pattern_rate_hz": 50_000.0, "motion": MotionPlan(start_mm=500, velocity_mm_s=25)})
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        report = bench.check(bad)
        assert not report.ok
        with pytest.raises(PlanError, match=r"20 us.*500 mm"):
            report.raise_errors()


def test_the_scale_of_the_bench_is_used_in_the_check(tmp_path: Path) -> None:
    """25 mm/s x 1.8 px/mm x 300 us."""
    with Instrument.from_toml(_calibrated(tmp_path)) as bench:
        messages = [check.message for check in bench.check(SMALL).checks if check.name == "displacement"]
    assert messages == ["0.0135 px a frame, unambiguous within 8 px"]


def test_a_run_keeps_the_calibration_of_its_bench(tmp_path: Path) -> None:
    with Instrument.from_toml(_calibrated(tmp_path)) as bench:
        bench.run(SMALL, tmp_path / "run.h5")
        assert bench.calibration == read_calibration(tmp_path / "mine.toml")
    assert open_recording(tmp_path / "run.h5").calibration == bench.calibration


def test_a_calibration_of_another_bench_is_refused_and_the_devices_are_closed(tmp_path: Path) -> None:
    path = _calibrated(tmp_path)
    (tmp_path / "mine.toml").write_text((tmp_path / "mine.toml").read_text().replace("simulated KA400Z", "KA200"))
    with pytest.raises(
        InputError, match=r"stage: saw a calibration that was made with Kinopix KA200; expected one made w"
    ):
        Instrument.from_toml(path)


def _calibrated(folder: Path) -> Path:
    return calibrated_bench_toml(folder, displacement(1.8, image_size=SMALL.image_size, superpixel=SMALL.superpixel))


def test_leaving_makes_the_others_safe_when_one_device_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> None:
        raise OSError("the cable is gone")

    bench = Instrument.from_toml(bench_toml(tmp_path))
    moving = bench.stage.move_to(300, MotionPlan(velocity_mm_s=25).profile)
    monkeypatch.setattr(bench.modulator, "halt", broken)
    with pytest.raises(SafeStateFailed, match="modulator: the cable is gone"):
        bench.close()
    assert moving.done


def test_a_run_that_leaves_the_bench_unsafe_still_says_what_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken() -> None:
        raise OSError("the cable is gone")

    bench = Instrument.from_toml(bench_toml(tmp_path, 'faults = [{ kind = "stall", picture = 100 }]'))
    with monkeypatch.context() as patch:
        patch.setattr(bench.modulator, "halt", broken)
        with pytest.raises(SafeStateFailed, match="modulator: the cable is gone") as caught:
            bench.run(SMALL, tmp_path / "run.h5")
    assert isinstance(caught.value.__cause__, TriggerMissed)
    came_after, kept = caught.value.__notes__
    assert "it came after: pmt: saw 100 of 240 patterns" in came_after
    assert "100 of 240 patterns are kept" in kept
    bench.close()


@pytest.mark.parametrize(("on_abort", "rest_mm"), [("stop", 10.0), ("hold", 25.0), ("home", 0.0)])
def test_the_stage_does_after_an_abort_what_bench_toml_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, on_abort: str, rest_mm: float
) -> None:
    """Ramps are 6.25 mm. The first block comes 150 ms, 3.75 mm, into a cruise of 12.5 mm; a stop is immediate."""
    long = SMALL.model_copy(update={"frames": 1000})
    with Instrument.from_toml(bench_toml(tmp_path, stage=f'on_abort = "{on_abort}"')) as bench:
        interrupt_after_a_block(bench, monkeypatch)
        with pytest.raises(KeyboardInterrupt):
            bench.run(long, tmp_path / "run.h5")
        bench.devices.clock.sleep_s(5)
        assert bench.stage.position().reported_mm == pytest.approx(rest_mm, abs=0.05)
