"""The NI driver on scripted counters: cumulative samples in, bins and edge times out, and nothing good lost."""

import numpy as np
import pytest

from drivers.h10682.counter import H10682Counter
from drivers.ni.driver import ni_counter
from drivers.ni.errors import MEANINGS, NiFault
from drivers.ni.settings import NiSettings
from protocols import (
    CounterOverrun,
    CounterRun,
    DeviceBusy,
    DeviceRefused,
    DriverUnavailable,
    KinopixError,
    PhotonCounter,
    PlanError,
    TimingFault,
    WrongState,
)
from tests.drivers.h10682.clock import ScriptClock
from tests.drivers.ni.script import ScriptedNi, ScriptedTask

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


# --- life cycle --------------------------------------------------------------------------------------------------------


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
