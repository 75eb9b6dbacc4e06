"""H10682 on a Measurement Computing USB-CTR04 or USB-CTR08, by the board's own USB protocol.

The modulator's sync on CLKI samples a counter that is cleared by each sample, so that every sample is the count of one bin
and nothing is subtracted. ``packets`` says how the samples come. Without an edge timer there are no edge times: the board has
no timebase that a counter could count. Fact sheet h10682-daq, section 5.
"""

from typing import Final

from drivers.h10682.counter import H10682Counter
from drivers.h10682.detector import NAME, counter_limits
from drivers.usb_ctr.board import UsbCtrBoard
from drivers.usb_ctr.codec import FIFO_WORDS
from drivers.usb_ctr.scan import UsbCtrScan
from drivers.usb_ctr.settings import UsbCtrSettings
from protocols import Clock, CounterLimits, DeviceIdentity, InputError

_MOST_WORDS: Final = 2  # of a count: of one that may pass 65,535


def usb_ctr_counter(
    settings: UsbCtrSettings, board: UsbCtrBoard, clock: Clock, *, simulated: bool = False
) -> H10682Counter:
    """Take over an open board whose FPGA is loaded, and give the counter on it; leaving the counter closes the board.

    Raises:
        InputError: the settings name a counter that the board does not have.
    """
    _check_counters(settings, board)
    identity = DeviceIdentity(
        name=NAME,
        vendor="Measurement Computing",
        model=f"{board.model} with {settings.head.model}",
        serial=board.serial,
        firmware=f"FPGA {board.fpga_version()}",
        driver="libusb",
        simulated=simulated,
    )
    return H10682Counter(identity, _limits(settings), lambda run: UsbCtrScan(run, settings, board, clock), board.close)


def _limits(settings: UsbCtrSettings) -> CounterLimits:
    return counter_limits(
        settings.head,
        counter_dead_time_s=settings.counter_dead_time_s,
        max_sync_rate_hz=settings.max_sync_rate_hz,
        edge_time_resolution_s=settings.edge_timer.tick_s if settings.edge_timer else None,
        max_unread_bins=FIFO_WORDS // (_MOST_WORDS * (2 if settings.edge_timer else 1)),
    )


def _check_counters(settings: UsbCtrSettings, board: UsbCtrBoard) -> None:
    timer = settings.edge_timer
    wired = (settings.counter, settings.sync_counter, None if timer is None else timer.counter)
    counters = [counter for counter in wired if counter is not None]
    if max(counters) >= board.n_counters or len(set(counters)) < len(counters):
        raise InputError(
            device=NAME,
            saw=f"counters {counters}",
            expected=f"different counters from 0 to {board.n_counters - 1} on a {board.model}",
            remedy="correct counter, sync_counter and edge_timer in bench.toml",
        )
