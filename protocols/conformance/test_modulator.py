"""What the framework relies on in a ``PatternModulator``, sentence by sentence of its docstrings."""

from collections.abc import Callable, Iterator
from contextlib import suppress

import numpy as np
import pytest

from protocols.conformance.patterns import run_s, sequence_for, steps, timing_for
from protocols.conformance.rigs import ModulatorRig, RigFactory
from protocols.conformance.support import assert_speaks, in_another_thread
from protocols.errors import (
    DeviceBusy,
    DeviceTimeout,
    InputError,
    PatternMemoryFull,
    PictureTimeTooShort,
    PlanError,
    WrongState,
)
from protocols.modulator import ModulatorTiming, PatternModulator
from protocols.values import Floats

N = 20
"""Pictures in most runs, without the guard."""


@pytest.fixture
def rig(open_rig: RigFactory[ModulatorRig]) -> Iterator[ModulatorRig]:
    """What the device stands on."""
    with open_rig() as rig:
        yield rig


@pytest.fixture
def modulator(rig: ModulatorRig) -> Iterator[PatternModulator]:
    """An open device."""
    with rig.open() as modulator:
        yield modulator


def _load(modulator: PatternModulator, n_patterns: int = N) -> ModulatorTiming:
    return modulator.load(sequence_for(modulator.limits, n_patterns), timing_for(modulator.limits))


def _play(modulator: PatternModulator, n_patterns: int = N) -> None:
    modulator.start()
    modulator.wait(_long_s(modulator, n_patterns))
    assert not modulator.running


def _long_s(modulator: PatternModulator, n_patterns: int = N) -> float:
    return 2 * run_s(sequence_for(modulator.limits, n_patterns), timing_for(modulator.limits)) + 1.0


def _edges(rig: ModulatorRig) -> Floats:
    if rig.sync_edges is None:
        pytest.skip("the rig has no sync_edges: nobody looks at the sync line")
    return rig.sync_edges()


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
    asked, kept = timing_for(modulator.limits), _load(modulator)
    assert kept.picture_time_us == pytest.approx(asked.picture_time_us, rel=0.01)
    assert kept.sync_width_us < kept.picture_time_us
    _play(modulator)
    gaps_s = np.diff(_edges(rig))
    assert gaps_s == pytest.approx(kept.picture_time_us * 1e-6, rel=1e-3)


def test_the_shortest_picture_time_is_played(modulator: PatternModulator) -> None:
    shortest_us = modulator.limits.shortest_picture_time_us
    kept = modulator.load(
        sequence_for(modulator.limits, N),
        timing_for(modulator.limits).model_copy(update={"picture_time_us": shortest_us}),
    )
    assert kept.picture_time_us == shortest_us
    _play(modulator)


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
    _load(modulator)
    with pytest.raises(error):
        bad_load(modulator)
    _load(modulator, 3)
    _play(modulator, 3)
    assert len(_edges(rig)) == 4, limits


def test_an_upload_that_is_broken_off_leaves_nothing_and_the_next_one_plays(
    rig: ModulatorRig, modulator: PatternModulator
) -> None:
    def break_off(stored: int, total: int) -> None:
        raise KeyboardInterrupt(stored, total)

    with pytest.raises(KeyboardInterrupt):
        modulator.load(sequence_for(modulator.limits, N), timing_for(modulator.limits), progress=break_off)
    with pytest.raises(WrongState):
        modulator.start()
    _load(modulator)
    _play(modulator)
    assert len(_edges(rig)) == N + 1


def test_loading_while_pictures_are_played_is_refused_and_disturbs_nothing(
    rig: ModulatorRig, modulator: PatternModulator
) -> None:
    _load(modulator)
    modulator.start()
    with pytest.raises((WrongState, DeviceBusy)):
        _load(modulator, 3)
    modulator.wait(_long_s(modulator))
    assert len(_edges(rig)) == N + 1


# Playing


def test_starting_without_a_sequence_is_refused(modulator: PatternModulator) -> None:
    with pytest.raises(WrongState) as refused:
        modulator.start()
    assert_speaks(refused.value, modulator.identity.name)
    assert not modulator.running


def test_a_start_returns_at_once_and_the_device_runs_until_the_wait_is_over(
    rig: ModulatorRig, modulator: PatternModulator
) -> None:
    timing = _load(modulator)
    whole_s = run_s(sequence_for(modulator.limits, N), timing)
    assert not modulator.running
    before_s = rig.clock.now_s()
    modulator.start()
    assert rig.clock.now_s() - before_s < 0.5 * whole_s
    assert bool(modulator.running)
    modulator.wait(_long_s(modulator))
    took_s = rig.clock.now_s() - before_s
    assert 0.98 * whole_s <= took_s <= 1.1 * whole_s + 0.1
    assert not modulator.running


def test_starting_twice_is_refused_and_disturbs_nothing(rig: ModulatorRig, modulator: PatternModulator) -> None:
    _load(modulator)
    modulator.start()
    with pytest.raises(WrongState) as refused:
        modulator.start()
    assert_speaks(refused.value, modulator.identity.name)
    modulator.wait(_long_s(modulator))
    assert len(_edges(rig)) == N + 1


@pytest.mark.parametrize("n_patterns", [1, 2, 7, N])
def test_n_patterns_and_the_guard_give_n_plus_1_edges(
    rig: ModulatorRig, modulator: PatternModulator, n_patterns: int
) -> None:
    _load(modulator, n_patterns)
    _play(modulator, n_patterns)
    assert len(_edges(rig)) == n_patterns + 1


def test_a_plane_that_is_stored_once_may_be_played_often(rig: ModulatorRig, modulator: PatternModulator) -> None:
    modulator.load(sequence_for(modulator.limits, N, unique=3), timing_for(modulator.limits))
    _play(modulator)
    assert len(_edges(rig)) == N + 1


def test_a_second_start_replays(rig: ModulatorRig, modulator: PatternModulator) -> None:
    _load(modulator)
    for _ in range(3):
        _play(modulator)
        assert len(_edges(rig)) == N + 1


def test_a_new_sequence_takes_the_place_of_the_old(rig: ModulatorRig, modulator: PatternModulator) -> None:
    for n_patterns in (N, 3, 9):
        _load(modulator, n_patterns)
        _play(modulator, n_patterns)
        assert len(_edges(rig)) == n_patterns + 1


# Waiting


def test_waiting_for_what_never_started_is_refused(modulator: PatternModulator) -> None:
    with pytest.raises(WrongState):
        modulator.wait(1.0)
    _load(modulator)
    with pytest.raises(WrongState) as refused:
        modulator.wait(1.0)
    assert_speaks(refused.value, modulator.identity.name)


def test_a_wait_that_is_too_short_says_how_far_the_run_has_come_and_the_run_goes_on(
    rig: ModulatorRig, modulator: PatternModulator
) -> None:
    timing = _load(modulator)
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
    modulator.wait(_long_s(modulator))
    assert len(_edges(rig)) == N + 1


def test_a_wait_after_the_end_returns_at_once(rig: ModulatorRig, modulator: PatternModulator) -> None:
    timing = _load(modulator)
    _play(modulator)
    before_s = rig.clock.now_s()
    modulator.wait(_long_s(modulator))
    assert rig.clock.now_s() - before_s < run_s(sequence_for(modulator.limits, N), timing) / 2


# Halting


def test_halting_is_allowed_in_every_state_and_twice(rig: ModulatorRig, modulator: PatternModulator) -> None:
    def halt() -> None:
        modulator.halt()
        modulator.halt()
        assert not modulator.running

    halt()
    _load(modulator)
    halt()
    modulator.start()
    halt()
    modulator.start()
    modulator.wait(_long_s(modulator))
    halt()
    assert len(_edges(rig)) == N + 1


def test_a_halt_from_another_thread_stops_the_pictures(rig: ModulatorRig, modulator: PatternModulator) -> None:
    timing = _load(modulator)
    whole_s = run_s(sequence_for(modulator.limits, N), timing)
    modulator.start()
    rig.clock.sleep_s(whole_s / 2)
    before_s = rig.clock.now_s()
    in_another_thread(modulator.halt)
    assert rig.clock.now_s() - before_s < whole_s / 4, "the halt waited"
    assert not modulator.running
    shown = len(_edges(rig))
    assert 0 < shown < N
    rig.clock.sleep_s(whole_s)
    assert len(_edges(rig)) == shown


def test_a_halt_reaches_the_device_while_another_thread_waits(
    rig: ModulatorRig, modulator: PatternModulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    _load(modulator)
    modulator.start()
    sleep_s, slept = rig.clock.sleep_s, list[float]()

    def sleep_and_halt(duration_s: float) -> None:
        slept.append(duration_s)
        if len(slept) == 1:
            in_another_thread(modulator.halt)
        sleep_s(duration_s)

    monkeypatch.setattr(rig.clock, "sleep_s", sleep_and_halt)
    with suppress(WrongState):  # a run that was halted has no last picture; to say so is as good as to return
        modulator.wait(_long_s(modulator))
    if not slept:
        pytest.skip("this driver does not wait by clock.sleep_s")
    assert not modulator.running


def test_a_halted_run_can_be_played_again_from_its_first_picture(
    rig: ModulatorRig, modulator: PatternModulator
) -> None:
    timing = _load(modulator)
    modulator.start()
    rig.clock.sleep_s(run_s(sequence_for(modulator.limits, N), timing) / 3)
    modulator.halt()
    _play(modulator)
    assert len(_edges(rig)) == N + 1


# Closing


def test_leaving_halts_the_pictures(rig: ModulatorRig) -> None:
    with rig.open() as modulator:
        timing = _load(modulator)
        whole_s = run_s(sequence_for(modulator.limits, N), timing)
        modulator.start()
        rig.clock.sleep_s(whole_s / 2)
    shown = len(_edges(rig))
    assert shown < N
    rig.clock.sleep_s(whole_s)
    assert len(_edges(rig)) == shown


def test_leaving_hides_no_error(rig: ModulatorRig) -> None:
    def fail_in_mid_run() -> None:
        with rig.open() as modulator:
            _load(modulator)
            modulator.start()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_in_mid_run()


def test_it_can_be_opened_again_after_it_was_closed(rig: ModulatorRig) -> None:
    identities = set[str]()
    for _ in range(3):
        with rig.open() as modulator:
            identities.add(modulator.identity.model_dump_json())
            assert not modulator.running
            with pytest.raises(WrongState):
                modulator.start()  # nothing is left from the time before
            _load(modulator)
            _play(modulator)
            assert len(_edges(rig)) == N + 1
    assert len(identities) == 1
