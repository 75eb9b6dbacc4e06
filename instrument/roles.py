"""The roles of a bench, one entry each: configuration, opening, safety and the recording are derived from this table."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Generic, Protocol, Self, TypeAlias, TypeVar

from protocols import DeviceIdentity, LinearStage, PatternModulator, PhotonCounter

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

    any_thread: bool = True
    """Whether ``make_safe`` may be called from another thread than the one that works with the device."""

    moves: bool = False
    """Whether something moves: that is brought to rest first."""

    needed: bool = True
    """Whether a bench cannot do without it."""


MODULATOR: Final = Role[PatternModulator]("modulator", "NXcollection", lambda modulator: modulator.halt())
"""Shows the patterns."""

COUNTER: Final = Role[PhotonCounter]("counter", "NXdetector", lambda counter: counter.disarm(), any_thread=False)
"""Counts the light."""

STAGE: Final = Role[LinearStage]("stage", "NXpositioner", lambda stage: stage.stop(), moves=True)
"""Moves the object."""

ROLES: Final[tuple[Role[Any], ...]] = (MODULATOR, COUNTER, STAGE)
"""Every role, in the order in which devices are opened."""
