"""The driver on a scripted line: bytes sent, bytes answered, nothing left over."""

import numpy as np
import pytest

from drivers.h10682.counter import H10682Counter
from drivers.serial_counter.codec import line
from drivers.serial_counter.driver import open_serial_counter
from drivers.serial_counter.settings import SerialCounterSettings
from protocols import (
    BenchContext,
    CounterOverrun,
    CounterRun,
    DeviceDisconnected,
    DeviceRefused,
    DriverUnavailable,
    PlanError,
    ProtocolViolation,
)
from tests.drivers.serial_line.scripted import Clock, Line, Port

OPENS: tuple[Line, ...] = (
    (b"\n",),
    (line("stop"), line("stopped", 0)),
    (line("id"), line("id", "Lab", "Pico", "3", 1_000_000)),
)
ARM: Line = (line("arm", 3), line("armed", 3))
RUN = CounterRun(n_bins=3, period_s=0.001)


def counter_on(*lines: Line, opens: tuple[Line, ...] = OPENS) -> tuple[H10682Counter, Port]:
    port = Port([*opens, *lines])
    return open_serial_counter(SerialCounterSettings(), BenchContext(clock=Clock(), transport=port)), port


def test_opening_stops_what_was_armed_and_asks_who_is_there() -> None:
    """A bin that a program before has left on the line is passed over."""
    opens = (OPENS[0], (line("stop"), line(7, 1, 1), line("stopped", 9)), OPENS[2])
    counter, port = counter_on(opens=opens)
    assert (counter.identity.vendor, counter.identity.firmware) == ("Lab", "3")
    assert counter.identity.model == "Pico with H10682-210"
    assert counter.limits.edge_time_resolution_s == 1e-6
    assert counter.limits.dead_time_s == 35e-9
    assert counter.limits.max_unread_bins == 8192
    assert port.script == []


def test_bins_come_with_their_edges_and_the_report_tells_the_surplus() -> None:
    counter, port = counter_on(ARM, (line("stop"), line("stopped", 6)))
    counter.arm(RUN)
    port.say(line(0, 5, 1000) + line(1, 0, 1001) + line(2, 4_000_000_000, 999))
    block = counter.read(0.1)
    assert block.counts.dtype == np.uint32
    assert block.counts.tolist() == [5, 0, 4_000_000_000]
    assert block.opening_edge_s is not None
    np.testing.assert_allclose(block.opening_edge_s, [0.0, 0.001, 0.002001], rtol=0, atol=1e-12)
    assert block.closing_edge_s == pytest.approx(0.003, abs=1e-12)
    report = counter.disarm()
    assert (report.bins_closed, report.edges_seen, report.notes) == (3, 6, ())
    assert port.script == []


def test_pieces_of_lines_are_put_together() -> None:
    counter, port = counter_on(ARM)
    counter.arm(RUN)
    port.say(line(0, 5, 1000)[:4])
    assert len(counter.read(0.0)) == 0
    port.say(line(0, 5, 1000)[4:])
    assert counter.read(0.1).counts.tolist() == [5]


def test_a_damaged_line_is_a_lost_bin_and_those_before_it_come_first() -> None:
    counter, port = counter_on(ARM, (line("stop"), line("stopped", 4)))
    counter.arm(RUN)
    port.say(line(0, 5, 1000) + line(1, 6, 1000).replace(b"6", b"7", 1) + line(2, 7, 1000))
    assert counter.read(0.1).counts.tolist() == [5]
    with pytest.raises(CounterOverrun, match="bin 2 where bin 1 comes next, 1 damaged"):
        counter.read(0.1)
    notes = " ".join(counter.disarm().notes)
    assert "1 damaged lines" in notes
    assert "broke off" in notes


def test_an_overrun_of_the_counter_is_told_behind_the_good_bins() -> None:
    counter, port = counter_on(ARM)
    counter.arm(RUN)
    port.say(line(0, 5, 1000) + line("overrun", 1) + line(1, 5, 1000))
    assert counter.read(0.1).counts.tolist() == [5]
    with pytest.raises(CounterOverrun, match="memory at bin 1"):
        counter.read(0.1)


def test_a_port_that_fails_is_told_behind_the_good_bins_and_leaves_a_note() -> None:
    counter, port = counter_on(ARM)
    counter.arm(RUN)
    port.say(line(0, 5, 1000))
    assert counter.read(0.1).counts.tolist() == [5]
    port.broken = True
    with pytest.raises(DeviceDisconnected):
        counter.read(0.1)
    assert "surplus sync edges are unknown" in " ".join(counter.disarm().notes)


@pytest.mark.parametrize(
    ("answer", "says"), [(line("error", "armed already"), "armed already"), (line("armed", 2), "'2'")]
)
def test_a_counter_that_does_not_arm_says_so(answer: bytes, says: str) -> None:
    counter, _ = counter_on((line("arm", 3), answer))
    with pytest.raises(DeviceRefused, match=says):
        counter.arm(RUN)


def test_a_report_without_a_number_is_a_note() -> None:
    counter, _ = counter_on(ARM, (line("stop"), line("stopped", "many")))
    counter.arm(RUN)
    report = counter.disarm()
    assert report.edges_seen is None
    assert "does not tell" in " ".join(report.notes)


def test_a_faster_run_than_was_measured_is_refused_before_a_byte_is_sent() -> None:
    counter, port = counter_on()
    with pytest.raises(PlanError, match="at most 5000"):
        counter.arm(CounterRun(n_bins=3, period_s=1 / 5001))
    assert port.script == []


@pytest.mark.parametrize("who", [("Lab", "Pico", "3"), ("Lab", "Pico", "3", "fast"), ("Lab", "Pico", "3", "0")])
def test_an_id_without_the_rate_of_its_clock_is_a_violation(who: tuple[str, ...]) -> None:
    with pytest.raises(ProtocolViolation, match="rate of the clock"):
        counter_on(opens=(OPENS[0], OPENS[1], (line("id"), line("id", *who))))


def test_silence_at_opening_names_what_to_check() -> None:
    port = Port([(b"\n",), (line("stop"),)])
    with pytest.raises(DriverUnavailable, match="firmware is on the board"):
        open_serial_counter(SerialCounterSettings(), BenchContext(clock=Clock(), transport=port))
    assert port.closed
