"""Which boards and settings the NI driver takes, and how it names what it refuses."""

import re
from dataclasses import replace

import pytest
from pydantic import ValidationError

from drivers.ni.driver import ni_counter
from drivers.ni.errors import NiFault
from drivers.ni.settings import NiSettings
from drivers.ni.tasks import NiBoardFacts
from protocols import CounterRun, DeviceBusy, DeviceDisconnected, DeviceRefused, DriverUnavailable, InputError
from tests.drivers.h10682.clock import ScriptClock
from tests.drivers.ni.script import X_SERIES, ScriptedNi, ScriptedTask


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
