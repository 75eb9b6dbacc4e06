"""Limits, steps and moments of the simulated devices: each bound on both sides, each time by a formula."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols import (
    BenchContext,
    CounterRun,
    DeviceTimeout,
    ModulatorTiming,
    MotionProfile,
    PatternSequence,
    PixelGrid,
    PlanError,
)
from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.devices import counter, modulator, stage
from sim_backends.devices.counter import CounterSettings
from sim_backends.devices.modulator import ModulatorSettings, SimulatedModulator
from sim_backends.devices.stage import SimulatedStage, StageSettings
from tests.sim_backends.projector import all_on, bench_with, show

PROFILE = MotionProfile(velocity_mm_s=25.0, acceleration_mm_s2=50.0)
GRID = PixelGrid(image_size=8, superpixel=2)


def _context(scene: dict[str, object] | None = None) -> tuple[BenchContext, OpticalBench]:
    bench = OpticalBench(SceneSettings.model_validate(scene or {}))
    bench.use_grid(GRID)
    return BenchContext(clock=bench.clock, scene=bench), bench


def _stage(**chosen: object) -> tuple[SimulatedStage, OpticalBench]:
    context, bench = _context()
    return stage.plugin.open(StageSettings.model_validate(chosen), context), bench


def _modulator(**chosen: object) -> tuple[SimulatedModulator, OpticalBench]:
    context, bench = _context()
    return modulator.plugin.open(ModulatorSettings.model_validate({"start_delay_s": 0.0} | chosen), context), bench


def _sequence(unique: int, pictures: int) -> PatternSequence:
    planes = np.zeros((unique, 8, 1), np.uint8)
    return PatternSequence(planes, np.arange(pictures) % unique, GRID, 8)


# Stage


def test_the_ends_of_the_travel_and_the_highest_speeds_can_be_had() -> None:
    """Travel -5 to 20 mm, 30 mm/s and 60 mm/s^2."""
    device, _ = _stage(travel_mm=[-5.0, 20.0], max_velocity_mm_s=30.0, max_acceleration_mm_s2=60.0)
    fastest = MotionProfile(velocity_mm_s=30.0, acceleration_mm_s2=60.0)
    assert device.limits.travel_mm == (-5.0, 20.0)
    for end_mm in (20.0, -5.0):
        assert device.move_to(end_mm, fastest).wait().reported_mm == pytest.approx(end_mm)


@settings(max_examples=30, deadline=None)
@given(start_mm=st.floats(0, 400), end_mm=st.floats(0, 400), step_mm=st.sampled_from([0.0025, 0.01, 0.5]))
def test_a_stage_ends_within_half_a_step_of_its_target(start_mm: float, end_mm: float, step_mm: float) -> None:
    device, _ = _stage(position_mm=start_mm, resolution_mm=step_mm)
    found = device.move_to(end_mm, PROFILE).wait()
    assert found.reported_mm == pytest.approx(end_mm, abs=step_mm / 2 + 1e-9)
    assert found.reported_mm / step_mm == pytest.approx(round(found.reported_mm / step_mm), abs=1e-6)


def test_without_a_time_limit_a_wait_outlasts_the_longest_motion() -> None:
    """Section 5.1 of the stage's fact sheet: 400 mm take 16.5 s."""
    device, bench = _stage()
    device.move_to(400.0, PROFILE).wait()
    assert bench.clock.now_s() == pytest.approx(16.5)


def test_a_wait_that_gives_up_has_waited_for_so_long_and_not_longer() -> None:
    """1 s after the start: 25 - 6.25 mm; the motion goes on, and a second wait sees its end at 1.5 s."""
    device, bench = _stage()
    motion = device.move_to(25.0, PROFILE)
    with pytest.raises(DeviceTimeout, match=r"18\.750 of 25\.000 mm after 1 s"):
        motion.wait(1.0)
    assert (bench.clock.now_s(), motion.done) == (1.0, False)
    assert motion.wait(0.5).time_s == pytest.approx(1.5)
    assert motion.done


@pytest.mark.parametrize(("travel_mm", "home_mm"), [([-20.0, 30.0], 0.0), ([5.0, 30.0], 5.0), ([-30.0, -10.0], -10.0)])
def test_home_is_zero_or_the_end_of_the_travel_nearest_to_it(travel_mm: list[float], home_mm: float) -> None:
    """At half of the highest velocity and acceleration, 50 mm/s and 200 mm/s^2: 15 mm take 15 / 25 + 25 / 100 s."""
    device, bench = _stage(travel_mm=travel_mm, position_mm=home_mm + (15.0 if home_mm >= 0 else -15.0))
    assert device.home().target_mm == home_mm
    bench.clock.advance_to(0.8499)
    assert device.position().reported_mm == pytest.approx(home_mm, abs=0.0013)
    bench.clock.advance_to(0.8501)
    assert device.position().reported_mm == pytest.approx(home_mm)
    device.move_to(device.limits.travel_mm[0], PROFILE)


def test_the_object_goes_on_where_a_stopped_stage_stands() -> None:
    """Stopped at 0.5 s after 6.25 mm, then back by 1 mm: 2 px/mm to the right."""
    bench = bench_with(px_per_mm=2.0, axis_angle_deg=0.0)
    device = stage.plugin.open(StageSettings(position_mm=50.0), BenchContext(clock=bench.clock, scene=bench))
    show(bench, [all_on()])
    device.move_by(100.0, PROFILE)
    bench.clock.advance_to(0.5)
    device.stop()
    device.move_by(-1.0, PROFILE).wait()
    shift_px = bench.truth(np.array([0.0, 0.25, 0.5, 10.0])).displacement_px[:, 0]
    assert shift_px.tolist() == pytest.approx([0.0, 2 * 1.5625, 12.5, 10.5])


# Modulator


@pytest.mark.parametrize(("unique", "pictures", "taken"), [(3, 7, True), (4, 7, False), (3, 8, False)])
def test_memory_and_play_order_take_as_much_as_they_hold(unique: int, pictures: int, *, taken: bool) -> None:
    """Three planes and seven pictures."""
    device, _ = _modulator(unique_patterns=3, play_order_entries=7)
    if taken:
        device.load(_sequence(unique, pictures), ModulatorTiming(picture_time_us=50))
    else:
        with pytest.raises(PlanError):
            device.load(_sequence(unique, pictures), ModulatorTiming(picture_time_us=50))


@pytest.mark.parametrize(("picture_time_us", "width_us"), [(44, 10), (44, 43), (10_000_000, 10)])
def test_the_shortest_and_the_longest_picture_and_the_widest_pulse_are_taken(
    picture_time_us: int, width_us: int
) -> None:
    """Section 3.10 of the modulator's fact sheet: 44 us to 10 s, and a pulse shorter than a picture."""
    device, bench = _modulator()
    timing = ModulatorTiming(picture_time_us=picture_time_us, sync_width_us=width_us)
    assert device.load(_sequence(1, 3), timing) == timing
    device.start()
    device.wait(100.0)
    assert bench.clock.now_s() == pytest.approx(3 * picture_time_us * 1e-6)


def test_a_run_is_over_at_the_end_of_its_last_picture() -> None:
    """Delayed by 1 ms, and by 20 us from edge to picture: 1.02 ms and four times 50 us."""
    device, bench = _modulator(start_delay_s=1e-3)
    device.load(_sequence(2, 4), ModulatorTiming(picture_time_us=50, sync_delay_us=20))
    device.start()
    assert bench.edges(0, 1.0).time_s.tolist() == pytest.approx([1e-3 + k * 50e-6 for k in range(4)])
    bench.clock.advance_to(1.2199e-3)
    assert device.running
    bench.clock.advance_to(1.2201e-3)
    assert not device.running


def test_a_time_out_tells_how_many_edges_were_given() -> None:
    """At 120 us the pictures 0, 1 and 2 of ten have begun."""
    device, _ = _modulator()
    device.load(_sequence(1, 10), ModulatorTiming(picture_time_us=50))
    device.start()
    with pytest.raises(DeviceTimeout, match="3 of 10 sync edges given"):
        device.wait(120e-6)


# Counter


@pytest.mark.parametrize(
    ("latency_s", "blocks"), [(1e-6, [1] * 7), (100e-6, [2, 2, 2, 1]), (130e-6, [3, 3, 1]), (1.0, [7])]
)
def test_a_block_holds_as_many_bins_as_the_latency_has_periods(latency_s: float, blocks: list[int]) -> None:
    """Rounded to whole bins of 50 us, and one at least; 2.6 are 3."""
    bench = bench_with()
    device = counter.plugin.open(CounterSettings(), BenchContext(clock=bench.clock, scene=bench))
    device.arm(CounterRun(n_bins=7, period_s=50e-6, latency_s=latency_s))
    show(bench, [all_on()] * 7, start_s=1e-3)
    found = [device.read(1.0) for _ in blocks]
    assert [len(block) for block in found] == blocks
    assert [block.first_bin for block in found] == np.cumsum([0, *blocks[:-1]]).tolist()
    assert device.disarm().bins_closed == 7


@pytest.mark.parametrize(
    ("resolution_s", "ticks"), [(10e-9, [0, 5000, 10_000]), (7e-6, [0, 7, 14]), (30e-6, [0, 2, 3])]
)
def test_edge_times_are_rounded_to_the_nearest_tick(resolution_s: float, ticks: list[int]) -> None:
    """50 us are 5000 ticks of 10 ns, 7.14 of 7 us and 1.67 of 30 us; 100 us are twice as many before they are rounded."""
    bench = bench_with()
    chosen = CounterSettings(edge_times=True, edge_time_resolution_s=resolution_s)
    device = counter.plugin.open(chosen, BenchContext(clock=bench.clock, scene=bench))
    device.arm(CounterRun(n_bins=2, period_s=50e-6, latency_s=1.0))
    show(bench, [all_on()] * 2, start_s=1e-3)
    block = device.read(1.0)
    assert block.opening_edge_s is not None
    assert [*block.opening_edge_s.tolist(), block.closing_edge_s] == pytest.approx([k * resolution_s for k in ticks])
    assert device.limits.edge_time_resolution_s == resolution_s
