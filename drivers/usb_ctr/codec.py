"""What the bytes of a Measurement Computing USB-CTR04/08 mean. No I/O: intents in, requests out; answers in, values out.

All numbers are little-endian; every request is a vendor control transfer to the device (0x40 out, 0xC0 in). Fact sheet
h10682-daq, section 5.2, which two independent public sources of the protocol agree on but for two points: the debounce code that
means "off", and the status bit that means "scan done". Both are arguments here, never constants.
"""

import struct
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

VENDOR_ID = 0x09DB
PRODUCTS = {0x012E: "USB-CTR04", 0x0127: "USB-CTR08"}
SCAN_ENDPOINT = 0x86
BASE_CLOCK_HZ = 96_000_000
MAX_COUNT_RATE_HZ = 48_000_000
FIFO_WORDS = 8192
"""Samples of 16 bits that wait on the board (8 x 2 x 1024 bytes)."""

SCAN_LIST_BYTES = 33
FPGA_BLOCK_BYTES = 64
BLOCK_WORDS = 256
"""16-bit words of a full packet, the only size beside one sample whose last part a scan that completes is seen to send
(wjasper/Linux_Drivers #35). A packet of it may end inside a sample."""

_UNLOCK = 0xAD


class Command(IntEnum):
    """``bRequest`` of the requests that this driver uses."""

    COUNTER = 0x10
    COUNTER_PARAMETERS = 0x18
    SCAN_CONFIG = 0x20
    SCAN_START = 0x21
    SCAN_STOP = 0x22
    SCAN_CLEAR_FIFO = 0x23
    BULK_FLUSH = 0x24
    TIMER_CONTROL = 0x28
    TIMER_PARAMETERS = 0x2D
    STATUS = 0x40
    SERIAL = 0x48
    FPGA_CONFIG = 0x50
    FPGA_DATA = 0x51
    FPGA_VERSION = 0x52


@dataclass(frozen=True)
class Request:
    """One control transfer: ``reply_bytes`` above 0 asks, otherwise ``data`` is sent."""

    command: Command
    value: int = 0
    index: int = 0
    data: bytes = b""
    reply_bytes: int = 0


class BadAnswer(ValueError):
    """An answer whose length or content the protocol does not allow."""


# --- status and identity -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Status:
    """The 16 status bits, of which the driver reads those below."""

    bits: int

    @property
    def overrun(self) -> bool:
        """Bit 2: samples were lost on the board."""
        return bool(self.bits & 0x0004)

    @property
    def fpga_configured(self) -> bool:
        """Bit 8: the FPGA has its image."""
        return bool(self.bits & 0x0100)

    def scan_done(self, mask: int) -> bool:
        """Whether a scan has ended, by the bit that ``mask`` names: 0x40 by the maker's library, 0x20 by another driver."""
        return bool(self.bits & mask)


ASK_STATUS = Request(Command.STATUS, reply_bytes=2)
ASK_SERIAL = Request(Command.SERIAL, reply_bytes=8)
ASK_FPGA_VERSION = Request(Command.FPGA_VERSION, reply_bytes=2)


def parse_status(answer: bytes) -> Status:
    """Status from its two bytes.

    >>> parse_status(bytes.fromhex("0601")).overrun
    True
    """
    return Status(_u16(answer))


def parse_serial(answer: bytes) -> str:
    """Serial number from its eight ASCII bytes."""
    if len(answer) != 8 or not answer.isascii():
        raise BadAnswer(f"a serial number of {answer!r}; eight ASCII bytes expected")
    return answer.rstrip(b"\0 ").decode("ascii")


def parse_fpga_version(answer: bytes) -> str:
    """Version from binary-coded decimals.

    >>> parse_fpga_version(bytes.fromhex("0201"))
    '01.02'
    """
    version = _u16(answer)
    return f"{version >> 8:02x}.{version & 0xFF:02x}"


# --- FPGA --------------------------------------------------------------------------------------------------------------


def load_fpga(image: bytes) -> list[Request]:
    """Unlock, the image in blocks of 64 bytes, and the two zero bytes that the maker's library sends to this family.

    Afterwards status bit 8 must be set.
    """
    blocks = (image[at : at + FPGA_BLOCK_BYTES] for at in range(0, len(image), FPGA_BLOCK_BYTES))
    return [
        Request(Command.FPGA_CONFIG, data=bytes([_UNLOCK])),
        *(Request(Command.FPGA_DATA, data=block) for block in blocks),
        Request(Command.FPGA_DATA, data=bytes(2)),
    ]


# --- counters and timers -----------------------------------------------------------------------------------------------


def count_and_clear(counter: int, debounce_code: int, *, falling: bool = False) -> Request:
    """Totalise on one counter and clear it at each sample: bytes are mode, options, gate, output, debounce."""
    options = 0x01 | (0x10 if falling else 0)
    return Request(Command.COUNTER_PARAMETERS, index=counter, data=bytes([0, options, 0, 0, debounce_code]))


def count_on(counter: int, debounce_code: int) -> Request:
    """Totalise on one counter without clearing it at samples, only at the start of a scan."""
    return Request(Command.COUNTER_PARAMETERS, index=counter, data=bytes([0, 0, 0, 0, debounce_code]))


def ask_count(counter: int) -> Request:
    """Ask for what one counter holds, 64 bits."""
    return Request(Command.COUNTER, index=counter, reply_bytes=8)


def parse_count(answer: bytes) -> int:
    """Count from its eight bytes.

    >>> parse_count(bytes([3, 1, 0, 0, 0, 0, 0, 0]))
    259
    """
    return int.from_bytes(answer, "little")


def timer_parameters(timer: int, period: int) -> Request:
    """A train of the shortest pulses, 1/96 MHz wide, at 96 MHz / (period + 1), without end and without delay."""
    return Request(Command.TIMER_PARAMETERS, index=timer, data=struct.pack("<IIII", period, 0, 0, 0))


def timer_control(timer: int, *, on: bool) -> Request:
    """Switch a timer output."""
    return Request(Command.TIMER_CONTROL, value=int(on), index=timer)


# --- scans -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scan:
    """Which counters one sample holds, and how wide each is."""

    counters: tuple[int, ...]
    words: int = 1
    """16-bit words of each counter: 1, or 2 where a bin may hold more than 65,535 counts."""

    @property
    def words_per_scan(self) -> int:
        """16-bit words of one sample of all counters: also the packet size of single-packet mode."""
        return self.words * len(self.counters)

    @property
    def bytes_per_scan(self) -> int:
        """Bytes of one sample of all counters."""
        return 2 * self.words_per_scan


def scan_config(scan: Scan) -> Request:
    """The scan list, 33 bytes: bits 2:0 counter, bits 4:3 which 16 bits of it. wIndex names the last element."""
    elements = [counter | bank << 3 for counter in scan.counters for bank in range(scan.words)]
    return Request(Command.SCAN_CONFIG, index=len(elements) - 1, data=bytes(elements).ljust(SCAN_LIST_BYTES, b"\0"))


def scan_start(scan: Scan, *, samples: int = 0, pacer_period: int = 0, packet_words: int = 0) -> Request:
    """Start a scan, which clears the counters first.

    Args:
        scan: as configured.
        samples: samples in all; 0 goes on until it is stopped.
        packet_words: 16-bit words of a packet; 0 sends each sample in a packet of its own.
        pacer_period: 0 samples on the external clock input, otherwise at 96 MHz / (pacer_period + 1).
    """
    options = 0
    data = struct.pack("<IIIBB", samples, 0, pacer_period, (packet_words or scan.words_per_scan) - 1, options)
    return Request(Command.SCAN_START, data=data)


STOP_SCAN = Request(Command.SCAN_STOP)
CLEAR_FIFO = Request(Command.SCAN_CLEAR_FIFO)


def flush_bulk(times: int = 5) -> Request:
    """Flush the bulk pipe."""
    return Request(Command.BULK_FLUSH, value=times)


def decode(scan: Scan, data: bytes) -> tuple[NDArray[np.uint32], bytes]:
    """Samples from scan data, and the bytes after the last whole one.

    Returns:
        ``(n, counters)`` counts in scan-list order, and what is left over of a sample that goes on in the next packet.
    """
    whole = len(data) - len(data) % scan.bytes_per_scan
    words = np.frombuffer(data[:whole], dtype="<u2").astype(np.uint32).reshape(-1, len(scan.counters), scan.words)
    weights = (np.uint32(1) << (np.arange(scan.words, dtype=np.uint32) * np.uint32(16))).astype(np.uint32)
    return (words * weights).sum(axis=-1, dtype=np.uint32), data[whole:]


def _u16(answer: bytes) -> int:
    if len(answer) != 2:
        raise BadAnswer(f"{len(answer)} bytes ({answer.hex(' ')}); 2 expected")
    return int.from_bytes(answer, "little")
