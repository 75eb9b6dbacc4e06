"""The DLP7000 as a ``PatternModulator``: preloaded one-bit pictures, played without a dark phase under the board's own clock."""

from collections.abc import Callable
from threading import RLock
from typing import Final, Self

from drivers.alp.api import AlpApi
from drivers.alp.board import AlpBoard
from drivers.alp.checks import check_plan, check_settings
from drivers.alp.constants import (
    DeviceControl,
    DmdMode,
    ProjectionControl,
    ProjectionMode,
    SynchPolarity,
)
from drivers.alp.inspection import inspect
from drivers.alp.release import release
from drivers.alp.run import Run, ended_early, timed_out
from drivers.alp.settings import Dlp7000Settings
from drivers.alp.store import Loaded, store
from drivers.alp.upload import plan_upload
from protocols.clock import Clock
from protocols.errors import DeviceError, DeviceRefused, KinopixError, WrongState
from protocols.modulator import ModulatorLimits, ModulatorTiming, PatternSequence, UploadProgress
from protocols.values import DeviceIdentity

POLL_S: Final = 0.02
"""Longest time between two questions whether a run is over."""

ROUNDING_S: Final = 1e-6
"""Less than this before a deadline there is nothing left to sleep."""


class Dlp7000:
    """A DLP7000 on an ALP-4 board (``protocols.PatternModulator``).

    Plans that cannot be played are refused before the board is touched, and what was loaded stays. Once an upload has
    begun, an earlier sequence is gone; if the upload fails, nothing is loaded.
    """

    def __init__(
        self,
        api: AlpApi,
        settings: Dlp7000Settings,
        clock: Clock,
        *,
        library: str,
        name: str = "dmd",
        simulated: bool = False,
    ) -> None:
        """Take the board, check it, and read its limits.

        Args:
            api: the library, or what stands in for it.
            settings: keys of bench.toml.
            clock: for every wait.
            library: release and path of the library, for the identity.
            name: what errors call the device.
            simulated: whether no hardware stands behind ``api``.

        Raises:
            InputError: ``trigger = "slave"``.
            DriverUnavailable: no board, no mirrors, or an unfit library.
            DeviceBusy: another program has the board.
            DeviceError: any other refusal of the board; it is let go of again.
        """
        check_settings(settings, name)
        self._settings, self._clock, self._name = settings, clock, name
        self._lock = RLock()
        self._loaded: Loaded | None = None
        self._run: Run | None = None
        self._uploading = self._floating = self._closed = False
        self._halts = 0
        self._board = AlpBoard(api, settings.device_number, name, clock)
        try:
            self._inspection = inspect(self._board, settings)
            level = SynchPolarity.LEVEL_HIGH if settings.sync_polarity == "high" else SynchPolarity.LEVEL_LOW
            self._board.control(DeviceControl.SYNCH_POLARITY, level)
            self._board.control_projection(ProjectionControl.PROJ_MODE, ProjectionMode.MASTER)
            self._wake_mirrors()
        except BaseException as error:
            release([self._board.halt, self._board.free], error)
            raise
        self._identity = DeviceIdentity(
            name=name,
            vendor="ViALUX / Texas Instruments",
            model="DLP7000",
            serial=str(self._inspection.serial),
            driver=f"dlp7000 on {library}, ALP_VERSION {self._inspection.version:#06x}",
            simulated=simulated,
        )

    @property
    def identity(self) -> DeviceIdentity:
        """Identity of the board, and the library under it."""
        return self._identity

    @property
    def limits(self) -> ModulatorLimits:
        """Limits as the board told them when it was opened. The play order is that of few patterns: many need more room."""
        return self._inspection.limits

    @property
    def running(self) -> bool:
        """Whether the board plays pictures now. False, without asking, while nothing was started."""
        with self._lock:
            return not self._closed and self._run is not None and not self._run.halted and self._board.playing()

    def load(
        self, sequence: PatternSequence, timing: ModulatorTiming, progress: UploadProgress | None = None
    ) -> ModulatorTiming:
        """Store the patterns and return the timing as the board tells it.

        Raises:
            PatternMemoryFull: the patterns, or their order, do not fit.
            PictureTimeTooShort: shorter than the board's own limit.
            PlanError: another geometry, or times that the board does not have.
            WrongState: a run still plays, another upload is under way, or a halt stopped this one.
            DeviceError: the board refused or is gone; nothing is loaded then.
        """
        found = self._inspection
        check_plan(sequence, timing, found, self._name)
        upload = plan_upload(
            sequence,
            memory=found.limits.unique_patterns,
            table_entries9=found.table_entries9,
            flut=self._settings.flut,
            device=self._name,
        )
        with self._lock:
            self._require_idle("load")
            self._uploading, halts = True, self._halts
        try:
            self._forget()
            self._loaded = store(
                self._board,
                sequence,
                upload,
                timing,
                settings=self._settings,
                go_on=lambda: self._require_no_halt_since(halts),
                progress=progress,
            )
        finally:
            self._uploading = False
        return self._loaded.timing

    def start(self) -> None:
        """Play the order once, from the first picture, and return at once.

        Raises:
            WrongState: nothing is loaded, an upload is under way, or the last run still plays.
            DeviceError: the board refused; it is halted then.
        """
        with self._lock:
            self._require_idle("start")
            if self._loaded is None:
                raise self._wrong("no patterns in the board", "a loaded sequence", "call load first")
            try:
                if self._floating:
                    self._board.control(DeviceControl.DMD_MODE, DmdMode.RESUME)
                    self._floating = False
                run = Run(self._loaded.pictures, self._loaded.timing.picture_time_us / 1e6, self._clock.now_s())
                self._board.start(self._loaded.handle)
            except BaseException as error:
                release([self._board.halt], error)
                raise
            self._run = run

    def wait(self, timeout_s: float) -> None:
        """Return when the last picture has been shown.

        Raises:
            DeviceTimeout: still playing after ``timeout_s``; tells how many pictures were shown.
            WrongState: never started, or halted before its end.
            DeviceError: the board stopped by itself, or is gone.
        """
        run = self._run
        if run is None:
            raise self._wrong("no run to wait for", "a started run", "call start first")
        deadline_s = self._clock.now_s() + timeout_s
        while True:
            # Sleep first: whether the state reads "active" at the very moment after the start is not known.
            now_s = self._clock.now_s()
            rest_s = max(run.end_s - now_s, POLL_S / 20)
            self._clock.sleep_s(max(0.0, min(POLL_S, rest_s, deadline_s - now_s)))
            with self._lock:
                if run.halted or self._closed:
                    raise self._wrong("a run that was halted", "a run played to its end", "start again")
                playing = self._board.playing()
            now_s = self._clock.now_s()
            if not playing and now_s >= run.earliest_end_s:
                return
            if not playing:
                raise ended_early(run, now_s, self._name)
            if now_s >= deadline_s - ROUNDING_S:
                raise timed_out(run, timeout_s, self._board)

    def halt(self) -> None:
        """Stop display and upload at once, from any thread. In mid-run the mirrors then go flat (``after_halt``).

        Raises:
            DeviceError: the board did not obey.
        """
        with self._lock:
            if self._closed:
                return
            self._halts += 1
            run = self._run
            cut = run is not None and not run.halted and self._maybe_playing()
            self._board.halt()
            if run is not None and cut:
                run.halted = True
                self._darken()

    def close(self, because: BaseException | None = None) -> None:
        """Halt, free the memory and let go of the board, each even if another fails. Twice does no harm.

        Args:
            because: the error that is under way, if any; what fails here is then added to it as a note.

        Raises:
            DeviceError: something failed, and no other error was under way.
        """
        with self._lock:
            if self._closed:
                return
            steps: list[Callable[[], object]] = [self.halt, self._forget, self._board.free]
            try:
                release(steps, because)
            finally:
                self._closed = True

    def __enter__(self) -> Self:
        """Give the open device."""
        return self

    def __exit__(self, *exc: object) -> None:
        """Close; an error that is leaving the block stays the one that is seen."""
        self.close(next((item for item in exc if isinstance(item, BaseException)), None))

    def _forget(self) -> None:
        loaded, self._loaded, self._run = self._loaded, None, None
        if loaded is not None:
            self._board.free_sequence(loaded.handle)

    def _wake_mirrors(self) -> None:
        """Undo the parking of an earlier owner, and find out now, not in mid-run, whether this board can park."""
        if self._settings.after_halt != "float":
            return
        try:
            self._board.control(DeviceControl.DMD_MODE, DmdMode.RESUME)
        except DeviceRefused as error:
            raise DeviceError(
                device=self._name,
                saw=f"a board that cannot park and wake its mirrors ({error.saw}, code {error.code})",
                expected="ALP_OK",
                remedy='set after_halt = "hold" under [modulator] in bench.toml, or power-cycle the board',
            ) from error

    def _darken(self) -> None:
        if self._settings.after_halt == "float":
            self._board.control(DeviceControl.DMD_MODE, DmdMode.POWER_FLOAT)
            self._floating = True

    def _maybe_playing(self) -> bool:
        try:
            return self._board.playing()
        except KinopixError:
            return True  # a board that does not answer may well play; the halt that follows raises its error

    def _require_idle(self, call: str) -> None:
        if self._closed:
            raise self._wrong(f"{call} on a closed device", "an open device", "open the device again")
        if self._uploading:
            raise self._wrong(f"{call} during an upload", "an idle device", "wait for load to return, or halt")
        if self.running:
            raise self._wrong(f"{call} while the last run still plays", "an idle device", "call wait or halt first")

    def _require_no_halt_since(self, halts: int) -> None:
        if self._closed or self._halts != halts:
            raise self._wrong("a halt during the upload", "an upload left alone", "load the patterns again")

    def _wrong(self, saw: str, expected: str, remedy: str) -> WrongState:
        return WrongState(device=self._name, saw=saw, expected=expected, remedy=remedy)
