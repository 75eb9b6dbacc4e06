"""How a run of a ``PatternModulator`` is ended before its time: by a halt, or by leaving."""

from contextlib import suppress

import pytest

from protocols.conformance.modulator_fixtures import *  # noqa: F403
from protocols.conformance.patterns import run_s, sequence_for
from protocols.conformance.playing import N, edges, load, long_s, play
from protocols.conformance.rigs import ModulatorRig
from protocols.conformance.support import in_another_thread
from protocols.errors import WrongState
from protocols.modulator import PatternModulator

# Halting


def test_halting_is_allowed_in_every_state_and_twice(rig: ModulatorRig, modulator: PatternModulator) -> None:
    def halt() -> None:
        modulator.halt()
        modulator.halt()
        assert not modulator.running

    halt()
    load(modulator)
    halt()
    modulator.start()
    halt()
    modulator.start()
    modulator.wait(long_s(modulator))
    halt()
    assert len(edges(rig)) == N + 1


def test_a_halt_from_another_thread_stops_the_pictures(rig: ModulatorRig, modulator: PatternModulator) -> None:
    timing = load(modulator)
    whole_s = run_s(sequence_for(modulator.limits, N), timing)
    modulator.start()
    rig.clock.sleep_s(whole_s / 2)
    before_s = rig.clock.now_s()
    in_another_thread(modulator.halt)
    assert rig.clock.now_s() - before_s < whole_s / 4, "the halt waited"
    assert not modulator.running
    shown = len(edges(rig))
    assert 0 < shown < N
    rig.clock.sleep_s(whole_s)
    assert len(edges(rig)) == shown


def test_a_halt_reaches_the_device_while_another_thread_waits(
    rig: ModulatorRig, modulator: PatternModulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    load(modulator)
    modulator.start()
    sleep_s, slept = rig.clock.sleep_s, list[float]()

    def sleep_and_halt(duration_s: float) -> None:
        slept.append(duration_s)
        if len(slept) == 1:
            in_another_thread(modulator.halt)
        sleep_s(duration_s)

    monkeypatch.setattr(rig.clock, "sleep_s", sleep_and_halt)
    with suppress(WrongState):  # a run that was halted has no last picture; to say so is as good as to return
        modulator.wait(long_s(modulator))
    if not slept:
        pytest.skip("this driver does not wait by clock.sleep_s")
    assert not modulator.running


def test_a_halted_run_can_be_played_again_from_its_first_picture(
    rig: ModulatorRig, modulator: PatternModulator
) -> None:
    timing = load(modulator)
    modulator.start()
    rig.clock.sleep_s(run_s(sequence_for(modulator.limits, N), timing) / 3)
    modulator.halt()
    play(modulator)
    assert len(edges(rig)) == N + 1


# Closing


def test_leaving_halts_the_pictures(rig: ModulatorRig) -> None:
    with rig.open() as modulator:
        timing = load(modulator)
        whole_s = run_s(sequence_for(modulator.limits, N), timing)
        modulator.start()
        rig.clock.sleep_s(whole_s / 2)
    shown = len(edges(rig))
    assert shown < N
    rig.clock.sleep_s(whole_s)
    assert len(edges(rig)) == shown


def test_leaving_hides_no_error(rig: ModulatorRig) -> None:
    def fail_in_mid_run() -> None:
        with rig.open() as modulator:
            load(modulator)
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
            load(modulator)
            play(modulator)
            assert len(edges(rig)) == N + 1
    assert len(identities) == 1
