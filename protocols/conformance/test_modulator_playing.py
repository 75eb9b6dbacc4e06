"""Runs of a ``PatternModulator``: started, shown picture by picture, and waited for."""

import pytest

from protocols.conformance.modulator_fixtures import *  # noqa: F403
from protocols.conformance.patterns import run_s, sequence_for, timing_for
from protocols.conformance.playing import N, edges, load, long_s, play
from protocols.conformance.rigs import ModulatorRig
from protocols.conformance.support import assert_speaks
from protocols.errors import DeviceTimeout, WrongState
from protocols.modulator import PatternModulator

# Playing


def test_starting_without_a_sequence_is_refused(modulator: PatternModulator) -> None:
    with pytest.raises(WrongState) as refused:
        modulator.start()
    assert_speaks(refused.value, modulator.identity.name)
    assert not modulator.running


def test_a_start_returns_at_once_and_the_device_runs_until_the_wait_is_over(
    rig: ModulatorRig, modulator: PatternModulator
) -> None:
    timing = load(modulator)
    whole_s = run_s(sequence_for(modulator.limits, N), timing)
    assert not modulator.running
    before_s = rig.clock.now_s()
    modulator.start()
    assert rig.clock.now_s() - before_s < 0.5 * whole_s
    assert bool(modulator.running)
    modulator.wait(long_s(modulator))
    took_s = rig.clock.now_s() - before_s
    assert 0.98 * whole_s <= took_s <= 1.1 * whole_s + 0.1
    assert not modulator.running


def test_starting_twice_is_refused_and_disturbs_nothing(rig: ModulatorRig, modulator: PatternModulator) -> None:
    load(modulator)
    modulator.start()
    with pytest.raises(WrongState) as refused:
        modulator.start()
    assert_speaks(refused.value, modulator.identity.name)
    modulator.wait(long_s(modulator))
    assert len(edges(rig)) == N + 1


@pytest.mark.parametrize("n_patterns", [1, 2, 7, N])
def test_n_patterns_and_the_guard_give_n_plus_1_edges(
    rig: ModulatorRig, modulator: PatternModulator, n_patterns: int
) -> None:
    load(modulator, n_patterns)
    play(modulator, n_patterns)
    assert len(edges(rig)) == n_patterns + 1


def test_a_plane_that_is_stored_once_may_be_played_often(rig: ModulatorRig, modulator: PatternModulator) -> None:
    modulator.load(sequence_for(modulator.limits, N, unique=3), timing_for(modulator.limits))
    play(modulator)
    assert len(edges(rig)) == N + 1


def test_a_second_start_replays(rig: ModulatorRig, modulator: PatternModulator) -> None:
    load(modulator)
    for _ in range(3):
        play(modulator)
        assert len(edges(rig)) == N + 1


def test_a_new_sequence_takes_the_place_of_the_old(rig: ModulatorRig, modulator: PatternModulator) -> None:
    for n_patterns in (N, 3, 9):
        load(modulator, n_patterns)
        play(modulator, n_patterns)
        assert len(edges(rig)) == n_patterns + 1


# Waiting


def test_waiting_for_what_never_started_is_refused(modulator: PatternModulator) -> None:
    with pytest.raises(WrongState):
        modulator.wait(1.0)
    load(modulator)
    with pytest.raises(WrongState) as refused:
        modulator.wait(1.0)
    assert_speaks(refused.value, modulator.identity.name)


def test_a_wait_that_is_too_short_says_how_far_the_run_has_come_and_the_run_goes_on(
    rig: ModulatorRig, modulator: PatternModulator
) -> None:
    timing = load(modulator)
    whole_s = run_s(sequence_for(modulator.limits, N), timing)
    modulator.start()
    told: list[str] = []
    for _ in range(2):
        before_s = rig.clock.now_s()
        with pytest.raises(DeviceTimeout) as late:
            modulator.wait(0.3 * whole_s)
        assert rig.clock.now_s() - before_s == pytest.approx(0.3 * whole_s, rel=0.1, abs=0.02)
        assert_speaks(late.value, modulator.identity.name)
        told.append(late.value.saw)
    assert told[0] != told[1], "both say the same, though the run has come further"
    modulator.wait(long_s(modulator))
    assert len(edges(rig)) == N + 1


def test_a_wait_after_the_end_returns_at_once(rig: ModulatorRig, modulator: PatternModulator) -> None:
    timing = load(modulator)
    play(modulator)
    before_s = rig.clock.now_s()
    modulator.wait(long_s(modulator))
    assert rig.clock.now_s() - before_s < run_s(sequence_for(modulator.limits, N), timing) / 2
