"""From a checked bench.toml to open devices."""

from collections.abc import Collection, Generator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path
from typing import Any, cast

from instrument.acquisition import Devices
from instrument.config import BenchConfig, ResolvedDevice
from instrument.roles import Device, RoleName
from protocols import BenchContext, Clock, LinearStage, MonotonicClock, Scene


def open_devices(bench: BenchConfig, only: Collection[RoleName] | None = None) -> Devices:
    """Open the scene, the transports and the devices that bench.toml names, in the order of their roles.

    Args:
        bench: checked.
        only: roles whose devices are opened; None opens all.

    Raises:
        KinopixError: a device did not open; those opened before are closed again.
    """
    with ExitStack() as stack:
        scene = bench.scene.plugin.open(bench.scene.settings, bench.folder) if bench.scene else None
        clock = scene.clock if scene else MonotonicClock()
        opened: dict[RoleName, Device] = {
            name: _open(device, scene, clock, bench.folder, stack)
            for name, device in bench.devices.items()
            if only is None or name in only
        }
        if scene is not None and "stage" in opened:
            opened["stage"] = scene.carried_by(cast("LinearStage", opened["stage"]))
        return Devices(opened, clock, scene, stack.pop_all())


@contextmanager
def surroundings(bench: BenchConfig, role: RoleName) -> Generator[BenchContext]:
    """Open scene and transport of one device, but not the device itself: for what only its driver can ask of it.

    Raises:
        KinopixError: one of them did not open.
    """
    with ExitStack() as stack:
        scene = bench.scene.plugin.open(bench.scene.settings, bench.folder) if bench.scene else None
        yield _context(bench.devices[role], scene, scene.clock if scene else MonotonicClock(), bench.folder, stack)


def _open(device: ResolvedDevice, scene: Scene | None, clock: Clock, folder: Path, stack: ExitStack) -> Any:
    return stack.enter_context(device.plugin.open(device.settings, _context(device, scene, clock, folder, stack)))


def _context(device: ResolvedDevice, scene: Scene | None, clock: Clock, folder: Path, stack: ExitStack) -> BenchContext:
    context = BenchContext(clock=clock, scene=scene, folder=folder)
    if device.transport is None:
        return context
    transport = device.transport.plugin.open(device.transport.settings, context)
    if hasattr(transport, "__exit__"):
        stack.enter_context(cast("AbstractContextManager[object]", transport))
    return BenchContext(clock=clock, scene=scene, folder=folder, transport=transport)
