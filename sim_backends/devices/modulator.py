"""A simulated DMD: the limits and the life cycle of the real board, its pictures on the optical bench."""

from typing import Self

from protocols import (
    BenchContext,
    DeviceBusy,
    DeviceIdentity,
    DeviceTimeout,
    DriverPlugin,
    Frozen,
    ModulatorLimits,
    ModulatorTiming,
    PatternSequence,
    UploadProgress,
    WrongState,
)
from sim_backends.bench import OpticalBench, Projection
from sim_backends.bench.bounds import Microseconds, Mirrors, Number, Seconds
from sim_backends.devices.place import place

_NAME = "dmd"


class ModulatorSettings(Frozen):
    """Keys of ``[modulator]``. The defaults are those of a DLP7000 on a V-7000 board."""

    columns: Mirrors = 1024
    """Number of mirrors in a row."""

    rows: Mirrors = 768
    """Number of rows of mirrors."""

    shortest_picture_time_us: Microseconds = 44
    """Shortest time from one picture to the next, in microseconds."""

    longest_picture_time_us: Microseconds = 10_000_000
    """Longest time from one picture to the next, in microseconds."""

    unique_patterns: Number = 43_690
    """Number of bit planes in the board's memory (4 GiB; a V-7001 may have twice as many)."""

    play_order_entries: Number = 131_072
    """Longest play order, in pictures. The real board tells its own when asked; this figure is an assumption."""

    start_delay_s: Seconds = 1e-4
    """Time from ``start`` to the first sync edge, in seconds. It is unknown for the real board [U]."""


class SimulatedModulator:
    """``protocols.PatternModulator`` on the optical bench."""

    def __init__(self, settings: ModulatorSettings, bench: OpticalBench) -> None:
        self._settings = settings
        self._bench = bench
        self._loaded: tuple[PatternSequence, ModulatorTiming] | None = None
        self._started = False
        self._closed = False

    @property
    def identity(self) -> DeviceIdentity:
        """Identity of the simulated device."""
        return DeviceIdentity(
            name=_NAME, vendor="Kinopix", model="simulated DLP7000", driver="simulated", simulated=True
        )

    @property
    def limits(self) -> ModulatorLimits:
        """Geometry, picture times and memory, as set."""
        settings = self._settings
        return ModulatorLimits(
            columns=settings.columns,
            rows=settings.rows,
            shortest_picture_time_us=settings.shortest_picture_time_us,
            longest_picture_time_us=settings.longest_picture_time_us,
            unique_patterns=settings.unique_patterns,
            play_order_entries=settings.play_order_entries,
        )

    def load(
        self, sequence: PatternSequence, timing: ModulatorTiming, progress: UploadProgress | None = None
    ) -> ModulatorTiming:
        """Take a sequence; see ``protocols.PatternModulator.load``."""
        if self.running:
            raise DeviceBusy(
                device=_NAME,
                saw="a new sequence while pictures are being played",
                expected="an idle modulator",
                remedy="wait for the end of the run, or halt it",
            )
        self._refuse_closed()
        self._loaded = None
        self.limits.check_sequence(sequence, _NAME)
        self.limits.check_timing(timing, _NAME)
        if progress:
            for stored in range(1, len(sequence.planes) + 1):
                progress(stored, len(sequence.planes))
        self._loaded, self._started = (sequence, timing), False
        return timing

    def start(self) -> None:
        """Play the order once; see ``protocols.PatternModulator.start``."""
        self._refuse_closed()
        if self._loaded is None or self.running:
            raise WrongState(
                device=_NAME,
                saw="a start " + ("without a sequence" if self._loaded is None else "while the last run still plays"),
                expected="a loaded, idle modulator",
                remedy="load a sequence first" if self._loaded is None else "wait for the end of the run, or halt it",
            )
        sequence, timing = self._loaded
        delay_s = timing.sync_delay_us * 1e-6
        self._bench.show(
            Projection(
                start_s=self._bench.clock.now_s() + self._settings.start_delay_s + delay_s,
                picture_time_s=timing.picture_time_us * 1e-6,
                mirrors=sequence.mirror_plane,
                play_order=sequence.play_order,
                sync_delay_s=delay_s,
            )
        )
        self._started = True

    @property
    def running(self) -> bool:
        """Whether pictures are being played now."""
        return self._started and self._bench.clock.now_s() < self._bench.shown_until_s

    def wait(self, timeout_s: float) -> None:
        """Return when the last picture has been shown; see ``protocols.PatternModulator.wait``."""
        if not self._started:
            raise WrongState(
                device=_NAME, saw="a wait for a run that never started", expected="a started run", remedy="start it"
            )
        clock = self._bench.clock
        deadline_s, end_s = clock.now_s() + timeout_s, self._bench.shown_until_s
        clock.advance_to(min(deadline_s, end_s))
        if self.running and self._loaded is not None:
            given, pictures = len(self._bench.edges(0, clock.now_s())), len(self._loaded[0].play_order)
            raise DeviceTimeout(
                _NAME,
                awaited="the end of the play order",
                waited_s=timeout_s,
                progress=f"{given} of {pictures} sync edges given, still playing",
                remedy="halt the modulator, and allow at least picture time times pictures",
            )

    def halt(self) -> None:
        """Stop at once and show nothing."""
        if self.running:
            self._bench.dark()

    def _refuse_closed(self) -> None:
        if self._closed:
            raise WrongState(
                device=_NAME, saw="a call after the device was closed", expected="an open device", remedy="open it anew"
            )

    def __enter__(self) -> Self:
        """Give the open device."""
        return self

    def __exit__(self, *exc: object) -> None:
        """Halt, forget the sequence, and close."""
        self.halt()
        self._loaded, self._closed = None, True


def open_modulator(settings: ModulatorSettings, context: BenchContext) -> SimulatedModulator:
    """Open the simulated modulator on the context's optical bench."""
    return SimulatedModulator(settings, place(context, _NAME))


plugin = DriverPlugin(summary="simulated DMD on the optical bench", settings=ModulatorSettings, open=open_modulator)
"""Found as ``kinopix.modulators: simulated``."""
