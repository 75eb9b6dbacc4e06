"""The port and the plug-ins."""

import hypothesis.strategies as st
import numpy as np
import pytest
import serial
from hypothesis import given

from protocols import BenchContext, InputError
from sim_backends.bench import OpticalBench, RealTimeClock, SceneSettings
from sim_backends.wire.zolix import (
    EmulatedPort,
    Mc600Settings,
    Sc300Settings,
    mc600_controller,
)
from sim_backends.wire.zolix.plugin import mc600 as mc600_plugin
from sim_backends.wire.zolix.plugin import sc300 as sc300_plugin
from tests.sim_backends.wire.zolix.host import mc600, sc300


def test_bytes_arrive_one_by_one_at_ten_bits_each() -> None:
    """19200 baud: 0.52 ms a byte. Position? and its answer of 20 bytes, 2 ms of thought between them."""
    host = mc600()
    host.port.write(b"Position? X\r")
    host.clock.advance_to(12 * 10 / 19_200 + 0.002)
    assert host.port.in_waiting == 0
    host.clock.sleep_s(5.1 * 10 / 19_200)
    assert host.port.in_waiting == 5
    assert host.port.read(5) == b"POSIT"
    host.port.timeout = 1.0
    assert host.port.read(16) == b"ION? X,0.000,OK\r"
    assert host.clock.now_s() == pytest.approx((12 + 21) * 10 / 19_200 + 0.002)


def test_the_exchange_takes_what_the_sheet_says() -> None:
    """5.2: ``?X`` and ``?X,128000`` are 13 bytes, 6.8 ms, 169 um at 25 mm/s."""
    host = sc300(turnaround_s=0.0, travel_mm=[-400.0, 400.0])
    host.port.write(b"+X,128000\r")
    host.line()
    before_s = host.clock.now_s()
    assert host.ask(b"?X\r") == b"?X,128000\r"
    assert host.clock.now_s() - before_s == pytest.approx(6.8e-3, abs=0.05e-3)


def test_a_timeout_lets_exactly_its_time_pass() -> None:
    """And gives what has come by then."""
    host = mc600()
    host.port.timeout = 0.25
    assert host.port.read(1) == b""
    assert host.clock.now_s() == pytest.approx(0.25)
    host.port.timeout = 0
    assert host.port.read(1) == b""
    host.port.timeout = None
    with pytest.raises(serial.SerialException, match="nothing is on its way"):
        host.port.read(1)


def test_the_port_behaves_as_pyserial_does() -> None:
    """Flush waits for the line, reset_input_buffer drops what has come, a closed port says so, a wrong speed is noise."""
    host = mc600()
    host.port.write(b"Hello\r")
    assert host.port.out_waiting == 6
    host.port.flush()
    assert host.clock.now_s() == pytest.approx(6 * 10 / 19_200)
    assert host.port.out_waiting == 0
    host.clock.sleep_s(1.0)
    host.port.reset_input_buffer()
    host.port.reset_output_buffer()
    assert host.port.in_waiting == 0
    host.port.baudrate = 9600
    host.port.write(b"Hello\r")
    host.clock.sleep_s(1.0)
    assert host.port.in_waiting == 0
    with pytest.raises(serial.SerialException, match="already open"):
        host.port.open()
    host.port.close()
    for use in (lambda: host.port.read(1), lambda: host.port.write(b"x")):
        with pytest.raises(serial.SerialException):
            use()


@given(cuts=st.lists(st.integers(1, 8), min_size=1, max_size=40))
def test_how_the_host_cuts_its_bytes_does_not_matter(cuts: list[int]) -> None:
    """The same commands in any pieces give the same bytes back, and the same position."""
    sent = b"Hello\rGoPosition X,O,R,P,1.25\rPosition? Y\rNonsense\r"
    host, pieces = mc600(), iter(cuts)
    left = sent
    while left:
        size = next(pieces, len(left))
        host.port.write(left[:size])
        left = left[size:]
    assert host.rest() == b"OK\rREADY\rPOSITION? Y,0.000,OK\rE01\rX 1.250,OK\r"


@given(noise=st.binary(max_size=600))
def test_no_bytes_break_a_box(noise: bytes) -> None:
    """After any noise, an end of line and a motion's time, both boxes answer as ever."""
    for host, asked, answer in ((mc600(), b"Hello\r", b"OK\r"), (sc300(), b"TY\r", b"SC300\r")):
        host.port.write(noise + b"\r")
        host.rest(1000.0)
        assert host.ask(asked) == answer


def test_a_real_time_port_sees_what_another_thread_sends() -> None:
    """A read on a clock that waits looks again before its timeout."""
    controller = mc600_controller(Mc600Settings(), RealTimeClock())
    port = EmulatedPort(controller, "emulated", baudrate=19_200, timeout=5.0)
    port.write(b"Hello\r")
    assert port.read(3) == b"OK\r"
    assert controller.clock.now_s() < 4.0


def test_the_mc600_plugin_carries_the_object_of_the_bench() -> None:
    """The bench is told where the carriage is whenever it begins to move otherwise; without a bench there is an error."""
    bench = Carried(SceneSettings())
    port = mc600_plugin.open(Mc600Settings(), BenchContext(clock=bench.clock, scene=bench))
    bench.check_carried(port, b"GoPosition X,O,R,P,2\r")
    with pytest.raises(InputError, match=r"\[scene\]"):
        mc600_plugin.open(Mc600Settings(), BenchContext())


def test_the_sc300_plugin_carries_the_object_of_the_bench() -> None:
    """As the MC600: 800 pulses are 2 mm."""
    bench = Carried(SceneSettings())
    port = sc300_plugin.open(Sc300Settings(), BenchContext(clock=bench.clock, scene=bench))
    bench.check_carried(port, b"+X,800\r")
    with pytest.raises(InputError, match=r"\[scene\]"):
        sc300_plugin.open(Sc300Settings(), BenchContext())


class Carried(OpticalBench):
    """An optical bench that tells where the object is carried."""

    def at_mm(self, clock_s: float) -> float:
        return float(self._carried[-1][1](np.array([clock_s]))[0])

    def check_carried(self, port: object, command: bytes) -> None:
        assert isinstance(port, EmulatedPort)
        assert (port.is_open, port.timeout, port.baudrate) == (True, 0.1, 19_200)
        assert self.at_mm(0.0) == 0.0
        port.write(command)
        assert 0.0 < self.at_mm(0.3) < 2.0
        assert self.at_mm(60.0) == pytest.approx(2.0)
