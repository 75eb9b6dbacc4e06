"""Every role of the table is made safe, what moves first, and a fourth one is one more entry."""

from typing import Any, Self

import pytest

from instrument.acquisition import Devices
from instrument.roles import ROLES, Role
from instrument.session import make_safe
from instrument.session.safety import stop_at_once
from protocols import DeviceIdentity, SafeStateFailed


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
    return Devices.of({name: Recorder(name, told) for name in names})


def test_every_role_comes_to_rest_and_what_moves_first(devices: Devices, told: list[str]) -> None:
    make_safe(devices)
    assert told == ["stage", "modulator", "counter", "lamp"]


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
    assert told == ["stage", "counter", "lamp"]
    stop_at_once(devices)


def test_devices_are_closed_in_reverse_order(devices: Devices, told: list[str]) -> None:
    devices.closing.close()
    assert told == ["lamp closed", "stage closed", "counter closed", "modulator closed"]
    assert {name: identity.name for name, identity in devices.identities().items()}["stage"] == "stage"
