"""A suite that nothing can fail proves nothing: counters with one mistake each, and the test that finds it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from protocols import CountBlock, CounterRun, DeviceTimeout
from protocols.conformance import counter as suite
from sim_backends.bench import OpticalBench
from sim_backends.devices.counter import CounterSettings, SimulatedCounter
from tests.conformance.biting import FOUND, call
from tests.conformance.rigs import PHOTONS, counter_rig


class OneBinOff(SimulatedCounter):
    """Takes what was counted before the first edge for bin 0."""

    def read(self, timeout_s: float) -> CountBlock:
        block = super().read(timeout_s)
        return replace(block, counts=np.roll(block.counts, 1))


class HoldsTheLastBinsBack(SimulatedCounter):
    def read(self, timeout_s: float) -> CountBlock:
        self._bench.clock.sleep_s(timeout_s)
        return super().read(0.0)


class LosesABin(SimulatedCounter):
    def arm(self, run: CounterRun) -> None:
        super().arm(run.model_copy(update={"n_bins": max(1, run.n_bins - 1)}))


class CountsOn(SimulatedCounter):
    """Numbers its bins from when it was opened."""

    _before = 0

    def read(self, timeout_s: float) -> CountBlock:
        block = super().read(timeout_s)
        self._before += len(block)
        return replace(block, first_bin=self._before - len(block))


class NumbersEmptyBlocksAnew(SimulatedCounter):
    """Says that nothing came after bin 0, when nothing came after the last bin."""

    def read(self, timeout_s: float) -> CountBlock:
        block = super().read(timeout_s)
        return block if len(block) else replace(block, first_bin=0)


class TellsTheTimeOfDay(SimulatedCounter):
    def read(self, timeout_s: float) -> CountBlock:
        block = super().read(timeout_s)
        if block.opening_edge_s is None or block.closing_edge_s is None:
            return block
        hour_s = 3600.0
        return replace(
            block, opening_edge_s=block.opening_edge_s + hour_s, closing_edge_s=block.closing_edge_s + hour_s
        )


class ArmsTwice(SimulatedCounter):
    def arm(self, run: CounterRun) -> None:
        self.disarm()
        super().arm(run)


class TimesOutLoudly(SimulatedCounter):
    def read(self, timeout_s: float) -> CountBlock:
        block = super().read(timeout_s)
        if not len(block):
            raise DeviceTimeout("pmt", awaited="an edge", waited_s=timeout_s, progress="none", remedy="wait")
        return block


class GivesFloats(SimulatedCounter):
    def read(self, timeout_s: float) -> CountBlock:
        block = super().read(timeout_s)
        return replace(block, counts=block.counts.astype(np.float32))  # type: ignore[arg-type]  # the mistake


@pytest.mark.parametrize(
    ("broken", "test"),
    [
        (OneBinOff, suite.test_n_plus_1_edges_give_n_bins_each_once),
        (LosesABin, suite.test_n_plus_1_edges_give_n_bins_each_once),
        (HoldsTheLastBinsBack, suite.test_the_last_bins_are_not_held_back),
        (HoldsTheLastBinsBack, suite.test_a_read_with_bins_in_hand_does_not_wait_out_its_time),
        (HoldsTheLastBinsBack, suite.test_a_read_after_the_last_bin_is_empty_at_once),
        (NumbersEmptyBlocksAnew, suite.test_a_read_after_the_last_bin_is_empty_at_once),
        (CountsOn, suite.test_each_run_is_counted_afresh),
        (TellsTheTimeOfDay, suite.test_edge_times_count_from_the_first_edge_and_rise),
        (ArmsTwice, suite.test_arming_twice_is_refused_and_disturbs_nothing),
        (TimesOutLoudly, suite.test_without_edges_a_read_gives_nothing_after_its_time_is_up),
        (GivesFloats, suite.test_counts_are_whole_photons_or_simulated_light),
    ],
)
def test_a_broken_counter_is_found(broken: type[SimulatedCounter], test: Callable[..., None]) -> None:
    _try(SimulatedCounter, test)
    with pytest.raises(FOUND):
        _try(broken, test)


def _try(kind: type[SimulatedCounter], test: Callable[..., None]) -> None:
    bench = OpticalBench(PHOTONS)
    rig = counter_rig(bench, lambda: kind(CounterSettings(), bench))
    with rig.open() as counter:
        call(test, rig=rig, counter=counter, n_bins=13, closed=12)
