"""Rig factories for our own devices: the simulated ones, and the real drivers on their emulators."""

from collections.abc import Callable, Generator, Mapping
from contextlib import ExitStack, contextmanager
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any

import numpy as np

from protocols import BenchContext, DriverPlugin, Floats, LinearStage, PatternModulator, PhotonCounter, TransportPlugin
from protocols.conformance import CounterRig, ModulatorRig, StageRig
from sim_backends.bench import OpticalBench, Projection, SceneSettings
from sim_backends.devices.counter import CounterSettings, SimulatedCounter
from sim_backends.devices.modulator import ModulatorSettings, SimulatedModulator
from sim_backends.devices.stage import SimulatedStage, StageSettings

PHOTONS = SceneSettings.model_validate(
    {"object": "letter-B", "noise": {"kind": "poisson", "peak_counts": 1000.0, "seed": 1}}
)
"""Photons enough that a bright bin is never mistaken for a dark one."""


def _not_carried(time_s: Floats) -> Floats:
    """Where the carriage is before a stage has been opened."""
    return np.full(len(time_s), 123.4)


class WatchedBench(OpticalBench):
    """An optical bench that tells where the carriage is."""

    _position_mm: Callable[[Floats], Floats] = staticmethod(_not_carried)

    def carry(self, position_mm: Callable[[Floats], Floats]) -> None:
        """As ``OpticalBench.carry``."""
        self._position_mm = position_mm
        super().carry(position_mm)

    def carriage_mm(self) -> float:
        """Where the carriage is now."""
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


def modulator_rig(bench: OpticalBench, open_modulator: Callable[[], PatternModulator]) -> ModulatorRig:
    """Watch the sync line on the bench."""
    return ModulatorRig(
        open=open_modulator, clock=bench.clock, sync_edges=lambda: bench.edges(0, bench.clock.now_s()).time_s
    )


@contextmanager
def simulated_modulator() -> Generator[ModulatorRig]:
    """The simulated DMD."""
    bench = OpticalBench(SceneSettings())
    settings = ModulatorSettings()
    yield modulator_rig(bench, lambda: SimulatedModulator(settings, bench))


@contextmanager
def dlp7000() -> Generator[ModulatorRig]:
    """The DLP7000's driver on an emulated ALP-4 library."""
    with _dlp7000() as rig:
        yield rig


@contextmanager
def dlp7000_without_table() -> Generator[ModulatorRig]:
    """The same on a board without frame look-up table, which has to store the play order picture by picture."""
    with _dlp7000(flut_max_entries9=0) as rig:
        yield rig


@contextmanager
def _dlp7000(**board: object) -> Generator[ModulatorRig]:
    bench = OpticalBench(SceneSettings())
    library = _transport("sim_backends.wire.alp.plugin:plugin", bench, **board)
    yield modulator_rig(bench, lambda: _device("drivers.alp.plugin:plugin", bench, library))


@contextmanager
def dlp6500() -> Generator[ModulatorRig]:
    """The DLPC900's driver on an emulated board with one controller."""
    with _dlpc900("DLP6500") as rig:
        yield rig


@contextmanager
def dlp9000() -> Generator[ModulatorRig]:
    """The same on one with two, each with half of the mirrors."""
    with _dlpc900("DLP9000") as rig:
        yield rig


@contextmanager
def _dlpc900(model: str) -> Generator[ModulatorRig]:
    bench = OpticalBench(SceneSettings())
    reports = _transport("sim_backends.wire.dlpc900.plugin:plugin", bench, model=model, report_s=2e-6)
    yield modulator_rig(bench, lambda: _device("drivers.dlpc900.plugin:plugin", bench, reports))


# Counters


def counter_rig(bench: OpticalBench, open_counter: Callable[[], PhotonCounter]) -> CounterRig:
    """Light the whole field and darken it, in turns."""
    lit_and_dark = np.stack([np.full((768, 128), fill, np.uint8) for fill in (0xFF, 0x00)])

    def play(n: int, period_s: float) -> None:
        order = np.arange(n) % 2
        order[-1] = 1
        bench.show(Projection(bench.clock.now_s() + period_s, period_s, lambda index: lit_and_dark[index], order))

    return CounterRig(open=open_counter, clock=bench.clock, play=play, bright_first=True)


@contextmanager
def simulated_counter() -> Generator[CounterRig]:
    """The simulated counter, counting photons."""
    bench = OpticalBench(PHOTONS)
    settings = CounterSettings()
    yield counter_rig(bench, lambda: SimulatedCounter(settings, bench))


@contextmanager
def simulated_light_meter() -> Generator[CounterRig]:
    """The simulated counter without noise, which gives light as real numbers, and without edge times."""
    bench = OpticalBench(SceneSettings())
    settings = CounterSettings(edge_times=False, max_bins=1000)
    yield counter_rig(bench, lambda: SimulatedCounter(settings, bench))


@contextmanager
def ni() -> Generator[CounterRig]:
    """The NI driver on an emulated board behind gRPC."""
    bench = OpticalBench(PHOTONS)
    with ExitStack() as stack:
        options: Any = _transport("sim_backends.wire.ni.plugin:plugin", bench)
        stack.enter_context(options)
        yield counter_rig(bench, lambda: _device("drivers.ni.plugin:plugin", bench, options))


@contextmanager
def usb_ctr() -> Generator[CounterRig]:
    """The USB-CTR driver on an emulated board behind libusb, which gets its FPGA image first."""
    with _usb_ctr() as rig:
        yield rig


@contextmanager
def usb_ctr_with_timer() -> Generator[CounterRig]:
    """The same with a timer wired to a second input, which times the edges."""
    with _usb_ctr({"timer_wires": ({"timer": 1, "counter": 1},)}, edge_timer={"timer": 1, "counter": 1}) as rig:
        yield rig


@contextmanager
def _usb_ctr(board: Mapping[str, object] = MappingProxyType({}), **settings: object) -> Generator[CounterRig]:
    bench = OpticalBench(PHOTONS)
    backend = _transport("sim_backends.wire.usb_ctr.plugin:plugin", bench, **board)
    with TemporaryDirectory() as folder:
        image = Path(folder, "usb-ctr.rbf")
        image.write_bytes(bytes(1000))
        yield counter_rig(
            bench,
            lambda: _device("drivers.usb_ctr.plugin:plugin", bench, backend, fpga_image=image, **settings),
        )


@contextmanager
def ni_analog() -> Generator[CounterRig]:
    """The driver of NI analogue inputs on an emulated board behind gRPC, which gives volts."""
    bench = OpticalBench(PHOTONS)
    with ExitStack() as stack:
        options: Any = _transport("sim_backends.wire.ni_analog.plugin:plugin", bench)
        stack.enter_context(options)
        yield counter_rig(bench, lambda: _device("drivers.ni.analog.plugin:plugin", bench, options))


@contextmanager
def serial_counter() -> Generator[CounterRig]:
    """The serial counter's driver on an emulated box."""
    bench = OpticalBench(PHOTONS)
    port: Any = _transport("sim_backends.wire.serial_counter.plugin:plugin", bench)

    def open_counter() -> PhotonCounter:
        if not port.is_open:
            port.open()
        settings = {"max_sync_rate_hz": 20_000}
        counter: PhotonCounter = _device("drivers.serial_counter.plugin:plugin", bench, port, **settings)
        return counter

    yield counter_rig(bench, open_counter)


# Stages


@contextmanager
def stage_rig(kind: type[SimulatedStage]) -> Generator[StageRig]:
    """A simulated stage that stays where it is while nobody has it open, as a real one does."""
    bench = WatchedBench(SceneSettings())

    def open_stage() -> LinearStage:
        settings = StageSettings(position_mm=bench.carriage_mm(), homed=False)
        return kind(settings, bench)

    yield StageRig(open=open_stage, clock=bench.clock, carriage_mm=bench.carriage_mm)


@contextmanager
def simulated_stage() -> Generator[StageRig]:
    """The simulated stage."""
    with stage_rig(SimulatedStage) as rig:
        yield rig


@contextmanager
def _ka400z(
    dialect: str, settings: Mapping[str, object] = MappingProxyType({}), **controller: object
) -> Generator[StageRig]:
    bench = WatchedBench(SceneSettings())
    emulator = f"sim_backends.wire.zolix.plugin:{dialect}"
    port: Any = _transport(emulator, bench, lead_mm=4.0, microsteps=8, travel_mm=(-50.0, 350.0), **controller)

    def open_stage() -> LinearStage:
        if not port.is_open:  # the driver gave it back when it was closed
            port.open()
        stage: LinearStage = _device(
            "drivers.zolix.plugin:plugin",
            bench,
            port,
            lead_mm=4.0,
            microsteps=8,
            travel_mm=(-40.0, 340.0),
            max_velocity_mm_s=20.0,
            max_acceleration_mm_s2=100.0,
            home_velocity_mm_s=5.0,
            **settings,
        )
        return stage

    yield StageRig(open=open_stage, clock=bench.clock, carriage_mm=bench.carriage_mm)


@contextmanager
def mc600() -> Generator[StageRig]:
    """The KA400Z's driver on an emulated MC600."""
    with _ka400z("mc600") as rig:
        yield rig


@contextmanager
def mute_mc600() -> Generator[StageRig]:
    """The same on one that says nothing in motion but takes a stop, which it does not answer."""
    with _ka400z("mc600", {}, busy_policy="mute", stop_reply="", stop_ramp="abrupt") as rig:
        yield rig


@contextmanager
def sc300() -> Generator[StageRig]:
    """The KA400Z's driver on an emulated SC300."""
    with _ka400z("sc300") as rig:
        yield rig


@contextmanager
def talkative_sc300() -> Generator[StageRig]:
    """The same on one that answers in motion, ends a stopped motion without a line, and takes no start velocity of 0."""
    start = {"initial_velocity_mm_s": 0.5}
    with _ka400z("sc300", start, busy_policy="answer", stop_completion=False, zero_initial_speed=False) as rig:
        yield rig


@contextmanager
def zaber() -> Generator[StageRig]:
    """The Zaber driver on an emulated controller."""
    with _serial_stage("zaber", {"microsteps_per_mm": 15_625}) as rig:
        yield rig


@contextmanager
def grbl() -> Generator[StageRig]:
    """The GRBL driver on an emulated board that is locked when power comes."""
    with _serial_stage("grbl", {"unlock": True}) as rig:
        yield rig


@contextmanager
def _serial_stage(kind: str, settings: Mapping[str, object], **emulator: object) -> Generator[StageRig]:
    bench = WatchedBench(SceneSettings())
    port: Any = _transport(f"sim_backends.wire.{kind}.plugin:plugin", bench, **emulator)

    def open_stage() -> LinearStage:
        if not port.is_open:
            port.open()
        limits = {"travel_mm": (0.0, 350.0), "max_velocity_mm_s": 20.0, "max_acceleration_mm_s2": 100.0}
        stage: LinearStage = _device(f"drivers.{kind}.plugin:plugin", bench, port, **limits, **settings)
        return stage

    yield StageRig(open=open_stage, clock=bench.clock, carriage_mm=bench.carriage_mm)
