"""The emulated counter, by the page on its protocol; and the same through a pseudo-terminal of this computer."""

import sys
from typing import Any

import numpy as np
import pytest

from protocols import BenchContext, InputError
from sim_backends.bench import OpticalBench, Projection, SceneSettings
from sim_backends.wire.serial_counter import CounterBox, SerialCounterEmulatorSettings
from sim_backends.wire.serial_counter.box import crc
from sim_backends.wire.serial_counter.plugin import open_box
from tests.sim_backends.wire.serial_host import Host

PHOTONS: dict[str, Any] = {"object": "letter-B", "noise": {"kind": "poisson", "peak_counts": 100.0, "seed": 1}}


def said(text: str) -> bytes:
    return f"{text}*{crc(text.encode()):02X}\n".encode()


def show(bench: OpticalBench, n: int, period_s: float = 5e-5) -> None:
    lit_and_dark = np.stack([np.full((768, 128), fill, np.uint8) for fill in (0xFF, 0x00)])
    order = np.arange(n) % 2
    bench.show(Projection(bench.clock.now_s() + period_s, period_s, lambda index: lit_and_dark[index], order))


def host(**settings: Any) -> tuple[Host, OpticalBench]:
    bench = OpticalBench(SceneSettings.model_validate(PHOTONS))
    box = CounterBox(SerialCounterEmulatorSettings.model_validate(settings), bench).box
    return Host(box, baud=box.baud), bench


def test_it_answers_as_the_page_says() -> None:
    there, _ = host()
    assert there.ask(said("id")) == said("id,Kinopix,emulated counter,1,125000000")
    assert there.ask(said("stop")) == said("stopped,0")
    assert there.ask(said("arm,2")[:-1] + b"\r\n") == said("armed,2")
    assert there.ask(said("arm,2")).startswith(b"error,")
    for wrong in ("arm,0", "arm,x", "arm", "go"):
        assert there.ask(said(wrong)).startswith(b"error,")
    for nothing in (b"id\n", b"id*00\n", b"\n", said("x" * 70)):
        assert there.ask(nothing) == b""


def test_two_bins_need_three_edges_and_the_rest_is_only_counted() -> None:
    """50 us are 6250 ticks of 8 ns; lit, dark, lit ..."""
    there, bench = host()
    there.ask(said("arm,2"))
    show(bench, 5)
    lines = there.rest(0.01).splitlines(keepends=True)
    assert len(lines) == 2
    (zero, bright, first), (one, dark, second) = (line.split(b"*")[0].split(b",") for line in lines)
    assert (zero, first, one, dark, second) == (b"0", b"6250", b"1", b"0", b"6250")
    assert int(bright) > 50
    assert there.ask(said("stop")) == said("stopped,5")
    assert there.ask(said("stop")) == said("stopped,0")


def test_what_came_before_arming_is_forgotten() -> None:
    there, bench = host()
    show(bench, 5)
    there.rest(0.01)
    assert there.ask(said("arm,2")) == said("armed,2")
    assert there.ask(said("stop")) == said("stopped,0")


def test_a_slow_line_fills_the_memory_and_says_so() -> None:
    """20 kHz make 20 bins a millisecond, a line of 115200 baud carries half a bin in that time."""
    there, bench = host(baud=115_200, memory_bytes=160)
    there.ask(said("arm,100"))
    show(bench, 101)
    lines = there.rest(1.0).splitlines()
    assert lines[-1].startswith(b"overrun,")
    lost = int(lines[-1].split(b",")[1].split(b"*")[0])
    assert len(lines) - 1 == lost
    assert 12 <= lost <= 14  # of 12 to 14 bytes each


def test_faults_strike_the_bin_that_they_name() -> None:
    for kind in ("lost-line", "corrupted-line"):
        there, bench = host(faults=[{"kind": kind, "bin": 1}])
        there.ask(said("arm,3"))
        show(bench, 4)
        lines = there.rest(0.01).splitlines()
        good = [line for line in lines if int(line[-2:], 16) == crc(line[:-3])]
        assert [line[:1] for line in good] == [b"0", b"2"]
        assert len(lines) == (2 if kind == "lost-line" else 3)
    there, bench = host(faults=[{"kind": "unplugged", "bin": 1}])
    there.ask(said("arm,3"))
    show(bench, 4)
    with pytest.raises(OSError, match="gone"):
        there.rest(0.01)
    assert host(faults=[{"kind": "mute", "nth": 1}])[0].ask(said("id")) == b""


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals")
def test_a_pseudo_terminal_is_a_port_of_the_system() -> None:
    bench = OpticalBench(SceneSettings.model_validate({**PHOTONS, "realtime": True}))
    port = open_box(SerialCounterEmulatorSettings(pty=True), BenchContext(clock=bench.clock, scene=bench))
    try:
        assert str(port.port).startswith("/dev/")
        port.timeout = 5.0
        port.write(said("arm,3"))
        assert port.read_until(b"\n") == said("armed,3")
        show(bench, 4, 0.001)
        lines = [port.read_until(b"\n") for _ in range(3)]
        assert [line[:1] for line in lines] == [b"0", b"1", b"2"]
        assert b",125000*" in lines[0]
    finally:
        port.close()
    port.close()


def test_a_pseudo_terminal_wants_real_time() -> None:
    bench = OpticalBench(SceneSettings.model_validate(PHOTONS))
    with pytest.raises(InputError, match="realtime"):
        open_box(SerialCounterEmulatorSettings(pty=True), BenchContext(clock=bench.clock, scene=bench))
