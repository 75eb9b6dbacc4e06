"""The head's figures against the data-sheet rows of the fact sheet."""

import pytest

from drivers.h10682.detector import Head, counter_limits, linear_limit_hz


def test_ten_percent_loss_at_20_ns_is_the_data_sheets_5_million_a_second() -> None:
    assert linear_limit_hz(20e-9) == pytest.approx(5e6)


def test_a_50_ns_counter_brings_the_linear_limit_down_to_2_million() -> None:
    limits = counter_limits(Head(), counter_dead_time_s=50e-9, max_sync_rate_hz=1e5)
    assert limits.dead_time_s == 50e-9
    assert limits.max_count_rate_hz == pytest.approx(2e6)


def test_a_faster_counter_leaves_the_heads_own_dead_time() -> None:
    assert counter_limits(Head(), counter_dead_time_s=1e-9, max_sync_rate_hz=1e5).dead_time_s == 20e-9


def test_a_measured_system_dead_time_overrules_both() -> None:
    head = Head(system_dead_time_s=33e-9, dark_rate_hz=580)
    limits = counter_limits(head, counter_dead_time_s=50e-9, max_sync_rate_hz=1e5)
    assert limits.dead_time_s == 33e-9
    assert limits.dark_rate_hz == 580
