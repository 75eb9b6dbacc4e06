"""Time on the bench."""

import pytest

from protocols import Clock
from sim_backends.bench import RealTimeClock, VirtualClock


def test_virtual_time_passes_at_once_when_somebody_waits() -> None:
    clock = VirtualClock()
    clock.sleep_s(3600.0)
    assert clock.now_s() == 3600.0


def test_virtual_time_never_goes_back() -> None:
    clock = VirtualClock()
    clock.advance_to(2.0)
    clock.advance_to(1.0)
    clock.sleep_s(-5.0)
    assert clock.now_s() == 2.0


def test_real_time_waits_on_the_host_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    host = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: host[0])

    def sleep(duration_s: float) -> None:
        host[0] += duration_s

    monkeypatch.setattr("time.sleep", sleep)
    clock = RealTimeClock()
    clock.advance_to(1.5)
    clock.sleep_s(0.25)
    clock.advance_to(0.5)
    assert clock.now_s() == pytest.approx(1.75)
    assert host[0] == pytest.approx(101.75)


@pytest.mark.parametrize("clock", [VirtualClock(), RealTimeClock()])
def test_both_are_clocks_as_the_protocol_says(clock: object) -> None:
    assert isinstance(clock, Clock)
