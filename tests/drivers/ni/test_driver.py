"""The NI driver on scripted counters: cumulative samples in, bins and edge times out, and nothing good lost."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from drivers.h10682.counter import H10682Counter
from drivers.ni.driver import ni_counter
from drivers.ni.errors import MEANINGS, NiFault
from drivers.ni.samples import SampledCounter
from drivers.ni.settings import NiSettings
from drivers.ni.tasks import NiBoardFacts
from protocols import (
    CounterOverrun,
    CounterRun,
    DeviceBusy,
    DeviceDisconnected,
    DeviceRefused,
    DriverUnavailable,
    InputError,
    KinopixError,
    PhotonCounter,
    PlanError,
    TimingFault,
    WrongState,
)
from tests.drivers.h10682.clock import ScriptClock
from tests.drivers.ni.script import X_SERIES, ScriptedNi, ScriptedTask

PERIOD_S = 50e-6
TICKS = 5000
WRAP = 2**32


def edges(n: int, first_s: float = 0.0) -> list[float]:
    return [first_s + k * PERIOD_S for k in range(n)]


def bench(
    samples: list[int],
    ticks: list[int] | None = None,
    *,
    settings: NiSettings | None = None,
    photon_breaks: int | None = None,
    tick_breaks: int | None = None,
    fault: NiFault | None = None,
    breaks_available: bool = False,
) -> tuple[H10682Counter, ScriptedNi, list[ScriptedTask], ScriptClock]:
    clock = ScriptClock()
    ticks = [123 + TICKS * k for k in range(len(samples))] if ticks is None else ticks
    tasks = [
        ScriptedTask(clock, samples, edges(len(samples)), photon_breaks, breaks_available=breaks_available),
        ScriptedTask(clock, ticks, edges(len(ticks)), tick_breaks, breaks_available=breaks_available),
    ]
    for task in tasks:
        task.fault = fault or task.fault
    system = ScriptedNi(list(tasks))
    return ni_counter(settings or NiSettings(), system, clock), system, tasks, clock


def run(n_bins: int, latency_s: float = 0.05) -> CounterRun:
    return CounterRun(n_bins=n_bins, period_s=PERIOD_S, latency_s=latency_s)


def test_counts_are_differences_of_samples_and_the_first_sample_is_dropped() -> None:
    device, _, tasks, _ = bench([1000, 1005, 1005, 1012], [777, 5777, 10777, 15787])
    assert isinstance(device, PhotonCounter)
    device.arm(run(3))
    block = device.read(1.0)
    assert block.first_bin == 0
    assert block.counts.dtype == np.uint32
    assert block.counts.tolist() == [5, 0, 7]
    assert block.opening_edge_s is not None
    assert block.opening_edge_s.tolist() == pytest.approx([0.0, 50e-6, 100e-6], abs=1e-12)
    assert block.closing_edge_s == pytest.approx(150.1e-6, abs=1e-12)
    report = device.disarm()
    assert (report.bins_closed, report.edges_seen, report.notes) == (3, 4, ())
    assert [task.calls[-2:] for task in tasks] == [["stop", "close"]] * 2


def test_the_two_counters_are_configured_as_the_fact_sheet_says() -> None:
    device, system, _, _ = bench([0], settings=NiSettings(sync_filter_s=125e-9, arm_terminal="PFI1"))
    device.arm(run(3))
    photons, ticks = system.counts
    assert (photons.counter, photons.source, photons.clock) == ("Dev1/ctr0", "/Dev1/PFI8", "/Dev1/PFI9")
    assert (photons.prevent_duplicates, photons.clock_filter_s, photons.arm) == (True, 125e-9, "/Dev1/PFI1")
    assert photons.max_rate_hz == pytest.approx(25_000)
    assert photons.buffer_samples == 200_000
    assert (ticks.counter, ticks.source, ticks.clock) == ("Dev1/ctr1", "/Dev1/100MHzTimebase", "/Dev1/PFI9")
    assert not ticks.prevent_duplicates
    device.disarm()


def test_without_an_edge_counter_there_are_counts_and_no_edge_times() -> None:
    device, system, _, _ = bench([3, 4, 6], settings=NiSettings(edge_counter=None))
    assert device.limits.edge_time_resolution_s is None
    device.arm(run(2))
    block = device.read(1.0)
    assert block.counts.tolist() == [1, 2]
    assert block.opening_edge_s is None
    assert len(system.counts) == 1
    device.disarm()


def test_the_counter_may_wrap_within_a_bin_and_between_blocks() -> None:
    device, _, _, _ = bench([WRAP - 3, WRAP - 1, 4, 10], [WRAP - 100, 4900, 9900, 14900])
    device.arm(run(3, latency_s=PERIOD_S))
    blocks = [device.read(PERIOD_S) for _ in range(4)]
    assert np.concatenate([b.counts for b in blocks]).tolist() == [2, 5, 6]
    times = np.concatenate([b.opening_edge_s for b in blocks if b.opening_edge_s is not None])
    assert times.tolist() == pytest.approx([0.0, 50e-6, 100e-6], abs=1e-12)


def test_surplus_edges_are_seen_and_not_handed_over() -> None:
    device, _, _, clock = bench([0, 5, 6, 7, 9])
    device.arm(run(2))
    assert device.read(1.0).counts.tolist() == [5, 1]
    clock.sleep_s(1.0)
    assert len(device.read(1.0)) == 0
    assert device.disarm().edges_seen == 5


def test_a_second_at_20_khz_is_read_at_most_20_times_a_counter() -> None:
    n = 20_000
    device, _, tasks, clock = bench(list(range(0, 3 * n + 3, 3)))
    device.arm(run(n))
    got = 0
    while got < n:
        got += len(device.read(0.2))
    assert clock.now_s() == pytest.approx(1.0, abs=0.051)
    assert all(len(task.reads) <= 20 for task in tasks)
    device.disarm()


def test_no_light_still_gives_every_bin() -> None:
    device, _, _, _ = bench([0] * 6)
    device.arm(run(5))
    assert device.read(1.0).counts.tolist() == [0] * 5
    device.disarm()


def test_a_photon_counter_that_skips_dark_bins_is_found_out() -> None:
    device, _, _, _ = bench([0, 5, 9], [0, 5000, 10000, 15000])
    device.arm(run(3))
    assert device.read(0.05).counts.tolist() == [5, 4]
    with pytest.raises(
        TimingFault, match=r"3 samples of the photon counter for 4 of the edge counter.*prevent_duplicates"
    ):
        device.read(0.05)
    report = device.disarm()
    assert report.edges_seen == 4
    assert report.shifted
    assert "bins may have shifted" in report.notes[-1]


# --- faults ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("breaks_available", [False, True])
@pytest.mark.parametrize("code", sorted(set(MEANINGS)))
def test_whatever_code_breaks_a_run_the_counts_before_it_are_handed_over(code: int, *, breaks_available: bool) -> None:
    device, _, _, _ = bench(
        [0, 5, 6, 8, 9, 9],
        photon_breaks=4,
        tick_breaks=4,
        fault=NiFault("NI's words", code),
        breaks_available=breaks_available,
    )
    device.arm(run(5))
    got = device.read(0.1)
    assert got.counts.tolist() == [5, 1, 2]
    assert got.opening_edge_s is not None
    with pytest.raises(KinopixError) as raised:
        device.read(0.1)
    assert str(code) in str(raised.value) or "3 of 5 patterns" in str(raised.value)
    report = device.disarm()
    assert report.bins_closed == 3
    assert "the run broke off" in report.notes[0]


def test_when_the_edge_counter_breaks_first_the_photons_come_without_edge_times() -> None:
    device, _, _, _ = bench([0, 5, 6, 8], tick_breaks=2, fault=NiFault("", -200361))
    device.arm(run(5))
    timed, untimed = device.read(0.1), device.read(0.1)
    assert timed.counts.tolist() == [5]
    assert timed.opening_edge_s is not None
    assert untimed.counts.tolist() == [1, 2]
    assert untimed.first_bin == 1
    assert untimed.opening_edge_s is None
    with pytest.raises(CounterOverrun, match="INPUT_FIFO_OVERFLOW_2"):
        device.read(0.1)
    device.disarm()


def test_after_a_failed_read_a_counter_is_not_read_across_the_gap() -> None:
    clock = ScriptClock()
    task = ScriptedTask(clock, [1, 2, 3, 4], edges(4), breaks_after=2)
    clock.sleep_s(1.0)
    counter = SampledCounter(task)
    assert counter.differences(10).tolist() == [1]
    task.breaks_after = None
    assert counter.rest().tolist() == []
    assert counter.fault is not None


def test_what_is_left_in_a_buffer_after_a_fault_is_read_in_pieces() -> None:
    clock = ScriptClock(time_s=1e9)
    counter = SampledCounter(ScriptedTask(clock, list(range(250_000)), [0.0] * 250_000))
    assert counter.rest().tolist() == [1] * 249_999


@pytest.mark.parametrize(
    ("code", "kind"), [(-50103, DeviceBusy), (-89136, DeviceRefused), (-200170, DriverUnavailable)]
)
def test_an_arming_that_fails_frees_what_it_had_and_may_be_tried_again(code: int, kind: type[KinopixError]) -> None:
    device, system, (photons, ticks), clock = bench([0, 4])
    system.tasks = [photons, NiFault("no", code), ScriptedTask(clock, [0, 4], edges(2)), ticks]
    with pytest.raises(kind):
        device.arm(run(1))
    assert photons.calls == ["close"]
    device.arm(run(1))
    assert device.read(1.0).counts.tolist() == [4]
    device.disarm()


def test_a_start_that_fails_closes_both_counters() -> None:
    device, _, (photons, ticks), _ = bench([0])
    ticks.fails["start"] = NiFault("reserved", -200022)
    with pytest.raises(DeviceBusy, match="RESOURCE_ALREADY_RESERVED"):
        device.arm(run(1))
    assert photons.calls == ["start", "close"]
    assert ticks.calls == ["start", "close"]


def test_what_fails_at_disarming_becomes_a_note_and_the_rest_is_still_done() -> None:
    device, _, (photons, ticks), _ = bench([0, 4])
    gone = NiFault("the board is gone", -201003)
    photons.fails = {"acquired": gone, "doubtful": gone, "stop": gone, "close": gone}
    device.arm(run(1))
    device.read(1.0)
    report = device.disarm()
    assert report.edges_seen is None
    assert len([note for note in report.notes if "the board is gone" in note]) == 3
    assert ticks.calls == ["start", "stop", "close"]


def test_a_backlog_in_the_hosts_buffer_is_noted() -> None:
    device, _, _, clock = bench([0] * 4000, settings=NiSettings(buffer_s=0.0001))
    device.arm(run(3999))
    clock.sleep_s(1.0)
    device.read(0.0)
    assert "40% of the host's buffer" in device.disarm().notes[-1]


# --- life cycle and settings -------------------------------------------------------------------------------------------


def test_the_life_cycle_is_kept() -> None:
    device, _, (photons, _), _ = bench([0])
    with device:
        with pytest.raises(WrongState, match="not armed"):
            device.read(1.0)
        assert device.disarm().bins_closed == 0
        device.arm(run(1))
        with pytest.raises(WrongState, match="disarm it first"):
            device.arm(run(1))
    assert photons.calls[-1] == "close"
    with pytest.raises(WrongState, match="closed"):
        device.arm(run(1))


def test_too_fast_a_run_is_refused_before_a_counter_is_reserved() -> None:
    device, system, _, _ = bench([0])
    with pytest.raises(PlanError, match="at most 100000"):
        device.arm(CounterRun(n_bins=1, period_s=5e-6))
    assert system.counts == []


def test_the_identity_names_board_head_and_versions() -> None:
    device, _, _, _ = bench([0])
    assert device.identity.model == "PCIe-6323 with H10682-210"
    assert device.identity.serial == "1A2B3C"
    assert device.identity.driver == "nidaqmx 1.7.0, NI-DAQmx 24.5.0"
    assert not device.identity.simulated


@pytest.mark.parametrize(
    ("board", "saw"),
    [
        (replace(X_SERIES, sample_clocked_counting=False), "cannot be sampled"),
        (replace(X_SERIES, counter_bits=24), "24-bit counters"),
    ],
)
def test_a_board_that_cannot_count_by_an_external_clock_is_refused_at_once(board: NiBoardFacts, saw: str) -> None:
    with pytest.raises(DeviceRefused, match=saw):
        ni_counter(NiSettings(), ScriptedNi([], board), ScriptClock())


def test_a_board_with_one_counter_is_refused_before_anything_moves_unless_edges_are_not_timed() -> None:
    """A USB-6002 has ctr0 alone."""
    one = replace(X_SERIES, product="USB-6002", counters=("ctr0",))
    with pytest.raises(InputError, match=r"ctr1 in bench.toml; expected counters of a USB-6002: ctr0"):
        ni_counter(NiSettings(), ScriptedNi([], one), ScriptClock())
    ni_counter(NiSettings(edge_counter=None), ScriptedNi([], one), ScriptClock())


@pytest.mark.parametrize(
    ("product", "width_s", "taken"),
    [
        ("PCIe-6323", 90e-9, True),
        ("PCIe-6323", 1e-6, True),
        ("USB-6218", 125e-9, True),
        ("USB-6218", 90e-9, False),
        ("PCI-6221", 5.12e-6, False),
        ("PCI-6602", 90e-9, True),
    ],
)
def test_a_sync_filter_is_one_that_the_family_has(product: str, width_s: float, *, taken: bool) -> None:
    """X series: 90 ns, 5.12 us, 2.56 ms and custom ones; M series 125 ns, 6.425 us, 2.55 ms; others are not known here."""
    settings, board = NiSettings(sync_filter_s=width_s), ScriptedNi([], replace(X_SERIES, product=product))
    if taken:
        ni_counter(settings, board, ScriptClock())
        return
    with pytest.raises(InputError, match=r"one of 1.25e-07, 6.425e-06, 0.00255 \(M series\)"):
        ni_counter(settings, board, ScriptClock())


@pytest.mark.parametrize(
    ("timebase_hz", "stated_s", "dead_time_s"), [(100e6, None, 40e-9), (80e6, None, 50e-9), (80e6, 1e-7, 1e-7)]
)
def test_the_counter_merges_pulses_within_four_periods_of_its_timebase_unless_it_was_measured(
    timebase_hz: float, stated_s: float | None, dead_time_s: float
) -> None:
    """660x manual: duplicate-count prevention wants a source of a quarter of the timebase at most."""
    board = ScriptedNi([], replace(X_SERIES, max_timebase_hz=timebase_hz))
    limits = ni_counter(NiSettings(counter_dead_time_s=stated_s), board, ScriptClock()).limits
    assert limits.dead_time_s == pytest.approx(dead_time_s)


@pytest.mark.parametrize(
    ("tasks", "names"),
    [
        ([NiFault("held", -50103)], "the photon task on Dev1/ctr0 (edge times: Dev1/ctr1)"),
        ([None, NiFault("held", -200022)], "the edge-time task on Dev1/ctr1 (photons: Dev1/ctr0)"),
    ],
)
def test_a_reserved_counter_is_named_with_both_tasks_and_the_way_out(tasks: list[NiFault | None], names: str) -> None:
    given = [ScriptedTask(ScriptClock(), [], []) if task is None else task for task in tasks]
    device = ni_counter(NiSettings(), ScriptedNi(list(given)), ScriptClock())
    with pytest.raises(DeviceBusy, match=re.escape(names)) as raised:
        device.arm(CounterRun(n_bins=3, period_s=50e-6))
    assert "name free ones by counter and edge_counter in bench.toml" in raised.value.remedy


def test_a_board_that_is_not_there_is_a_driver_unavailable() -> None:
    with pytest.raises(DriverUnavailable, match="INVALID_DEVICE_ID"):
        ni_counter(NiSettings(), ScriptedNi([], NiFault("", -200220)), ScriptClock())
    with pytest.raises(DeviceDisconnected, match="UNAVAILABLE"):
        ni_counter(NiSettings(), ScriptedNi([], NiFault("", rpc_code="UNAVAILABLE")), ScriptClock())


@pytest.mark.parametrize(
    ("keys", "why"),
    [
        ({"arm_terminal": "PFI9"}, "arm_terminal is the sync line"),
        ({"photon_terminal": "PFI9"}, "same line"),
        ({"edge_counter": "ctr0"}, "same counter"),
        ({"photon_filter_s": 1e-7}, "Extra inputs are not permitted"),
    ],
)
def test_settings_that_cannot_work_are_refused(keys: dict[str, object], why: str) -> None:
    with pytest.raises(ValidationError, match=why):
        NiSettings.model_validate(keys)


# --- differences -------------------------------------------------------------------------------------------------------


def test_the_fact_sheets_wrap_from_4294967295_to_3_is_4_counts() -> None:
    clock = ScriptClock(time_s=1.0)
    assert SampledCounter(ScriptedTask(clock, [4294967295, 3], [0.0, 0.0])).differences(2).tolist() == [4]


@given(
    start=st.integers(0, WRAP - 1),
    counts=st.lists(st.integers(0, WRAP - 1), max_size=30),
    pieces=st.lists(st.integers(1, 5), max_size=40),
)
def test_any_counts_come_back_from_their_wrapped_sums_in_pieces_of_any_size(
    start: int, counts: list[int], pieces: list[int]
) -> None:
    samples = [start]
    for count in counts:
        samples.append((samples[-1] + count) % WRAP)
    counter = SampledCounter(ScriptedTask(ScriptClock(time_s=1.0), samples, [0.0] * len(samples)))
    got = [d for n in pieces for d in counter.differences(n).tolist()] + counter.rest().tolist()
    assert got == counts
