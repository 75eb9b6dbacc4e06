"""The counter on any board: which calls reach the board, and that leaving lets go of it whatever happens."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from drivers.h10682.counter import H10682Counter
from protocols import (
    CountBlock,
    CounterLimits,
    CounterReport,
    CounterRun,
    DeviceIdentity,
    DeviceRefused,
    PhotonCounter,
    PlanError,
    WrongState,
)

IDENTITY = DeviceIdentity(name="pmt", vendor="none", model="scripted board")
LIMITS = CounterLimits(max_sync_rate_hz=20e3, max_count_rate_hz=5e6, dead_time_s=20e-9)
RUN = CounterRun(n_bins=2, period_s=50e-6)


@dataclass
class Board:
    """A board that keeps the calls it gets, and fails where it is told to."""

    calls: list[str] = field(default_factory=list[str])
    refuses: bool = False
    breaks_at_the_end: bool = False

    def begin(self, run: CounterRun) -> "Board":
        self.calls.append(f"begin {run.n_bins}")
        if self.refuses:
            raise DeviceRefused("pmt", code="7", saw="no", expected="yes", remedy="ask again")
        return self

    def read(self, timeout_s: float) -> CountBlock:
        self.calls.append(f"read {timeout_s:g}")
        return CountBlock(0, np.array([3, 4], np.uint32))

    def finish(self) -> CounterReport:
        self.calls.append("finish")
        if self.breaks_at_the_end:
            raise ZeroDivisionError
        return CounterReport(bins_closed=2)

    def close(self) -> None:
        self.calls.append("close")


def counter_on(board: Board) -> H10682Counter:
    return H10682Counter(IDENTITY, LIMITS, board.begin, board.close)


def test_a_run_is_begun_read_finished_and_the_board_closed() -> None:
    board = Board()
    with counter_on(board) as counter:
        assert isinstance(counter, PhotonCounter)
        counter.arm(RUN)
        assert counter.read(0.5).counts.tolist() == [3, 4]
        assert counter.disarm().bins_closed == 2
    assert board.calls == ["begin 2", "read 0.5", "finish", "close"]


def test_calls_out_of_order_do_not_reach_the_board() -> None:
    board = Board()
    with counter_on(board) as counter:
        with pytest.raises(WrongState, match="read on a counter that is not armed"):
            counter.read(1.0)
        assert counter.disarm() == CounterReport(bins_closed=0)
        with pytest.raises(PlanError, match="25000 sync edges"):
            counter.arm(CounterRun(n_bins=2, period_s=40e-6))
        assert board.calls == []
        counter.arm(RUN)
        with pytest.raises(WrongState, match=r"arm on a counter that is armed.*disarm it first"):
            counter.arm(RUN)
    with pytest.raises(WrongState, match=r"closed.*open the bench again"):
        counter.arm(RUN)
    assert board.calls == ["begin 2", "finish", "close"]


def test_a_run_that_the_board_refused_leaves_the_counter_idle() -> None:
    board = Board(refuses=True)
    counter = counter_on(board)
    with pytest.raises(DeviceRefused):
        counter.arm(RUN)
    with pytest.raises(WrongState):
        counter.read(1.0)
    board.refuses = False
    counter.arm(RUN)
    assert counter.disarm().bins_closed == 2


def test_leaving_closes_the_board_though_disarming_fails() -> None:
    board = Board(breaks_at_the_end=True)

    def leave_armed() -> None:
        with counter_on(board) as counter:
            counter.arm(RUN)

    with pytest.raises(ZeroDivisionError):
        leave_armed()
    assert board.calls == ["begin 2", "finish", "close"]
