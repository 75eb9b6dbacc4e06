"""The simulated DMD keeps the limits and the life cycle of the real one."""

from pathlib import Path

import numpy as np
import pytest

from protocols import (
    BenchContext,
    DeviceBusy,
    DeviceTimeout,
    InputError,
    ModulatorTiming,
    PatternMemoryFull,
    PatternModulator,
    PatternSequence,
    PictureTimeTooShort,
    PixelGrid,
    PlanError,
    WrongState,
)
from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.devices.modulator import ModulatorSettings, SimulatedModulator, plugin

GRID = PixelGrid(image_size=8, superpixel=2)
TIMING = ModulatorTiming(picture_time_us=50)


def sequence(pictures: int = 10, grid: PixelGrid = GRID) -> PatternSequence:
    planes = np.concatenate([np.full((1, 8, 1), 255, np.uint8), np.zeros((1, 8, 1), np.uint8)])
    return PatternSequence(planes, np.array([0] * pictures + [1]), grid, 8)


def dmd(scene: dict[str, object] | None = None, /, **settings: int) -> tuple[SimulatedModulator, OpticalBench]:
    bench = OpticalBench(SceneSettings.model_validate(scene or {}))
    bench.use_grid(GRID)
    chosen = ModulatorSettings.model_validate({"start_delay_s": 0.0, **settings})
    return plugin.open(chosen, BenchContext(clock=bench.clock, scene=bench)), bench


def test_it_is_a_modulator_that_says_it_is_simulated() -> None:
    device, _ = dmd()
    assert isinstance(device, PatternModulator)
    assert device.identity.name == "dmd"
    assert device.identity.simulated


def test_its_limits_are_those_of_a_dlp7000() -> None:
    limits = dmd()[0].limits
    assert (limits.columns, limits.rows) == (1024, 768)
    assert limits.shortest_picture_time_us == 44  # 22,727 patterns a second
    assert limits.unique_patterns == 43_690


def test_a_run_takes_one_picture_time_for_each_entry_of_the_play_order() -> None:
    device, bench = dmd()
    assert device.load(sequence(10), TIMING) == TIMING
    states = [device.running]
    device.start()
    states.append(device.running)
    device.wait(1.0)
    states.append(device.running)
    assert states == [False, True, False]
    assert bench.clock.now_s() == pytest.approx(11 * 50e-6)
    assert len(bench.edges(0, 1.0)) == 11


def test_the_same_sequence_can_be_played_again() -> None:
    device, bench = dmd()
    device.load(sequence(), TIMING)
    for _ in range(2):
        device.start()
        device.wait(1.0)
    assert bench.edges(0, 1.0).time_s[0] == pytest.approx(11 * 50e-6)


def test_a_sync_delay_puts_the_edges_before_the_pictures() -> None:
    device, bench = dmd(start_delay_s=1)
    device.load(sequence(2), ModulatorTiming(picture_time_us=50, sync_delay_us=10))
    device.start()
    assert bench.edges(0, 9.0).time_s.tolist() == pytest.approx([1.0, 1.00005, 1.0001])
    assert bench.counts(0, 1)[0] == pytest.approx(0.8 * bench.truth(np.zeros(1)).image.sum())


def test_the_first_edge_comes_a_moment_after_the_start() -> None:
    bench = OpticalBench(SceneSettings())
    device = plugin.open(ModulatorSettings(), BenchContext(clock=bench.clock, scene=bench))
    device.load(sequence(2), TIMING)
    device.start()
    assert bench.edges(0, 1.0).time_s[0] == pytest.approx(1e-4)


def test_every_stored_pattern_is_reported() -> None:
    steps: list[tuple[int, int]] = []
    dmd()[0].load(sequence(), TIMING, lambda done, of: steps.append((done, of)))
    assert steps == [(1, 2), (2, 2)]


@pytest.mark.parametrize(
    ("settings", "timing", "error", "words"),
    [
        ({"unique_patterns": 1}, TIMING, PatternMemoryFull, "2 unique patterns; expected at most 1"),
        ({"play_order_entries": 10}, TIMING, PatternMemoryFull, "11 pictures in the play order; expected at most 10"),
        ({}, ModulatorTiming(picture_time_us=43), PictureTimeTooShort, "43 us; expected at least 44 us"),
        ({}, ModulatorTiming(picture_time_us=10_000_001), PlanError, "at most 10000000 us"),
        ({}, ModulatorTiming(picture_time_us=50, sync_width_us=50), PlanError, "shorter than the picture time"),
        ({"columns": 1920, "rows": 1080}, TIMING, PlanError, "patterns for 1024 x 768 mirrors; expected 1920 x 1080"),
    ],
)
def test_what_it_cannot_play_is_refused_and_nothing_stays_loaded(
    settings: dict[str, int], timing: ModulatorTiming, error: type[PlanError], words: str
) -> None:
    device, _ = dmd(None, **settings)
    with pytest.raises(error, match=words):
        device.load(sequence(), timing)
    with pytest.raises(WrongState, match="without a sequence"):
        device.start()


def test_start_needs_an_idle_loaded_modulator() -> None:
    device, _ = dmd()
    device.load(sequence(), TIMING)
    device.start()
    with pytest.raises(WrongState, match="while the last run still plays"):
        device.start()
    with pytest.raises(DeviceBusy):
        device.load(sequence(), TIMING)


def test_wait_needs_a_start_and_says_when_it_gives_up() -> None:
    device, bench = dmd()
    with pytest.raises(WrongState, match="never started"):
        device.wait(1.0)
    device.load(sequence(), TIMING)
    device.start()
    with pytest.raises(DeviceTimeout, match=r"still playing after 0\.0001 s"):
        device.wait(1e-4)
    assert bench.clock.now_s() == 1e-4


def test_halt_ends_a_run_at_any_time_and_twice() -> None:
    device, bench = dmd()
    device.halt()
    device.load(sequence(), TIMING)
    device.start()
    bench.clock.advance_to(120e-6)
    device.halt()
    device.halt()
    assert not device.running
    assert len(bench.edges(0, 1.0)) == 3
    device.wait(0.0)
    device.start()


def test_a_stalled_modulator_runs_for_ever_until_it_is_halted() -> None:
    device, _ = dmd({"faults": [{"kind": "stall", "picture": 3}]})
    device.load(sequence(), TIMING)
    device.start()
    with pytest.raises(DeviceTimeout):
        device.wait(3600.0)
    device.halt()
    assert not device.running


def test_leaving_it_halts_and_closes_it() -> None:
    device, bench = dmd()
    with device:
        device.load(sequence(), TIMING)
        device.start()
    assert bench.edges(0, 1.0).finished
    with pytest.raises(WrongState, match="after the device was closed"):
        device.start()
    with pytest.raises(WrongState, match="after the device was closed"):
        device.load(sequence(), TIMING)


def test_without_a_scene_it_cannot_be_opened() -> None:
    with pytest.raises(InputError, match=r"dmd: saw no \[scene\] table"):
        plugin.open(ModulatorSettings(), BenchContext(folder=Path()))
