"""The driver on its emulated board: values to their stated noise, overloads, signs, limits, faults."""

from collections.abc import Generator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from drivers.ni.analog.plugin import open_analog
from drivers.ni.analog.settings import NiAnalogSettings
from protocols import (
    BenchContext,
    CountBlock,
    CounterOverrun,
    CounterReport,
    CounterRun,
    DeviceBusy,
    DriverUnavailable,
    InputError,
    PlanError,
)
from sim_backends.bench import OpticalBench, Projection, SceneSettings
from sim_backends.wire.ni_analog.plugin import plugin

N, PERIOD_S = 40, 1e-4


@contextmanager
def counter_on(board: dict[str, Any] | None = None, **settings: Any) -> Generator[tuple[Any, OpticalBench]]:
    noise = {"kind": "poisson", "peak_counts": 1000.0, "seed": 1}
    bench = OpticalBench(SceneSettings.model_validate({"object": "letter-B", "noise": noise}))
    context = BenchContext(clock=bench.clock, scene=bench)
    options: Any = plugin.open(plugin.settings.model_validate(board or {}), context)
    with (
        options,
        open_analog(
            NiAnalogSettings.model_validate(settings), BenchContext(clock=bench.clock, transport=options)
        ) as counter,
    ):
        yield counter, bench


def run(counter: Any, bench: OpticalBench) -> tuple[CountBlock, CounterReport]:
    counter.arm(CounterRun(n_bins=N, period_s=PERIOD_S))
    lit_and_dark = np.stack([np.full((768, 128), fill, np.uint8) for fill in (0xFF, 0x00)])
    order = np.append(np.arange(N) % 2, 1)
    bench.show(Projection(bench.clock.now_s() + 1e-3, PERIOD_S, lambda index: lit_and_dark[index], order))
    bench.clock.sleep_s(0.1)
    block = counter.read(1.0)
    return block, counter.disarm()


def test_values_are_volts_to_the_noise_that_is_stated() -> None:
    """2 mV a sample, 50 samples a bin of which 8 are left out: 2 / sqrt(42) = 0.309 mV."""
    with counter_on() as (counter, bench):
        block, report = run(counter, bench)
        light = bench.counts(0, N)
    assert block.counts.dtype == np.float64
    assert len(block) == N
    error_v = block.counts - 1e-3 * light
    assert np.sqrt(np.mean(error_v**2)) == pytest.approx(0.309e-3, rel=0.35)
    assert np.abs(error_v).max() < 4.5 * 0.309e-3
    stated = float(report.notes[0].split("noise of one ")[1].split(" V")[0])
    assert stated == pytest.approx(0.309e-3, rel=0.1)
    assert report.edges_seen == N + 1
    assert block.suspect is not None
    assert not block.suspect.any()


def test_edges_have_times_to_one_sample() -> None:
    with counter_on() as (counter, bench):
        block, _ = run(counter, bench)
        assert counter.limits.edge_time_resolution_s == 2e-6
    assert block.opening_edge_s is not None
    np.testing.assert_allclose(block.opening_edge_s, np.arange(N) * PERIOD_S, atol=2.1e-6)
    assert block.closing_edge_s == pytest.approx(N * PERIOD_S, abs=2.1e-6)


def test_an_overload_is_told_for_its_bins_and_in_the_report() -> None:
    """The lit bins reach some 20 V, and the input clips at 10."""
    with counter_on({"volts_per_light": 0.02}) as (counter, bench):
        block, report = run(counter, bench)
    assert block.suspect is not None
    assert block.suspect.tolist() == [k % 2 == 0 for k in range(N)]
    assert f"{N // 2} bins reached 99% of the range" in " ".join(report.notes)


def test_a_negative_signal_and_its_offset_become_positive_light() -> None:
    board = {"polarity": "negative", "offset_v": -0.25}
    with counter_on(board, polarity="negative", offset_v=-0.25) as (counter, bench):
        block, _ = run(counter, bench)
        light = bench.counts(0, N)
    np.testing.assert_allclose(block.counts, 1e-3 * light, atol=2e-3)


def test_settling_that_is_not_cut_off_shows_the_picture_before() -> None:
    """A slow preamplifier of 20 us: without a cut the dark bins hold a fifth of the light before them."""
    slow = {"settle_s": 20e-6, "noise_v": 0.0}
    with counter_on(slow, settle_s=0.0) as (counter, bench):
        uncut, _ = run(counter, bench)
    with counter_on(slow, settle_s=80e-6) as (counter, bench):
        cut, _ = run(counter, bench)
    assert uncut.counts[1] / uncut.counts[0] > 0.15
    assert cut.counts[1] / cut.counts[0] < 0.015


def test_a_run_too_fast_for_the_settling_is_refused() -> None:
    """8 samples of 2 us are left out and 4 must remain: 24 us, 41.7 kHz."""
    with counter_on() as (counter, _):
        assert counter.limits.max_sync_rate_hz == pytest.approx(500_000 / 12)
        with pytest.raises(PlanError, match="41666"):
            counter.arm(CounterRun(n_bins=N, period_s=23e-6))


def test_more_samples_than_the_board_takes_are_refused_at_opening() -> None:
    with pytest.raises(InputError, match="at most 500000"), counter_on(sample_rate_hz=500_001.0):
        pass
    with counter_on({"simultaneous": True}, sample_rate_hz=1_000_000.0):
        pass


def test_a_board_that_is_not_there_is_unavailable() -> None:
    with pytest.raises(DriverUnavailable), counter_on(device="Dev2"):
        pass


def test_inputs_that_another_program_holds_are_busy() -> None:
    with counter_on({"reserved": True}) as (counter, _), pytest.raises(DeviceBusy):
        counter.arm(CounterRun(n_bins=N, period_s=PERIOD_S))


def test_an_overrun_is_told() -> None:
    with counter_on({"overrun_at_read": 0}) as (counter, bench), pytest.raises(CounterOverrun):
        run(counter, bench)


@pytest.mark.parametrize(
    "wrong",
    [{"sync_channel": "ai0"}, {"sync_hysteresis_v": 1.5}, {"sync_threshold_v": 10.0}, {"range_v": -1.0}],
)
def test_settings_that_cannot_be_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        NiAnalogSettings.model_validate(wrong)
