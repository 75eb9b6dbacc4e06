"""From a checked bench.toml to open devices."""

from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from instrument.acquisition import Devices
from instrument.config import ResolvedBench, ResolvedDevice
from protocols import BenchContext, Clock, MonotonicClock, Scene


@dataclass(frozen=True)
class OpenBench:
    """Open devices, and what closes them."""

    devices: Devices
    """Modulator, counter, stage and their clock."""

    scene: Scene | None
    """The simulated bench; None where all devices are real."""

    closing: ExitStack
    """Closes every device, the last opened first."""


def open_bench(bench: ResolvedBench) -> OpenBench:
    """Open the scene, the transports and the devices that bench.toml names.

    Raises:
        KinopixError: a device did not open; those opened before are closed again.
    """
    with ExitStack() as stack:
        scene = bench.scene.plugin.open(bench.scene.settings, bench.folder) if bench.scene else None
        clock = scene.clock if scene else MonotonicClock()
        devices = Devices(
            modulator=_open(bench.modulator, scene, clock, bench.folder, stack),
            counter=_open(bench.counter, scene, clock, bench.folder, stack),
            stage=_open(bench.stage, scene, clock, bench.folder, stack),
            clock=clock,
        )
        return OpenBench(devices, scene, stack.pop_all())


def _open(device: ResolvedDevice, scene: Scene | None, clock: Clock, folder: Path, stack: ExitStack) -> Any:
    context = BenchContext(clock=clock, scene=scene, folder=folder)
    if device.transport:
        transport = device.transport.plugin.open(device.transport.settings, context)
        context = BenchContext(clock=clock, scene=scene, folder=folder, transport=transport)
        if hasattr(transport, "__exit__"):
            stack.enter_context(cast("AbstractContextManager[object]", transport))
    return stack.enter_context(device.plugin.open(device.settings, context))
