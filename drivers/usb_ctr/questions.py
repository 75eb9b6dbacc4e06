"""What a bench with a counter board has to answer."""

from typing import Final

from drivers.h10682.questions import HEAD_QUESTIONS
from drivers.usb_ctr.board import open_loaded_board
from drivers.usb_ctr.self_test import EXPECTED_COUNTS, self_test
from drivers.usb_ctr.settings import UsbCtrSettings
from protocols import Answer, BenchContext, BenchQuestion

_TIMER: Final = 0


def loopback(settings: UsbCtrSettings, context: BenchContext) -> Answer:
    """The self-test with timer 0, which must be wired to the photon input; without that wire it tells the status bit alone."""
    board = open_loaded_board(settings, context)
    try:
        status, version = board.status().bits, board.fpga_version()
        found = self_test(board, context.clock, counter=settings.counter, timer=_TIMER)
    finally:
        board.close()
    means = ", ".join(f"{mean:.1f} with code {code}" for code, mean in found.mean_counts.items())
    masks = " and ".join(f"{mask:#04x}" for mask in found.scan_done_masks) or "none"
    wired = any(found.mean_counts.values())
    doubts: list[str] = []
    if not wired:
        doubts.append(
            f"no counts: wire TMR{_TIMER} to CTR{settings.counter} to learn the debounce code, and run this again"
        )
    elif settings.debounce_code not in found.codes_that_count:
        doubts.append(f"debounce_code = {settings.debounce_code} loses pulses: see codes_that_count")
    if settings.scan_done_mask not in found.scan_done_masks:
        doubts.append(f"scan_done_mask = {settings.scan_done_mask:#04x} is not set at the end of a scan")
    return Answer(
        said=f"of {EXPECTED_COUNTS} pulses a sample were counted {means}; status bits after a scan: {masks}; FPGA {version}",
        figures={
            "codes_that_count": tuple(float(code) for code in found.codes_that_count),
            "scan_done_masks": masks,
            "status": f"{status:#06x}",
            "fpga": version,
        },
        doubts=tuple(doubts),
    )


QUESTIONS: Final[tuple[BenchQuestion[UsbCtrSettings], ...]] = (
    BenchQuestion(
        'Debounce code for "off": 16 by the maker\'s library, 0 by another driver? (`debounce_code = 16`.)',
        ask=loopback,
    ),
    BenchQuestion(
        'Status bit of "scan done": 0x20, or 0x40, which belongs to output scans? (`scan_done_mask = 0x20`.)',
        ask=loopback,
    ),
    BenchQuestion(
        "Does the board sample at the start of a scan? (`first_samples = 1`: it does not.)", measured="order"
    ),
    BenchQuestion(
        "Are two 16-bit banks of a counter read together? (Used only for bins that could pass 65,535 counts.)",
        by_hand="pictures of 10 ms in bright light: counts must not jump by 65,536",
    ),
    BenchQuestion("Does the computer take 20,000 packets a second? (Check 11.)", measured="pulses"),
    BenchQuestion(
        "With `sync_counter`: does a complete scan send its last packet of less than 256 words? (Taken: it does.)",
        measured="pulses",
    ),
    *HEAD_QUESTIONS,
)
"""In the order of the how-to."""
