"""Settles, on the board at hand, the two points on which the public sources of its protocol disagree.

Wire a timer output to the photon input. The timer gives 9.6 MHz of the shortest pulses (10.4 ns, much like the head's), the
board paces itself at 10 kHz: 960 counts a sample. A debounce code that is not "off" swallows them all. The scan ends after a
set number of samples, which shows the bit that means "scan done".
"""

from dataclasses import dataclass

from drivers.h10682.detector import NAME
from drivers.usb_ctr import codec
from drivers.usb_ctr.board import UsbCtrBoard
from drivers.usb_ctr.codec import BASE_CLOCK_HZ, Scan
from protocols import Clock, DeviceTimeout

CODES = (16, 0)
SCAN_DONE_MASKS = (0x40, 0x20)
EXPECTED_COUNTS = 960

_TIMER_PERIOD = 9
_PACER_PERIOD = 9599
_SAMPLES = 100
_SCAN_S = _SAMPLES * (_PACER_PERIOD + 1) / BASE_CLOCK_HZ


@dataclass(frozen=True)
class SelfTest:
    """What the loopback showed."""

    mean_counts: dict[int, float]
    """Counts a sample, by debounce code; ``EXPECTED_COUNTS`` where nothing is swallowed."""

    scan_done_masks: tuple[int, ...]
    """Status bits that were clear during a scan and set after it."""

    @property
    def codes_that_count(self) -> tuple[int, ...]:
        """Debounce codes with which no pulse was lost. None: look at the wire, or the pulses are too short for the board."""
        return tuple(code for code, counts in self.mean_counts.items() if abs(counts - EXPECTED_COUNTS) <= 1)


def self_test(board: UsbCtrBoard, clock: Clock, *, counter: int, timer: int) -> SelfTest:
    """Run the loopback with each disputed debounce code; board stopped and timer off afterwards."""
    scan = Scan((counter,))
    mean_counts: dict[int, float] = {}
    masks: tuple[int, ...] = ()
    try:
        board.ask(codec.timer_parameters(timer, _TIMER_PERIOD))
        board.ask(codec.timer_control(timer, on=True))
        for code in CODES:
            board.ask(codec.count_and_clear(counter, code))
            board.start_scan(scan, samples=_SAMPLES, pacer_period=_PACER_PERIOD)
            during = board.status()
            data = _collect(board, clock, scan)
            after = board.status()
            masks = tuple(mask for mask in SCAN_DONE_MASKS if after.bits & ~during.bits & mask)
            counts, _ = codec.decode(scan, data)
            mean_counts[code] = float(counts[1:, 0].mean())
    finally:
        board.stop_scan()
        board.ask(codec.timer_control(timer, on=False))
    return SelfTest(mean_counts, masks)


def _collect(board: UsbCtrBoard, clock: Clock, scan: Scan) -> bytes:
    data = bytearray()
    for _ in range(3):
        clock.sleep_s(_SCAN_S)
        while packet := board.packet():
            data += packet
            if len(data) >= _SAMPLES * scan.bytes_per_scan:
                return bytes(data)
    raise DeviceTimeout(
        NAME,
        awaited=f"{_SAMPLES} samples at 10 kHz",
        waited_s=3 * _SCAN_S,
        progress=f"{len(data) // scan.bytes_per_scan} samples",
        remedy="unplug the board, plug it in and try again",
    )
