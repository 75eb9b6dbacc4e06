"""Finds out, before a run of full packets, whether the board takes a sample at the start of a scan.

A scan that ends with the run cannot show by its length that all its bins are one too early. While no edge comes, it can: a
sample that is there nevertheless was taken at the start.
"""

from drivers.h10682.detector import NAME
from drivers.usb_ctr import codec
from drivers.usb_ctr.board import UsbCtrBoard
from drivers.usb_ctr.codec import Scan
from protocols import Clock, TimingFault

_WAIT_S = 2e-3
"""Far more than a sample needs to come over USB."""


def check_first_sample(board: UsbCtrBoard, scan: Scan, clock: Clock, *, sync_counter: int, first_samples: int) -> None:
    """Start a scan while the sync is still, and stop it again. Where edges come already, nothing can be told.

    Raises:
        TimingFault: the board does otherwise than ``first_samples`` says.
    """
    board.start_scan(scan)
    clock.sleep_s(_WAIT_S)
    seen = 2 if board.packet() else 1
    edges = codec.parse_count(board.ask(codec.ask_count(sync_counter)))
    board.stop_scan()
    if edges == 0 and seen != first_samples:
        raise TimingFault(
            device=NAME,
            saw=f"{seen - 1} samples before any sync edge",
            expected=f"{first_samples - 1}, as first_samples = {first_samples} says",
            remedy=f"set first_samples = {seen} under [counter] in bench.toml",
        )
