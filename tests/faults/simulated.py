"""Faults of the simulated counter."""

from typing import Final

from protocols import CounterOverrun, DeviceDisconnected
from tests.faults.row import Row

ROWS: Final = (
    Row(
        fault="the counter overruns",
        keys="overrun_at_bin = 100",
        error=CounterOverrun,
        says=("pmt", "buffer full at bin 100"),
        kept=100,
        verdict="partial",
    ),
    Row(
        fault="the counter overruns in a longer run",
        keys="overrun_at_bin = 1100",
        frames=200,
        error=CounterOverrun,
        kept=1100,
        verdict="partial",
    ),
    Row(
        fault="the counter overruns at once",
        keys="overrun_at_bin = 0",
        error=CounterOverrun,
        kept=0,
    ),
    Row(
        fault="the counter is unplugged",
        keys="unplugged_at_bin = 100",
        error=DeviceDisconnected,
        says=("pmt", "after bin 100", "cable"),
        kept=100,
        verdict="partial",
    ),
    Row(
        fault="a block is lost on its way to the host",
        keys="lost_block_at_bin = 1500",
        frames=400,
        error=CounterOverrun,
        says=("begins at bin 2000", "bins 1000 to 1999 are missing"),
        kept=1000,
        verdict="partial",
    ),
    Row(
        fault="the last block is lost on its way to the host",
        keys="lost_block_at_bin = 1100",
        frames=200,
        error=CounterOverrun,
        says=("bins 1000 to 1199 are missing",),
        kept=1000,
        verdict="partial",
    ),
)
