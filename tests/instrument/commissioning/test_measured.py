"""What each measurement finds, against figures by hand, and what it doubts."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from instrument.commissioning import commission
from instrument.commissioning.counter import dark, dead_time, order, pulses_edges_reads
from instrument.commissioning.modulator import playing, upload
from instrument.commissioning.stage import Stretch, homing, standing, stop, travel
from instrument.session import Instrument
from protocols import Answer, DeviceTimeout, ModulatorTiming, PatternSequence, UploadProgress
from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.devices.modulator import ModulatorSettings, SimulatedModulator
from sim_backends.devices.stage import SimulatedStage, StageSettings
from tests.instrument.commissioning.test_commission import LAMP, agreed, counter_bench, written

PICTURE_S = 44e-6


def number(answer: Answer, name: str) -> float:
    value = answer.figures[name]
    assert isinstance(value, int | float)
    return float(value)


class OddModulator(SimulatedModulator):
    """One that stores slowly, keeps another time, is slow to say that it plays, or goes on after a halt."""

    def __init__(self, bench: OpticalBench, **odd: float) -> None:
        super().__init__(ModulatorSettings(), bench)
        self.bench, self.odd = bench, odd

    def load(
        self, sequence: PatternSequence, timing: ModulatorTiming, progress: UploadProgress | None = None
    ) -> ModulatorTiming:
        self.bench.clock.sleep_s(self.odd.get("load_s", 0.0) * len(sequence.planes))
        kept = super().load(sequence, timing, progress)
        return kept.model_copy(update={"picture_time_us": kept.picture_time_us + int(self.odd.get("more_us", 0))})

    @property
    def running(self) -> bool:
        return super().running and not self.odd.get("mute")

    def halt(self) -> None:
        if not self.odd.get("deaf"):
            super().halt()

    @property
    def limits(self) -> Any:
        return super().limits.model_copy(update={"longest_upload_s": self.odd.get("promised_s", 0.0)})


def test_an_upload_is_timed_a_pattern_and_held_against_what_is_promised() -> None:
    bench = OpticalBench(SceneSettings())
    found = upload(OddModulator(bench, load_s=0.02, promised_s=0.01), bench.clock)
    assert number(found, "patterns") == 25
    assert number(found, "upload_s") == pytest.approx(0.5)
    assert number(found, "upload_s_per_pattern") == pytest.approx(0.02)
    assert found.doubts == ("a pattern takes 0.02 s, and 0.01 s at most are promised",)
    assert upload(OddModulator(bench, load_s=0.01, promised_s=0.01), bench.clock).doubts == ()
    (doubt,) = upload(OddModulator(bench, more_us=3), bench.clock).doubts
    assert doubt == "a picture time of 10000 us was asked, 10003 us are kept"


def test_an_emulated_alp_board_takes_its_upload_at_30_mb_a_second() -> None:
    """98,304 bytes a pattern (dlp7000.md 3.8)."""
    path = Path(__file__).parents[3] / "examples" / "benches" / "alp-ni-mc600.toml"
    with Instrument.from_toml(path, only=("modulator",)) as bench:
        found = upload(bench.modulator, bench.devices.clock)
    assert number(found, "upload_s_per_pattern") == pytest.approx(98_304 / 30e6)


def test_a_run_of_1001_dark_pictures_is_timed_and_halted() -> None:
    bench = OpticalBench(SceneSettings())
    found = playing(OddModulator(bench), bench.clock)
    assert number(found, "expected_s") == pytest.approx(1001 * PICTURE_S)
    assert number(found, "run_s") == pytest.approx(1001 * PICTURE_S, abs=0.01)
    assert (found.figures["pictures"], found.figures["picture_time_us"]) == (1001, 44)
    assert (found.figures["runs_at_once"], number(found, "halt_s"), found.doubts) == (True, 0.0, ())


def test_a_modulator_that_does_not_say_what_it_does_is_doubted_and_one_that_does_not_halt_is_an_error() -> None:
    bench = OpticalBench(SceneSettings())
    mute = playing(OddModulator(bench, mute=1), bench.clock)
    assert mute.figures["runs_at_once"] is False
    assert [doubt.split(" that ")[0] for doubt in mute.doubts] == ["it does not say", "it does not say"]
    with pytest.raises(DeviceTimeout, match=r"one that plays, halted after 1 s"):
        playing(OddModulator(bench, deaf=1), bench.clock)
    late = playing(OddModulator(bench, more_us=60), bench.clock)
    assert late.doubts == ("the run's length is not pictures times picture time",)


def test_edges_and_reads_of_five_dark_runs(tmp_path: Path) -> None:
    """Jitter of 200 ns at both ends of a step: 283 ns. One read a run, of 1000 bins, when its 1001 pictures are over."""
    bench_file = counter_bench(tmp_path, 'driver = "simulated"', LAMP + "sync_jitter_s = 2e-7\n")
    with Instrument.from_toml(bench_file, only=("modulator", "counter")) as bench:
        found = pulses_edges_reads(bench)
    assert number(found["edges"], "mean_s") == pytest.approx(PICTURE_S, rel=1e-5)
    assert number(found["edges"], "scatter_s") == pytest.approx(2e-7 * np.sqrt(2), rel=0.05)
    assert number(found["edges"], "ppm") == pytest.approx(0, abs=5)
    assert number(found["edges"], "longest_s") > PICTURE_S + 5e-7
    assert number(found["reads"], "bins_per_read") == 1000
    assert number(found["reads"], "reads_per_s") == pytest.approx(1 / (1001 * PICTURE_S), rel=0.01)
    assert 0 < number(found["reads"], "cpu_s_per_bin") < 1e-3
    assert number(found["pulses"], "rate_hz") == pytest.approx(1 / PICTURE_S)
    first_bin_s = found["pulses"].figures["first_bin_s"]
    assert isinstance(first_bin_s, tuple)
    assert first_bin_s == pytest.approx((1001 * PICTURE_S,) * 5, abs=3 * PICTURE_S)
    assert all(answer.doubts == () for answer in found.values())


@pytest.mark.parametrize(("ppm", "doubted"), [(190.0, False), (-210.0, True)])
def test_a_clock_that_no_crystal_has_is_doubted(tmp_path: Path, ppm: float, doubted: bool) -> None:  # noqa: FBT001
    """A timebase that is fast counts more ticks: the steps look longer."""
    counter = f'driver = "ni"\ntransport = "ni-emulator"\nemulator = {{ timebase_ppm = {ppm} }}'
    with Instrument.from_toml(counter_bench(tmp_path, counter), only=("modulator", "counter")) as bench:
        edges = pulses_edges_reads(bench)["edges"]
    assert number(edges, "ppm") == pytest.approx(ppm, abs=2)
    assert bool(edges.doubts) is doubted


def test_dark_counts_are_counted_for_a_second(tmp_path: Path) -> None:
    """600 a second: 24.5 a second of standard deviation, and 1.1 counts in 2 ms."""
    scene = LAMP.replace("peak_counts", "dark_rate_hz = 600, peak_counts")
    with Instrument.from_toml(
        counter_bench(tmp_path, 'driver = "simulated"', scene), only=("modulator", "counter")
    ) as bench:
        found = dark(bench)
    assert number(found, "rate_hz") == pytest.approx(600, abs=4 * 24.5)
    assert number(found, "sigma_hz") == pytest.approx(np.sqrt(600), rel=0.1)
    assert number(found, "scatter_of_a_bin") == pytest.approx(np.sqrt(1.2), rel=0.1)


def test_a_modulator_with_room_for_20_pictures_is_measured_with_19_and_the_guard(tmp_path: Path) -> None:
    """4 cycles of dark, white and both halves. The mirrors turn in 0.4 ms: a tenth of the white light is in the next bin."""
    bench_file = written(
        tmp_path,
        '[modulator]\ndriver = "simulated"\nplay_order_entries = 20\n[counter]\ndriver = "simulated"\n'
        + LAMP.replace("peak_counts", "dark_rate_hz = 1e5, peak_counts")
        + "mirror_transition_s = 4e-4\n",
    )
    with Instrument.from_toml(bench_file, only=("modulator", "counter")) as bench:
        pulses, halves, bright = pulses_edges_reads(bench)["pulses"], dead_time(bench), order(bench)
        assert number(dark(bench), "rate_hz") == pytest.approx(1e5, rel=0.1)
    assert "bins 19, 19, 19, 19, 19; 20 edges; first bin" in pulses.said
    light = [number(halves, name) for name in ("half_hz", "other_half_hz", "dark_hz", "white_hz")]
    assert number(halves, "halves_over_whole") == pytest.approx((light[0] + light[1] - light[2]) / light[3])
    assert bright.figures["bright_bin"] == 7
    assert number(bright, "share_in_next_bin") == pytest.approx(0.1, abs=0.02)


def test_a_lost_pulse_is_doubted_with_both_numbers(tmp_path: Path) -> None:
    bench_file = counter_bench(
        tmp_path, 'driver = "simulated"', LAMP + 'faults = [{ kind = "surplus-edges", edges = 2 }]\n'
    )
    with Instrument.from_toml(bench_file, only=("modulator", "counter")) as bench:
        pulses = pulses_edges_reads(bench)["pulses"]
    assert pulses.figures["edges"] == (1003.0,) * 5
    assert "bins 1000, 1000, 1000, 1000, 1000; edges 1003, 1003, 1003, 1003, 1003; first bin" in pulses.said
    assert pulses.doubts[-1] == "1000 pictures and the guard must give 1000 bins and 1001 edges each time"


def test_a_stage_is_measured_near_to_where_it_stands_and_back() -> None:
    bench = OpticalBench(SceneSettings())
    stage = SimulatedStage(StageSettings(position_mm=200.0), bench)
    stretch = Stretch(stage)
    assert (stretch.here_mm, stretch.there_mm) == (200.0, 202.0)
    assert (stretch.profile.velocity_mm_s, stretch.profile.acceleration_mm_s2) == (5.0, 20.0)
    still = standing(stage, bench.clock)
    assert (number(still, "position_mm"), number(still, "spread_mm"), still.figures["homed"]) == (200.0, 0.0, True)
    assert stage.position().reported_mm == 200.0
    moved = travel(stage, bench.clock)
    assert number(moved, "expected_s") == pytest.approx(0.65)
    assert number(moved, "move_s") == pytest.approx(0.65, abs=0.021)
    assert (number(moved, "longest_error_mm"), number(moved, "spread_at_return_mm")) == (0.0, 0.0)
    stopped = stop(stage, bench.clock)
    assert number(stopped, "of_mm") == 2.0
    assert number(stopped, "stands_after_s") == pytest.approx(0, abs=1e-9)
    assert number(stopped, "stopped_after_mm") == pytest.approx(1.0, abs=0.01)  # half of the time is half of the way
    assert stopped.doubts == ()
    home = homing(stage, bench.clock)
    assert (number(home, "position_before_mm"), number(home, "position_after_mm")) == (200.0, 0.0)
    assert stage.position().reported_mm == 200.0


def test_the_longest_error_and_the_spread_are_those_of_all_moves() -> None:
    """Steps of 0.3 mm: 2 mm there is 2.1, and 0 mm back is 0."""
    bench = OpticalBench(SceneSettings())
    moved = travel(SimulatedStage(StageSettings(resolution_mm=0.3), bench), bench.clock)
    assert number(moved, "longest_error_mm") == pytest.approx(0.1)
    assert number(moved, "spread_at_return_mm") == 0.0
    assert "it ends within 100 um of its target" in moved.said


@pytest.mark.parametrize(
    ("travel_mm", "position_mm", "there_mm"),
    [((0.0, 400.0), 399.0, 397.0), ((0.0, 10.0), 4.0, 5.0), ((0.0, 10.0), 6.0, 5.0)],
)
def test_the_stretch_is_2_mm_or_a_tenth_of_the_travel_to_the_side_with_room(
    travel_mm: tuple[float, float], position_mm: float, there_mm: float
) -> None:
    bench = OpticalBench(SceneSettings())
    stage = SimulatedStage(StageSettings(travel_mm=travel_mm, position_mm=position_mm), bench)
    assert Stretch(stage).there_mm == pytest.approx(there_mm)


def test_a_stage_with_wrong_units_takes_another_time_than_its_profile(tmp_path: Path) -> None:
    """Half of the factor is half of the speed: 2 mm at 2.5 mm/s take 0.8 s and more."""
    stage = """[stage]
driver = "zaber"
transport = "zaber-emulator"
microsteps_per_mm = 15625
speed_factor = 0.8192
travel_mm = [0.0, 400.0]
max_velocity_mm_s = 50.0
max_acceleration_mm_s2 = 200.0
[scene]
"""
    (device,) = commission(written(tmp_path, stage), agreed).devices
    found = device.measured["travel"]
    assert found.state == "doubtful"
    assert number(found.answer, "move_s") > 0.8
    assert found.answer.doubts[0].endswith("are velocity and acceleration in the right units?")
