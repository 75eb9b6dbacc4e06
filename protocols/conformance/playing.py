"""Runs of a modulator as the tests want them."""

import pytest

from protocols.conformance.patterns import run_s, sequence_for, timing_for
from protocols.conformance.rigs import ModulatorRig
from protocols.modulator import ModulatorTiming, PatternModulator
from protocols.values import Floats

N = 20
"""Pictures in most runs, without the guard."""


def load(modulator: PatternModulator, n_patterns: int = N) -> ModulatorTiming:
    return modulator.load(sequence_for(modulator.limits, n_patterns), timing_for(modulator.limits))


def play(modulator: PatternModulator, n_patterns: int = N) -> None:
    modulator.start()
    modulator.wait(long_s(modulator, n_patterns))
    assert not modulator.running


def long_s(modulator: PatternModulator, n_patterns: int = N) -> float:
    return 2 * run_s(sequence_for(modulator.limits, n_patterns), timing_for(modulator.limits)) + 1.0


def edges(rig: ModulatorRig) -> Floats:
    if rig.sync_edges is None:
        pytest.skip("the rig has no sync_edges: nobody looks at the sync line")
    return rig.sync_edges()
