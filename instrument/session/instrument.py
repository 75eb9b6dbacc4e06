"""The bench as one thing: composes the devices, runs plans, keeps everything safe."""

from collections.abc import Collection, Sequence
from pathlib import Path
from threading import Lock
from types import TracebackType
from typing import Self

from instrument.acquisition import CheckReport, Devices, check_plan
from instrument.config import BenchConfig, Calibration, OnAbort, load_bench
from instrument.plan import Plan, refuse_no_plan
from instrument.recording import Recording
from instrument.roles import STAGE, RoleName
from instrument.schemes import scheme_of
from instrument.session.channel import Listener
from instrument.session.holding import hold
from instrument.session.naming import next_name
from instrument.session.opening import open_devices
from instrument.session.run import Run
from instrument.session.safety import make_safe
from instrument.session.work import Job
from instrument.shown import card, line
from instrument.storage import refuse_existing, refuse_full_disk
from protocols import Bytes, InputError, LinearStage, PatternModulator, PhotonCounter, SafeStateFailed, WrongState
from protocols.plain_file import path_of


class Instrument:
    """Modulator, counter and stage as one bench.

    A context manager, open from construction on. Leaving it, by any road, ends a run that goes on, makes every device safe and
    closes it.
    """

    def __init__(
        self,
        devices: Devices,
        *,
        on_abort: OnAbort = "stop",
        calibration: Calibration | None = None,
        magnification: str = "",
        description: str = "{}",
    ) -> None:
        """Take over open devices; ``Devices.of`` composes those that a script has opened itself.

        Args:
            devices: by role.
            on_abort: what the stage does when a run is broken off.
            calibration: what was measured of this bench.
            magnification: name of the optics between object and modulator, as the calibration should have it.
            description: JSON of the bench, for the recording.

        Raises:
            InputError: no open devices, or a calibration of another bench. The devices stay open.
        """
        if not isinstance(devices, Devices):  # pyright: ignore[reportUnnecessaryIsInstance] - a script may pass anything
            raise InputError(
                saw=f"a {type(devices).__name__}",
                expected="open devices",
                remedy="open a bench with Instrument.from_toml(path), or compose devices with Devices.of",
            )
        self._devices = devices
        self._on_abort: OnAbort = on_abort
        if calibration is not None:
            calibration.refuse_other_bench(devices.identities(), magnification)
        self._calibration = calibration
        self._magnification = magnification
        self._description = description
        self._run: Run | None = None
        self._starting = Lock()

    @classmethod
    def from_toml(cls, path: str | Path, *, only: Collection[RoleName] | None = None) -> Self:
        """Open the bench that bench.toml describes.

        Args:
            path: the file.
            only: roles whose devices are opened, such as ``{"stage"}``; the file needs no others, and no calibration is
                read. None opens the whole bench.

        Raises:
            ConfigError: every mistake in the file at once, or in the calibration file that it names.
            InputError: that calibration is of another bench; every device is closed again.
            DeviceError: a device did not open; those opened before are closed again.
        """
        return cls.from_config(
            load_bench(path) if only is None else load_bench(path, only, calibrated=False), only=only
        )

    @classmethod
    def from_config(cls, config: BenchConfig, *, only: Collection[RoleName] | None = None) -> Self:
        """Open a bench that has been checked, or ``only`` the devices in some of its roles.

        Raises:
            InputError: the calibration is of another bench; every device is closed again.
            DeviceError: a device did not open; those opened before are closed again.
        """
        devices = open_devices(config, only)
        try:
            return cls(
                devices,
                on_abort=config.on_abort,
                calibration=config.calibration,
                magnification=config.magnification,
                description=config.as_json(),
            )
        except BaseException:
            devices.closing.close()
            raise

    def __repr__(self) -> str:
        """Say in one line which devices it has, and what it is about. No device is asked more than who it is."""
        return line("Instrument", *self._facts().values())

    def _repr_html_(self) -> str:
        """Show the same in a notebook."""
        return card("Instrument", self._facts())

    def _facts(self) -> dict[str, str]:
        facts: dict[str, str] = {
            role: " ".join(part for part in (identity.vendor, identity.model, identity.serial) if part)
            for role, identity in self._devices.identities().items()
        }
        if self.px_per_mm is not None:
            facts["calibration"] = f"{self.px_per_mm:.4g} px/mm"
        facts["state"] = "at rest" if self._run is None or self._run.done else self._run.state
        return facts

    @property
    def devices(self) -> Devices:
        """All devices by role, and the clock they share."""
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

    @property
    def calibration(self) -> Calibration | None:
        """What was measured of this bench; None where nothing was."""
        return self._calibration

    @property
    def px_per_mm(self) -> float | None:
        """Image pixels a millimetre of the stage, by the calibration; None where there is none."""
        known = None if self._calibration is None else self._calibration.displacement
        return None if known is None else known.px_per_mm

    @property
    def axis_angle_deg(self) -> float | None:
        """Direction of positive travel in the image, from x (right) towards y (down), by the calibration; None likewise."""
        known = None if self._calibration is None else self._calibration.displacement
        return None if known is None else known.axis_angle_deg

    @property
    def magnification(self) -> str:
        """Name of the optics between object and modulator; empty where bench.toml has none."""
        return self._magnification

    def check(self, plan: Plan) -> CheckReport:
        """Ask everything that can be asked of a plan. Nothing moves and nothing is shown.

        Raises:
            InputError: ``plan`` is no plan.
        """
        refuse_no_plan(plan)
        limits = self.modulator.limits
        return check_plan(
            plan,
            sequence=lambda: scheme_of(plan).sequence(limits.columns, limits.rows),
            modulator=limits,
            counter=self.counter.limits,
            stage=self.stage if STAGE.name in self._devices.by_role else None,
            calibration=self._calibration,
            scene=self._devices.scene,
        )

    def start(
        self,
        plan: Plan,
        out: str | Path | None = None,
        *,
        overwrite: bool = False,
        listeners: Sequence[Listener] = (),
    ) -> Run:
        """Check a plan, begin to carry it out, and return at once with a handle on the run.

        Args:
            plan: checked before anything moves.
            out: the file; None takes ``run-<date>-<time>.h5`` in the working directory.
            overwrite: replace the file if it exists.
            listeners: told of every event, each on a thread of its own.

        Raises:
            PlanError: the bench cannot carry out the plan; nothing has moved.
            InputError: the file exists, or has no room.
            WrongState: a run goes on.
        """
        with self._starting:
            if self._run is not None and not self._run.done:
                raise WrongState(
                    saw=f"a second run while one is {self._run.state}",
                    expected="one run at a time",
                    remedy="wait for the end of the first, or abort it",
                )
            _refuse_deaf(listeners)
            sequence = self.check(plan).passed()
            path = path_of(out) if out is not None else next_name(Path())
            refuse_existing(path, overwrite=overwrite)
            refuse_full_disk(path, plan.patterns)
            detector = None if self._calibration is None else self._calibration.detector
            job = Job(plan, sequence, self._devices, path, overwrite, self._on_abort, self._description, detector)
            self._run = Run(job, tuple(listeners))  # known before it begins: an interrupt here finds it
            self._run.begin()
            return self._run

    def run(
        self,
        plan: Plan,
        out: str | Path | None = None,
        *,
        overwrite: bool = False,
        listeners: Sequence[Listener] = (),
    ) -> Recording:
        """Carry out a plan and give its recording, which is written to ``out`` while the run goes on.

        As ``start``, and a wait for the end. An interrupt (Ctrl-C) aborts the run: the bench is safe and the file is closed when
        ``KeyboardInterrupt`` is raised. Listeners have a second after the end to take what is left.

        Raises:
            PlanError: the bench cannot carry out the plan; nothing has moved.
            InputError: the file exists, or has no room.
            WrongState: a run goes on.
            DeviceError: a device failed. What was recorded until then is kept; the error's notes name the file.
            TimingFault: likewise, for lost sync edges.
            RunAborted: likewise, where another thread aborted it.
        """
        with self.start(plan, out, overwrite=overwrite, listeners=listeners) as run:
            return run.wait()

    def show(
        self, picture: str | Bytes, seconds: float | None = None, *, image_size: int = 128, superpixel: int = 2
    ) -> None:
        """Hold one picture on the modulator, as ``hold`` does, and nothing when this returns. Nothing is counted or moved.

        Raises:
            InputError: no such picture, or it does not fit on the mirrors.
            DeviceError: the modulator failed.
        """
        hold(self.modulator, self._devices.clock, picture, seconds, image_size=image_size, superpixel=superpixel)

    def close(self) -> None:
        """End a run that goes on, make every device safe and close it.

        Raises:
            SafeStateFailed: names each device that could not be made safe; all were tried, and all were closed.
        """
        if self._run is not None and not self._run.done:
            self._run.settle("the bench was closed")
        unsafe: SafeStateFailed | None = None
        try:
            make_safe(self._devices)
        except SafeStateFailed as failed:
            unsafe = failed
        try:
            self._devices.closing.close()
        except Exception as error:
            if unsafe is None:
                raise
            unsafe.add_note(f"closing it failed too: {error}")
        if unsafe is not None:
            raise unsafe

    def __enter__(self) -> Self:
        """Give the open bench."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End a run that goes on, make every device safe and close it. An interrupt is told what is kept, and that it is safe."""
        run = self._run
        cut_short = run is not None and not run.done
        self.close()
        if error is not None and run is not None and cut_short:
            error.add_note(run.settle("the bench was closed"))
        if isinstance(error, KeyboardInterrupt):
            error.add_note("the bench is safe")


def _refuse_deaf(listeners: Sequence[Listener]) -> None:
    """Make sure before a run that everybody who is to be told of it can be told.

    Raises:
        InputError: one of them can neither be called nor follow.
    """
    for listener in listeners:
        if not (callable(listener) or hasattr(listener, "follow")):
            raise InputError(
                saw=f"a listener of type {type(listener).__name__}",
                expected="functions that take an event, or followers",
                remedy="pass a list of them: listeners=[print]",
            )
