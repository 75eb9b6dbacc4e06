"""Every role of the table is made safe, what moves first, and a fourth one is one more entry."""

from typing import Any, Self

import pytest

from instrument.acquisition import Devices
from instrument.roles import ROLES, Role
from instrument.session import make_safe
from instrument.session.safety import stop_at_once
from protocols import DeviceIdentity, DeviceTimeout, SafeStateFailed, StagePosition
from tests.drivers.zolix.scripted import VirtualClock


class Recorder:
    """A device that notes what it is told."""

    def __init__(self, name: str, told: list[str]) -> None:
        self.name, self.told = name, told

    @property
    def identity(self) -> DeviceIdentity:
        return DeviceIdentity(name=self.name, vendor="v", model="m")

    def rest(self) -> None:
        self.told.append(self.name)

    halt = disarm = stop = rest
    running = False
    stands_by_s = 0.0

    def position(self) -> StagePosition:
        self.told.append(f"{self.name} asked")
        return StagePosition(time_s=0.0, commanded_mm=0.0, reported_mm=0.0)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.told.append(f"{self.name} closed")


@pytest.fixture
def told() -> list[str]:
    return []


@pytest.fixture
def devices(told: list[str], monkeypatch: pytest.MonkeyPatch) -> Devices:
    """A bench with a lamp, which no code knows but this entry."""
    lamp: Role[Any] = Role("lamp", "NXsource", lambda device: device.rest(), any_thread=False, needed=False)
    monkeypatch.setattr("instrument.acquisition.devices.ROLES", (*ROLES, lamp))
    names: tuple[Any, ...] = ("modulator", "counter", "stage", "lamp")
    return Devices.of({name: Recorder(name, told) for name in names}, clock=VirtualClock())


def test_every_role_comes_to_rest_and_what_moves_first(devices: Devices, told: list[str]) -> None:
    make_safe(devices)
    assert told == ["stage", "modulator", "counter", "lamp", "stage asked", "stage asked"]


def test_at_once_only_what_any_thread_may_stop(devices: Devices, told: list[str]) -> None:
    stop_at_once(devices)
    assert told == ["stage", "modulator"]
    told.clear()
    stop_at_once(devices, "hold")
    assert told == ["modulator"]


def test_one_that_fails_keeps_no_other_from_its_rest(devices: Devices, told: list[str]) -> None:
    def broken() -> None:
        raise OSError("the cable is gone")

    devices.by_role["modulator"].halt = broken  # type: ignore[attr-defined]
    with pytest.raises(SafeStateFailed, match="modulator: the cable is gone"):
        make_safe(devices)
    assert told == ["stage", "counter", "lamp", "stage asked", "stage asked"]
    stop_at_once(devices)


def test_devices_are_closed_in_reverse_order(devices: Devices, told: list[str]) -> None:
    devices.closing.close()
    assert told == ["lamp closed", "stage closed", "counter closed", "modulator closed"]
    assert {name: identity.name for name, identity in devices.identities().items()}["stage"] == "stage"


class Moving(Recorder):
    """A stage at 1 mm/s that obeys no stop until ``ends_s``, and tells its place as ``how`` says."""

    def __init__(self, clock: VirtualClock, ends_s: float, how: str = "told") -> None:
        super().__init__("stage", [])
        self.clock, self.ends_s, self.how, self.stands_by_s = clock, ends_s, how, ends_s

    def position(self) -> StagePosition:
        moves = self.clock.now_s() < self.ends_s
        if self.how == "mute" or (self.how == "gone" and moves):
            self.clock.sleep_s(0.5)
            raise DeviceTimeout("stage", awaited="a place", waited_s=0.5, progress="not a byte", remedy="look at it")
        at_mm = min(self.clock.now_s(), self.ends_s)
        return StagePosition(
            time_s=0.0, commanded_mm=9.0, reported_mm=at_mm, predicted=self.how == "predicted" and moves
        )


def beside(stage: Moving) -> Devices:
    """A bench with that stage."""
    return Devices.of(
        {"modulator": Recorder("modulator", []), "counter": Recorder("counter", []), "stage": stage},
        clock=stage.clock,
    )


@pytest.mark.parametrize("how", ["told", "gone", "predicted"])
def test_a_stage_that_obeys_no_stop_is_watched_until_it_stands(how: str) -> None:
    """2.6 s to go; two looks 0.2 s apart begin at the latest then."""
    clock = VirtualClock()
    make_safe(beside(Moving(clock, 2.6, how)))
    assert 2.6 < clock.now_s() < 2.6 + 1.5


@pytest.mark.parametrize(
    ("how", "seen"),
    [
        ("told", "a motion from 4.000 to 4.200 mm in 0.2 s, 4.2 s after the stop"),
        ("gone", "no position (not a byte after 0.5 s)"),
        ("predicted", "no position but a predicted one"),
    ],
)
def test_a_stage_that_moves_for_longer_is_told_with_the_time_that_it_may_take(how: str, seen: str) -> None:
    """Ten seconds to go: it is given up after 4 s and a look, and the rest of the ten seconds is told."""
    clock = VirtualClock()
    with pytest.raises(SafeStateFailed) as unsafe:
        make_safe(beside(Moving(clock, 10.0, how)))
    assert seen in str(unsafe.value)
    assert 4.0 <= clock.now_s() < 5.0
    assert unsafe.value.stands_in_s == pytest.approx(10.0 - clock.now_s())
    assert f"moves for another {10.0 - clock.now_s():.1f} s at most" in str(unsafe.value)


def test_a_stage_that_never_tells_is_not_called_safe_and_not_waited_for_in_vain() -> None:
    clock = VirtualClock()
    clock.sleep_s(5.0)
    with pytest.raises(SafeStateFailed, match="the stage has stood for some time") as unsafe:
        make_safe(beside(Moving(clock, 2.0, "mute")))
    assert list(unsafe.value.failures) == ["stage"]
    assert clock.now_s() < 5.0 + 2.0


def test_a_creeping_stage_moves_and_a_step_of_an_encoder_does_not() -> None:
    """In 0.2 s, 3 um are a motion and 1 um is none; no time is left to wait for more."""
    for um, stands in ((1.0, True), (3.0, False)):
        clock = VirtualClock()
        stage = Moving(clock, 100.0)
        stage.stands_by_s = 0.0
        places = iter(range(10**6))
        stage.position = lambda um=um, places=places: StagePosition(  # type: ignore[misc, method-assign]
            time_s=0.0, commanded_mm=0.0, reported_mm=next(places) * um * 1e-3
        )
        if stands:
            make_safe(beside(stage))
        else:
            with pytest.raises(SafeStateFailed, match="a motion from"):
                make_safe(beside(stage))


def test_a_modulator_that_plays_on_after_its_halt_is_named(devices: Devices) -> None:
    devices.by_role["modulator"].running = True  # type: ignore[attr-defined]
    with pytest.raises(SafeStateFailed, match="pictures that go on after the halt") as unsafe:
        make_safe(devices)
    assert unsafe.value.stands_in_s is None
    assert "stage" not in str(unsafe.value.remedy)
