"""The roles of a bench, one entry each: configuration, opening, safety and the recording are derived from this table."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Generic, Protocol, Self, TypeAlias, TypeVar

from protocols import Clock, DeviceError, DeviceIdentity, KinopixError, LinearStage, PatternModulator, PhotonCounter

LOOK_S: Final = 0.2
"""Time between the two looks that must find a stage at the same place."""

STANDS_MM: Final = 0.002
"""Distance between them that is called the same place: a step of an encoder. What is slower than 0.01 mm/s is called standing."""

LONGEST_LOOK_S: Final = 4.0
"""How long a device is asked whether it is at rest, and a little more: well below the patience of whoever pressed Ctrl-C."""

RoleName: TypeAlias = str
"""Table of bench.toml, kind of plug-in, and group of the recording: the ``name`` of one of ``ROLES``."""


class Device(Protocol):
    """What every device of a bench has, whatever it does."""

    @property
    def identity(self) -> DeviceIdentity:
        """Who the device is."""
        ...

    def __enter__(self) -> Self:
        """Give the open device."""
        ...

    def __exit__(self, *exc: object) -> None:
        """Make it safe and let go of it."""
        ...


DeviceT = TypeVar("DeviceT", bound=Device)


@dataclass(frozen=True)
class Role(Generic[DeviceT]):
    """One place on the bench that a device takes."""

    name: RoleName
    """What bench.toml, messages and recordings call it."""

    nx_class: str
    """NeXus class of its group in the recording."""

    make_safe: Callable[[DeviceT], object]
    """Brings the device to rest. It may be called at any time, and twice."""

    verify: Callable[[DeviceT, Clock], None] | None = None
    """Asks the device, which was told to come to rest, whether it is, for ``LONGEST_LOOK_S`` at most. It raises a ``DeviceError``
    where the device is not at rest or does not tell. None: the device has no more to say than that it obeyed."""

    any_thread: bool = True
    """Whether ``make_safe`` may be called from another thread than the one that works with the device."""

    moves: bool = False
    """Whether something moves: that is brought to rest first."""

    needed: bool = True
    """Whether a bench cannot do without it."""


def _shows_nothing(modulator: PatternModulator, clock: Clock) -> None:
    """Verify that a modulator that was halted plays nothing.

    Raises:
        DeviceError: it plays, or does not tell.
    """
    del clock  # a halt is at once
    if modulator.running:
        raise DeviceError(
            device=modulator.identity.name,
            saw="pictures that go on after the halt",
            expected="a modulator that shows nothing",
            remedy="switch it off by hand",
        )


def _stands(stage: LinearStage, clock: Clock) -> None:
    """Verify that a stage that was stopped stands: it tells the same position twice.

    One that is mute while it moves is asked until its motion must be over, where that is soon.

    Raises:
        DeviceError: it moves, or does not tell.
    """
    now_s = clock.now_s()
    give_up_s = min(now_s + LONGEST_LOOK_S, max(now_s, stage.stands_by_s) + LOOK_S)
    while True:
        begun_s = clock.now_s()
        saw = _motion_seen(stage, clock)
        if saw is None:
            return
        if begun_s >= give_up_s:
            raise DeviceError(
                device=stage.identity.name,
                saw=f"{saw}, {clock.now_s() - now_s:.1f} s after the stop",
                expected="the same position twice",
                remedy="switch it off by hand if it moves",
            )


def _motion_seen(stage: LinearStage, clock: Clock) -> str | None:
    """What speaks against a stage at rest; None where nothing does. It takes ``LOOK_S`` or more."""
    try:
        first = stage.position()
        clock.sleep_s(LOOK_S)
        second = stage.position()
    except KinopixError as error:
        clock.sleep_s(LOOK_S)
        return f"no position ({error.saw})"
    if first.predicted or second.predicted:
        return "no position but a predicted one, as the controller is mute"
    if abs(second.reported_mm - first.reported_mm) > STANDS_MM:
        return f"a motion from {first.reported_mm:.3f} to {second.reported_mm:.3f} mm in {LOOK_S:g} s"
    return None


MODULATOR: Final = Role[PatternModulator](
    "modulator", "NXcollection", lambda modulator: modulator.halt(), verify=_shows_nothing
)
"""Shows the patterns."""

COUNTER: Final = Role[PhotonCounter]("counter", "NXdetector", lambda counter: counter.disarm(), any_thread=False)
"""Counts the light."""

STAGE: Final = Role[LinearStage]("stage", "NXpositioner", lambda stage: stage.stop(), verify=_stands, moves=True)
"""Moves the object."""

ROLES: Final[tuple[Role[Any], ...]] = (MODULATOR, COUNTER, STAGE)
"""Every role, in the order in which devices are opened."""
