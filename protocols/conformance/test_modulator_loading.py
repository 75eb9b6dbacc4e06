"""What a ``PatternModulator`` says of itself, and what it takes and refuses to load."""

from collections.abc import Callable

import numpy as np
import pytest

from protocols.conformance.modulator_fixtures import *  # noqa: F403
from protocols.conformance.patterns import sequence_for, steps, timing_for
from protocols.conformance.playing import N, edges, load, long_s, play
from protocols.conformance.rigs import ModulatorRig
from protocols.conformance.support import assert_speaks
from protocols.errors import DeviceBusy, InputError, PatternMemoryFull, PictureTimeTooShort, PlanError, WrongState
from protocols.modulator import ModulatorTiming, PatternModulator

# What it is


def test_it_satisfies_the_protocol(modulator: PatternModulator) -> None:
    assert isinstance(modulator, PatternModulator)


def test_it_says_who_it_is(modulator: PatternModulator) -> None:
    identity = modulator.identity
    assert all(part.strip() for part in (identity.name, identity.vendor, identity.model, identity.driver)), identity
    assert modulator.identity == identity


def test_its_limits_can_be_true(modulator: PatternModulator) -> None:
    limits = modulator.limits
    assert limits.columns % 8 == 0, "packed planes have whole bytes a row"
    assert limits.shortest_picture_time_us < limits.longest_picture_time_us
    assert limits.unique_patterns >= 2, "one picture and its dark guard"
    assert limits.play_order_entries >= 2, "one picture and its dark guard"


def test_entering_gives_the_device_itself(rig: ModulatorRig) -> None:
    modulator = rig.open()
    with modulator as entered:
        assert entered is modulator


# Loading


def test_the_timing_that_is_kept_is_read_back(rig: ModulatorRig, modulator: PatternModulator) -> None:
    asked, kept = timing_for(modulator.limits), load(modulator)
    assert kept.picture_time_us == pytest.approx(asked.picture_time_us, rel=0.01)
    assert kept.sync_width_us < kept.picture_time_us
    play(modulator)
    gaps_s = np.diff(edges(rig))
    assert gaps_s == pytest.approx(kept.picture_time_us * 1e-6, rel=1e-3)


def test_the_shortest_picture_time_is_played(modulator: PatternModulator) -> None:
    shortest_us = modulator.limits.shortest_picture_time_us
    kept = modulator.load(
        sequence_for(modulator.limits, N),
        timing_for(modulator.limits).model_copy(update={"picture_time_us": shortest_us}),
    )
    assert kept.picture_time_us == shortest_us
    play(modulator)


def test_each_unique_pattern_is_told_while_it_is_stored(modulator: PatternModulator) -> None:
    told: list[tuple[int, int]] = []
    modulator.load(
        sequence_for(modulator.limits, N, unique=6),
        timing_for(modulator.limits),
        progress=lambda stored, total: told.append((stored, total)),
    )
    assert {total for _, total in told} == {6}
    assert steps([stored for stored, _ in told], 6), told


def _too_many_patterns(modulator: PatternModulator) -> None:
    # Each is played, for a plane that is not need not be stored.
    modulator.load(sequence_for(modulator.limits, modulator.limits.unique_patterns), timing_for(modulator.limits))


def _too_long_an_order(modulator: PatternModulator) -> None:
    entries = modulator.limits.play_order_entries + 1
    modulator.load(sequence_for(modulator.limits, entries - 1, unique=2), timing_for(modulator.limits))


def _too_fast(modulator: PatternModulator) -> None:
    shortest_us = modulator.limits.shortest_picture_time_us
    if shortest_us == 1:
        raise PictureTimeTooShort(modulator.identity.name, 0.5, 1)
    timing = ModulatorTiming(picture_time_us=shortest_us - 1, sync_width_us=1)
    modulator.load(sequence_for(modulator.limits, N), timing)


def _too_slow(modulator: PatternModulator) -> None:
    timing = ModulatorTiming(picture_time_us=modulator.limits.longest_picture_time_us + 1)
    modulator.load(sequence_for(modulator.limits, N), timing)


def _other_mirrors(modulator: PatternModulator) -> None:
    modulator.load(sequence_for(modulator.limits, N, extra_columns=8), timing_for(modulator.limits))


BAD_LOADS = [
    pytest.param(
        _too_many_patterns, PatternMemoryFull, ("unique_patterns", "play_order_entries"), id="too many patterns"
    ),
    pytest.param(_too_long_an_order, PatternMemoryFull, ("play_order_entries",), id="too long a play order"),
    pytest.param(_too_fast, PictureTimeTooShort, ("shortest_picture_time_us",), id="too short a picture time"),
    pytest.param(_too_slow, PlanError, ("longest_picture_time_us",), id="too long a picture time"),
    pytest.param(_other_mirrors, PlanError, ("columns",), id="patterns for other mirrors"),
]


@pytest.mark.parametrize(("bad_load", "error", "limits"), BAD_LOADS)
def test_what_cannot_be_played_is_refused_by_name(
    modulator: PatternModulator,
    bad_load: Callable[[PatternModulator], None],
    error: type[InputError],
    limits: tuple[str, ...],
) -> None:
    with pytest.raises(error) as refused:
        bad_load(modulator)
    assert_speaks(refused.value, modulator.identity.name)
    numbers = [str(getattr(modulator.limits, limit)) for limit in limits]
    assert any(number in refused.value.expected for number in numbers), f"none of {numbers} is named"


@pytest.mark.parametrize(("bad_load", "error", "limits"), BAD_LOADS)
def test_a_refused_load_leaves_nothing_half_loaded_and_the_next_one_plays(
    rig: ModulatorRig,
    modulator: PatternModulator,
    bad_load: Callable[[PatternModulator], None],
    error: type[InputError],
    limits: tuple[str, ...],
) -> None:
    with pytest.raises(error):
        bad_load(modulator)
    with pytest.raises(WrongState):
        modulator.start()
    load(modulator)
    with pytest.raises(error):
        bad_load(modulator)
    load(modulator, 3)
    play(modulator, 3)
    assert len(edges(rig)) == 4, limits


def test_an_upload_that_is_broken_off_leaves_nothing_and_the_next_one_plays(
    rig: ModulatorRig, modulator: PatternModulator
) -> None:
    def break_off(stored: int, total: int) -> None:
        raise KeyboardInterrupt(stored, total)

    with pytest.raises(KeyboardInterrupt):
        modulator.load(sequence_for(modulator.limits, N), timing_for(modulator.limits), progress=break_off)
    with pytest.raises(WrongState):
        modulator.start()
    load(modulator)
    play(modulator)
    assert len(edges(rig)) == N + 1


def test_loading_while_pictures_are_played_is_refused_and_disturbs_nothing(
    rig: ModulatorRig, modulator: PatternModulator
) -> None:
    load(modulator)
    modulator.start()
    with pytest.raises((WrongState, DeviceBusy)):
        load(modulator, 3)
    modulator.wait(long_s(modulator))
    assert len(edges(rig)) == N + 1
