"""Rig factories for our own devices: the simulated ones, and the real drivers on their emulators."""

from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from protocols import BenchContext, DriverPlugin, Floats, LinearStage, PatternModulator, PhotonCounter, TransportPlugin
from protocols.conformance import CounterRig, ModulatorRig, StageRig
from sim_backends.bench import OpticalBench, Projection, SceneSettings
from sim_backends.devices import counter as simulated_counter_module
from sim_backends.devices import modulator as simulated_modulator_module
from sim_backends.devices import stage as simulated_stage_module

PHOTONS = SceneSettings.model_validate(
    {"object": "letter-B", "noise": {"kind": "poisson", "peak_counts": 1000.0, "seed": 1}}
)
"""Photons enough that a bright bin is never mistaken for a dark one."""


class WatchedBench(OpticalBench):
    """An optical bench that tells where the carriage is."""

    _position_mm: Callable[[Floats], Floats] | None = None

    def carry(self, position_mm: Callable[[Floats], Floats]) -> None:
        """As ``OpticalBench.carry``."""
        self._position_mm = position_mm
        super().carry(position_mm)

    def carriage_mm(self) -> float:
        """Where the carriage is now."""
        assert self._position_mm is not None
        return float(self._position_mm(np.array([self.clock.now_s()]))[0])


def _plugin(path: str) -> Any:
    """A plug-in by ``module:name``, imported when it is asked for."""
    module, _, name = path.partition(":")
    return getattr(import_module(module), name)


def _transport(path: str, bench: OpticalBench, **settings: object) -> object:
    """What a driver talks through instead of hardware."""
    plugin: TransportPlugin[Any] = _plugin(path)
    return plugin.open(plugin.settings.model_validate(settings), BenchContext(clock=bench.clock, scene=bench))


def _device(path: str, bench: OpticalBench, transport: object | None = None, **settings: object) -> Any:
    plugin: DriverPlugin[Any, Any] = _plugin(path)
    context = BenchContext(clock=bench.clock, scene=bench, transport=transport)
    return plugin.open(plugin.settings.model_validate(settings), context)


# Modulators


def _modulator_rig(bench: OpticalBench, open_modulator: Callable[[], PatternModulator]) -> ModulatorRig:
    return ModulatorRig(
        open=open_modulator, clock=bench.clock, sync_edges=lambda: bench.edges(0, bench.clock.now_s()).time_s
    )


@contextmanager
def simulated_modulator() -> Generator[ModulatorRig]:
    """The simulated DMD."""
    bench = OpticalBench(SceneSettings())
    settings = simulated_modulator_module.ModulatorSettings()
    yield _modulator_rig(bench, lambda: simulated_modulator_module.SimulatedModulator(settings, bench))


@contextmanager
def dlp7000() -> Generator[ModulatorRig]:
    """The DLP7000's driver on an emulated ALP-4 library."""
    bench = OpticalBench(SceneSettings())
    library = _transport("sim_backends.wire.alp.plugin:plugin", bench)
    yield _modulator_rig(bench, lambda: _device("drivers.dlp7000.plugin:plugin", bench, library))


# Counters


def _counter_rig(bench: OpticalBench, open_counter: Callable[[], PhotonCounter]) -> CounterRig:
    planes = np.stack([np.full((bench_rows, 128), fill, np.uint8) for bench_rows, fill in ((768, 0xFF), (768, 0x00))])

    def play(n: int, period_s: float) -> None:
        order = np.arange(n) % 2
        order[-1] = 1
        bench.show(Projection(bench.clock.now_s() + period_s, period_s, lambda index: planes[index], order))

    return CounterRig(open=open_counter, clock=bench.clock, play=play, bright_first=True)


@contextmanager
def simulated_counter() -> Generator[CounterRig]:
    """The simulated counter, counting photons."""
    bench = OpticalBench(PHOTONS)
    settings = simulated_counter_module.CounterSettings()
    yield _counter_rig(bench, lambda: simulated_counter_module.SimulatedCounter(settings, bench))


@contextmanager
def simulated_light_meter() -> Generator[CounterRig]:
    """The simulated counter without noise, which gives light as real numbers, and without edge times."""
    bench = OpticalBench(SceneSettings())
    settings = simulated_counter_module.CounterSettings(edge_times=False, max_bins=1000)
    yield _counter_rig(bench, lambda: simulated_counter_module.SimulatedCounter(settings, bench))


@contextmanager
def ni() -> Generator[CounterRig]:
    """The NI driver on an emulated board behind gRPC."""
    bench = OpticalBench(PHOTONS)
    with ExitStack() as stack:
        options: Any = _transport("sim_backends.wire.ni.plugin:plugin", bench)
        stack.enter_context(options)
        yield _counter_rig(bench, lambda: _device("drivers.h10682.ni_plugin:plugin", bench, options))


@contextmanager
def usb_ctr() -> Generator[CounterRig]:
    """The USB-CTR driver on an emulated board behind pyusb, which gets its FPGA image first."""
    bench = OpticalBench(PHOTONS)
    backend = _transport("sim_backends.wire.usb_ctr.plugin:plugin", bench)
    with TemporaryDirectory() as folder:
        image = Path(folder, "usb-ctr.rbf")
        image.write_bytes(bytes(1000))
        yield _counter_rig(
            bench, lambda: _device("drivers.h10682.usb_ctr_plugin:plugin", bench, backend, fpga_image=image)
        )


# Stages


@contextmanager
def simulated_stage() -> Generator[StageRig]:
    """The simulated stage. It stays where it is while nobody has it open, as a real one does."""
    bench = WatchedBench(SceneSettings())
    stands_mm = [123.4]

    class Remembered(simulated_stage_module.SimulatedStage):
        def __exit__(self, *exc: object) -> None:
            super().__exit__(*exc)
            stands_mm[0] = self.position().reported_mm

    def open_stage() -> LinearStage:
        return Remembered(simulated_stage_module.StageSettings(position_mm=stands_mm[0], homed=False), bench)

    yield StageRig(open=open_stage, clock=bench.clock, carriage_mm=bench.carriage_mm)


@contextmanager
def _ka400z(emulator: str) -> Generator[StageRig]:
    bench = WatchedBench(SceneSettings())
    port: Any = _transport(emulator, bench, lead_mm=4.0, microsteps=8, travel_mm=(-50.0, 350.0))

    def open_stage() -> LinearStage:
        if not port.is_open:  # the driver gave it back when it was closed
            port.open()
        stage: LinearStage = _device(
            "drivers.ka400z.plugin:plugin",
            bench,
            port,
            lead_mm=4.0,
            microsteps=8,
            travel_mm=(-40.0, 340.0),
            max_velocity_mm_s=20.0,
            max_acceleration_mm_s2=100.0,
            home_velocity_mm_s=5.0,
            initial_velocity_mm_s=0.5,
        )
        return stage

    yield StageRig(open=open_stage, clock=bench.clock, carriage_mm=bench.carriage_mm)


@contextmanager
def mc600() -> Generator[StageRig]:
    """The KA400Z's driver on an emulated MC600."""
    with _ka400z("sim_backends.wire.zolix.plugin:mc600") as rig:
        yield rig


@contextmanager
def sc300() -> Generator[StageRig]:
    """The KA400Z's driver on an emulated SC300."""
    with _ka400z("sim_backends.wire.zolix.plugin:sc300") as rig:
        yield rig
