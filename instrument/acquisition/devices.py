"""The open devices of one bench, by role."""

from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any, Self, cast

from instrument.roles import COUNTER, MODULATOR, ROLES, STAGE, Device, DeviceT, Role, RoleName
from protocols import Clock, DeviceIdentity, LinearStage, MonotonicClock, PatternModulator, PhotonCounter, Scene


@dataclass(frozen=True, eq=False)
class Devices:
    """Open devices, the clock and the scene that they share, and what closes them."""

    by_role: Mapping[RoleName, Device]
    """Each device under the name of its role."""

    clock: Clock
    """Time for every wait."""

    scene: Scene | None = None
    """The simulated bench that the devices stand on; None where all are real."""

    closing: ExitStack = field(default_factory=ExitStack)
    """Closes every device and transport, the last opened first."""

    @classmethod
    def of(cls, by_role: Mapping[RoleName, Device], *, scene: Scene | None = None, clock: Clock | None = None) -> Self:
        """Compose devices that a script has opened itself; they are closed in reverse order.

        Args:
            by_role: each device under the name of its role.
            scene: the simulated bench that the devices stand on, for its clock and its truth.
            clock: of the devices; the scene's, or the host's, where None.
        """
        closing = ExitStack()
        for device in by_role.values():
            closing.push(device.__exit__)
        return cls(dict(by_role), clock or (scene.clock if scene else MonotonicClock()), scene, closing)

    def __getitem__(self, role: Role[DeviceT]) -> DeviceT:
        """Give the device in a role.

        Raises:
            KeyError: the bench has none.
        """
        return cast("DeviceT", self.by_role[role.name])

    def roles(self) -> Iterator[Role[Any]]:
        """Give the roles that are taken."""
        return (role for role in ROLES if role.name in self.by_role)

    def identities(self) -> dict[RoleName, DeviceIdentity]:
        """Give who each device is."""
        return {name: device.identity for name, device in self.by_role.items()}

    @property
    def modulator(self) -> PatternModulator:
        """The device that shows the patterns."""
        return self[MODULATOR]

    @property
    def counter(self) -> PhotonCounter:
        """The device that counts the light."""
        return self[COUNTER]

    @property
    def stage(self) -> LinearStage:
        """The device that moves the object."""
        return self[STAGE]
