"""Wiring and doubts as bench.toml states them; figures of the board's own documents."""

import pytest
from pydantic import ValidationError

from drivers.usb_ctr.settings import EdgeTimer, UsbCtrSettings


def test_the_counter_input_is_as_slow_as_its_highest_rate() -> None:
    """48 MHz: 20.8 ns, longer than the 20 ns of the head."""
    assert UsbCtrSettings().counter_dead_time_s == pytest.approx(20.833e-9, rel=1e-4)


def test_the_defaults_are_the_likelier_of_what_sources_say() -> None:
    """16 is "off" in the maker's library; 0x40 belongs to its output scans, so 0x20 is left for scans of counters."""
    settings = UsbCtrSettings()
    assert (settings.debounce_code, settings.scan_done_mask, settings.first_samples) == (16, 0x20, 1)
    assert (settings.counter, settings.photon_edge, settings.max_sync_rate_hz) == (0, "rising", 100e3)
    assert settings.edge_timer is None
    assert settings.sync_counter is None


@pytest.mark.parametrize(("period_ticks", "tick_ns"), [(9, 104.17), (95, 1000.0)])
def test_a_timer_ticks_once_in_its_period_and_one_of_the_base_clock(period_ticks: int, tick_ns: float) -> None:
    """96 MHz / (9 + 1) is 9.6 MHz."""
    timer = EdgeTimer(timer=0, counter=1, period_ticks=period_ticks)
    assert timer.tick_s * 1e9 == pytest.approx(tick_ns, rel=1e-4)


@pytest.mark.parametrize(
    "wrong",
    [
        {"debounce_code": 17},
        {"debounce_code": -1},
        {"first_samples": 3},
        {"first_samples": -1},
        {"counter": 8},
        {"scan_done_mask": 1},
    ],
)
def test_what_the_board_does_not_have_is_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(ValidationError):
        UsbCtrSettings.model_validate(wrong)
