"""The reference firmware, compiled for this computer, keeps the protocol: our driver reads it, and its lines are the page's."""

import re
import shutil
import struct
import subprocess
from collections.abc import Generator
from pathlib import Path

import pytest

from drivers.serial_counter.codec import line
from drivers.serial_counter.driver import open_serial_counter
from drivers.serial_counter.settings import SerialCounterSettings
from protocols import BenchContext, CounterRun, MonotonicClock
from sim_backends.wire.process_port import ProcessPort

FIRMWARE = Path(__file__).parents[2] / "examples" / "firmware" / "rp2040-counter"
TICKS_HZ = 62_500_000
PATIENCE_S = 20.0

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")


class Board(ProcessPort):
    """The firmware as a process, which takes sync edges on its line too."""

    def __init__(self, program: Path) -> None:
        super().__init__([program])
        self.clock = MonotonicClock()

    def edges(self, *latched: tuple[int, int]) -> None:
        """Sync edges, each with the pulses and ticks since the start; the machines count down, modulo 2^32."""
        self.write(
            b"".join(b"\1" + struct.pack("<II", -pulses & 0xFFFFFFFF, -ticks & 0xFFFFFFFF) for pulses, ticks in latched)
        )

    def hears(self, lines: int) -> list[bytes]:
        """So many lines."""
        until_s, heard = self.clock.now_s() + PATIENCE_S, b""
        while heard.count(b"\n") < lines:
            assert self.clock.now_s() < until_s, heard
            self.clock.sleep_s(0.002)
            heard += self.read(4096)
        return heard.splitlines()


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("firmware") / "counter"
    flags = ["-std=c11", "-D_GNU_SOURCE", "-Wall", "-Wextra", "-Werror", "-I", str(FIRMWARE / "standin")]
    subprocess.run(["gcc", *flags, "-o", out, FIRMWARE / "counter.c", FIRMWARE / "standin" / "host.c"], check=True)
    return out


@pytest.fixture
def board(program: Path) -> Generator[Board]:
    board = Board(program)
    yield board
    board.close()


@needs_gcc
def test_our_driver_counts_with_the_firmware(board: Board) -> None:
    """The first edge opens bin 0, and what was counted before it is not data; the counters wrap at 2^32."""
    context = BenchContext(clock=board.clock, transport=board)
    with open_serial_counter(SerialCounterSettings(reply_margin_s=PATIENCE_S), context) as counter:
        assert counter.identity.model == "RP2040 counter with H10682-210"
        assert counter.limits.edge_time_resolution_s == 1 / TICKS_HZ
        board.edges((3, 100), (9, 900))  # before it is armed
        for _ in range(2):
            counter.arm(CounterRun(n_bins=3, n_expected=3, period_s=1e-3))
            board.edges((20, 1000), (57, 63_500), (57, 126_000), (2**32 + 1, 188_501), (2**32 + 9, 251_000))
            block = counter.read(PATIENCE_S)
            assert block.counts.tolist() == [37, 0, 2**32 + 1 - 57]
            assert block.opening_edge_s is not None
            assert block.opening_edge_s.tolist() == pytest.approx([0.0, 1e-3, 2e-3])
            assert block.closing_edge_s == pytest.approx(3e-3 + 1 / TICKS_HZ, abs=1e-10)
            report = counter.disarm()
            assert (report.bins_closed, report.edges_seen, report.notes) == (3, 5, ())


@needs_gcc
@pytest.mark.parametrize(
    ("said", "answers"),
    [
        (line("id"), [line("id", "Kinopix", "RP2040 counter", 1, TICKS_HZ)]),
        (line("stop"), [line("stopped", 0)]),
        (line("arm", 0), [line("error", "number of bins")]),
        (line("arm", "2x"), [line("error", "number of bins")]),
        (line("arm", 2) + line("arm", 2), [line("armed", 2), line("error", "armed already")]),
        (line("dance"), [line("error", "what")]),
        (
            b"id*72\nid\n\n" + b"x" * 200 + b"\n" + line("stop"),
            [line("stopped", 0)],
        ),  # damaged, without a sum, too long
    ],
)
def test_it_answers_as_the_page_of_the_protocol_says(board: Board, said: bytes, answers: list[bytes]) -> None:
    board.write(said)
    assert board.hears(len(answers)) == [answer.rstrip() for answer in answers]


def test_every_jump_of_a_program_of_the_pio_stays_inside_it() -> None:
    """Its place is added to a jump's target: one behind the last instruction becomes another instruction, and nothing counts."""
    text = (FIRMWARE / "standin" / "counter.pio.h").read_text()
    programs = {
        name: [int(word, 16) for word in words.split(", ")]
        for name, words in re.findall(r"(\w+)_program_instructions\[\] = \{(.*?)\}", text)
    }
    assert {name: len(words) for name, words in programs.items()} == {"pulses": 3, "ticks": 2, "sync": 4}
    for words in programs.values():
        assert all(
            word & 0x1F < len(words) for word in words if word < 0x2000
        )  # jumps have 0 in their highest three bits
    source = (FIRMWARE / "counter.pio").read_text()
    lines = [found for found in (re.sub(r";.*", "", each).strip() for each in source.splitlines()) if found]
    assert sum(not found.startswith(".") and not found.endswith(":") for found in lines) == 9
