"""The bench as one thing: composes the devices, runs plans, keeps everything safe."""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Self

import numpy as np

from instrument.acquisition import AlignedBlock, CheckReport, Devices, Outcome, acquire, check_plan, prepare
from instrument.config import OnAbort, load_bench
from instrument.opening import open_bench
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.safety import make_safe
from instrument.schemes import scheme_of
from instrument.storage import RecordingWriter, open_recording, refuse_existing
from protocols import (
    Clock,
    CountBlock,
    LinearStage,
    ModulatorTiming,
    MonotonicClock,
    Motion,
    PatternModulator,
    PhotonCounter,
    SafeStateFailed,
    Scene,
)


@dataclass(frozen=True)
class _ToFile:
    """Puts blocks into the file first, then tells whoever looks on."""

    writer: RecordingWriter
    patterns: int
    on_block: Callable[[AlignedBlock], None] | None

    def raw(self, block: CountBlock) -> None:
        self.writer.append_raw(block)

    def placed(self, block: AlignedBlock) -> None:
        room = self.patterns - block.first_pattern
        edges = None if block.edge_time_s is None else block.edge_time_s[:room]
        self.writer.append(block.values[:room], edges)
        if self.on_block is not None:
            self.on_block(block)


class Instrument:
    """Modulator, counter and stage as one bench.

    A context manager, open from construction on. Leaving it, by any road, makes every device safe and closes it.
    """

    def __init__(
        self,
        modulator: PatternModulator,
        counter: PhotonCounter,
        stage: LinearStage,
        *,
        scene: Scene | None = None,
        clock: Clock | None = None,
        on_abort: OnAbort = "stop",
        px_per_mm: float | None = None,
        description: str = "{}",
    ) -> None:
        """Compose open devices.

        Args:
            modulator: shows the patterns.
            counter: counts their light.
            stage: moves the object.
            scene: the simulated bench that the devices stand on, for its clock and its truth.
            clock: of the devices; the scene's, or the host's, where None.
            on_abort: what the stage does when a run is broken off.
            px_per_mm: image pixels a millimetre of stage travel, where it was measured.
            description: JSON of the bench, for the recording.
        """
        if clock is None:
            clock = scene.clock if scene else MonotonicClock()
        self._devices = Devices(modulator, counter, stage, clock)
        self._scene = scene
        self._on_abort: OnAbort = on_abort
        self._px_per_mm = px_per_mm
        self._description = description
        self._closing = ExitStack()
        for device in (modulator, counter, stage):
            self._closing.push(device.__exit__)

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Open the bench that bench.toml describes.

        Raises:
            ConfigError: every mistake in the file at once.
            DeviceError: a device did not open; those opened before are closed again.
        """
        resolved = load_bench(path)
        opened = open_bench(resolved)
        devices = opened.devices
        bench = cls(
            devices.modulator,
            devices.counter,
            devices.stage,
            scene=opened.scene,
            clock=devices.clock,
            on_abort=resolved.on_abort,
            px_per_mm=resolved.px_per_mm,
            description=resolved.as_json(),
        )
        bench._closing = opened.closing
        return bench

    @property
    def devices(self) -> Devices:
        """All three, and the clock they share."""
        return self._devices

    @property
    def modulator(self) -> PatternModulator:
        """The modulator, for scripts that drive it alone."""
        return self._devices.modulator

    @property
    def counter(self) -> PhotonCounter:
        """The counter, for scripts that drive it alone."""
        return self._devices.counter

    @property
    def stage(self) -> LinearStage:
        """The stage, for scripts that move it."""
        return self._devices.stage

    def check(self, plan: Plan) -> CheckReport:
        """Ask everything that can be asked of a plan. Nothing moves and nothing is shown."""
        limits = self.modulator.limits
        return check_plan(
            plan,
            sequence=lambda: scheme_of(plan).sequence(limits.columns, limits.rows),
            modulator=limits,
            counter=self.counter.limits,
            stage=self.stage,
            px_per_mm=self._px_per_mm,
        )

    def run(
        self,
        plan: Plan,
        out: str | Path | None = None,
        *,
        overwrite: bool = False,
        on_upload: Callable[[int, int], None] | None = None,
        on_block: Callable[[AlignedBlock], None] | None = None,
    ) -> Recording:
        """Carry out a plan and give its recording, which is written to ``out`` while the run goes on.

        Args:
            plan: checked here again before anything moves.
            out: the file; None takes ``run-<date>-<time>.h5`` in the working directory.
            overwrite: replace the file if it exists.
            on_upload: told of patterns stored and patterns in all.
            on_block: told of each block after it is in the file.

        Raises:
            PlanError: the bench cannot carry out the plan; nothing has moved.
            InputError: the file exists.
            DeviceError: a device failed. What was recorded until then is kept; the error's notes name the file.
            TimingFault: likewise, for lost sync edges.
        """
        self.check(plan).raise_errors()
        path = Path(out) if out is not None else Path(f"run-{datetime.now(UTC):%Y%m%d-%H%M%S}.h5")
        refuse_existing(path, overwrite=overwrite)
        limits = self.modulator.limits
        scheme = scheme_of(plan)
        sequence = scheme.sequence(limits.columns, limits.rows)
        if self._scene is not None:
            self._scene.use_grid(sequence.grid)
        motion: Motion | None = None
        kept = "nothing was recorded"
        try:
            timing = prepare(plan, sequence, self._devices, on_upload)
            with self._writer(plan, timing, path, overwrite=overwrite) as writer:
                sink = _ToFile(writer, sequence.n_patterns, on_block)
                outcome = acquire(
                    plan,
                    timing,
                    self._devices,
                    sink,
                    patterns=sequence.n_patterns,
                    patterns_per_frame=plan.patterns_per_frame,
                )
                motion = outcome.motion
                if outcome.report.patterns_recorded:
                    recorded = outcome.report.patterns_recorded
                    kept = f"{recorded} of {sequence.n_patterns} patterns are kept in {path}"
                    self._finish(writer, outcome, timing, plan.patterns_per_frame)
                elif outcome.report.bins_received:
                    kept = (
                        f"no pattern could be told apart; {outcome.report.bins_received} raw counts are kept in {path}"
                    )
                if outcome.error is not None:
                    raise outcome.error
        except BaseException as error:
            error.add_note(kept)
            self._abort(error, motion, kept)
            raise
        return open_recording(path)

    def _writer(self, plan: Plan, timing: ModulatorTiming, path: Path, *, overwrite: bool) -> RecordingWriter:
        limits = self.counter.limits
        return RecordingWriter(
            path,
            plan,
            picture_time_s=timing.picture_time_us * 1e-6,
            bench=self._description,
            devices={
                "modulator": self.modulator.identity,
                "counter": self.counter.identity,
                "stage": self.stage.identity,
            },
            dead_time_s=limits.dead_time_s,
            dark_rate_hz=limits.dark_rate_hz,
            overwrite=overwrite,
        )

    def _finish(
        self, writer: RecordingWriter, outcome: Outcome, timing: ModulatorTiming, patterns_per_frame: int
    ) -> None:
        frames = len(outcome.frame_valid)
        middle_s = (np.arange(frames, dtype=np.float64) + 0.5) * patterns_per_frame * timing.picture_time_us * 1e-6
        writer.finish(
            frame_valid=outcome.frame_valid,
            report=outcome.report.model_dump_json(),
            truth=self._scene.truth(middle_s) if self._scene is not None else None,
            interrupted=str(outcome.error) or type(outcome.error).__name__ if outcome.error is not None else "",
        )

    def _abort(self, error: BaseException, motion: Motion | None, kept: str) -> None:
        """Make the bench safe after ``error``; what cannot be made safe is worse and is raised from it."""
        try:
            make_safe(self._devices, self._on_abort, motion)
        except SafeStateFailed as unsafe:
            unsafe.add_note(f"it came after: {error or type(error).__name__}")
            unsafe.add_note(kept)
            raise unsafe from error

    def close(self) -> None:
        """Make every device safe and close it.

        Raises:
            SafeStateFailed: names each device that could not be made safe; all were tried, and all were closed.
        """
        unsafe: SafeStateFailed | None = None
        try:
            make_safe(self._devices)
        except SafeStateFailed as failed:
            unsafe = failed
        try:
            self._closing.close()
        except Exception as error:
            if unsafe is None:
                raise
            unsafe.add_note(f"closing it failed too: {error}")
        if unsafe is not None:
            raise unsafe

    def __enter__(self) -> Self:
        """Give the open bench."""
        return self

    def __exit__(self, *exc: object) -> None:
        """Make every device safe and close it."""
        self.close()
