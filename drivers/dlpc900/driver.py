"""The modulator as the framework sees it: ``protocols.PatternModulator`` on a DLPC900 in pattern-on-the-fly mode."""

from typing import Final, Self

from drivers.dlpc900.board import Board
from drivers.dlpc900.constants import LONGEST_US, PATTERNS, PATTERNS_PER_IMAGE, TRIGGER_WIDTH_US
from drivers.dlpc900.encoding import image
from drivers.dlpc900.link import Link
from drivers.dlpc900.settings import Dlpc900Settings
from drivers.dlpc900.transport import HidApi, HidReports
from protocols import (
    BenchContext,
    DeviceError,
    DeviceIdentity,
    DeviceTimeout,
    InputError,
    ModulatorLimits,
    ModulatorTiming,
    PatternSequence,
    PlanError,
    UploadProgress,
    WrongState,
)

_NAME: Final = "dmd"
_POLL_S: Final = 0.01


def open_link(settings: Dlpc900Settings, context: BenchContext) -> Link:
    """Open the device, and ask nothing.

    Raises:
        InputError, DriverUnavailable: as ``Dlpc900``.
    """
    reports = context.transport
    if reports is None:
        reports = HidApi(settings.serial_number, _NAME)
    elif not isinstance(reports, HidReports):
        raise InputError(
            device=_NAME,
            saw=f"a transport of type {type(reports).__name__}",
            expected="an open HID device",
            remedy="choose a transport for the DLPC900 in bench.toml",
        )
    return Link(reports, context.clock, _NAME, settings.reply_s)


class Dlpc900:
    """A LightCrafter 6500 or 9000.

    ``context.transport``, where given, is an open ``HidReports``.

    Raises:
        InputError: a transport that is none.
        DriverUnavailable: no hidapi, no board, or mirrors that the driver does not know.
        DeviceError: the board says that it is not well.
    """

    def __init__(self, settings: Dlpc900Settings, context: BenchContext) -> None:
        self._settings, self._clock = settings, context.clock
        link = open_link(settings, context)
        try:
            self._board = Board(link, _NAME)
            self._board.stop()
        except BaseException:
            link.close()
            raise
        mirrors = self._board.mirrors
        self._identity = DeviceIdentity(
            name=_NAME,
            vendor="Texas Instruments",
            model=f"DLPC900 with {mirrors.name}",
            firmware=self._board.firmware,
            driver="dlpc900 (HID)",
            simulated=context.transport is not None,
        )
        self._limits = ModulatorLimits(
            columns=mirrors.columns,
            rows=mirrors.rows,
            shortest_picture_time_us=mirrors.shortest_us,
            longest_picture_time_us=LONGEST_US,
            unique_patterns=PATTERNS,
            play_order_entries=PATTERNS,
            longest_upload_s=mirrors.columns * mirrors.rows / 8 / settings.upload_bytes_per_s,
        )
        self._loaded: tuple[int, ModulatorTiming] | None = None
        self._started_s: float | None = None
        self._closed = False

    @property
    def identity(self) -> DeviceIdentity:
        """Identity of the board and of its mirror array."""
        return self._identity

    @property
    def limits(self) -> ModulatorLimits:
        """Mirrors, exposure, memory, and the longest time that a pattern takes to be stored."""
        return self._limits

    def load(
        self, sequence: PatternSequence, timing: ModulatorTiming, progress: UploadProgress | None = None
    ) -> ModulatorTiming:
        """Store each unique pattern once, 24 in an image, the last image first; see ``PatternModulator.load``.

        Raises:
            PatternMemoryFull, PictureTimeTooShort, PlanError: as the protocol says; nothing was sent.
            DeviceRefused: the board does not take a definition or an image; names its error.
        """
        self._refuse(closed=True, playing=True)
        self._loaded = None
        self._limits.check_sequence(sequence, _NAME)
        self._limits.check_timing(timing, _NAME)
        delay_us, width_us = timing.sync_delay_us, max(timing.sync_width_us, TRIGGER_WIDTH_US)
        if delay_us > TRIGGER_WIDTH_US:
            raise PlanError(
                device=_NAME,
                saw=f"a sync edge {delay_us} us before its picture",
                expected=f"at most {TRIGGER_WIDTH_US} us",
                remedy="lower sync_delay_us in plan.toml",
            )
        self._board.begin(sequence.play_order.tolist(), timing.picture_time_us)
        self._upload(sequence, progress)
        rising_us, falling_us = self._board.finish(len(sequence.play_order), delay_us, width_us)
        kept = ModulatorTiming(
            picture_time_us=timing.picture_time_us, sync_delay_us=-rising_us, sync_width_us=falling_us - rising_us
        )
        self._loaded = len(sequence.play_order), kept
        self._started_s = None
        return kept

    def start(self) -> None:
        """Play the order once, from the first picture, and return at once.

        Raises:
            WrongState: nothing is loaded, or the last run still plays.
        """
        self._refuse(closed=True, playing=True)
        if self._loaded is None:
            raise self._wrong("a start with nothing loaded", "a loaded sequence", "load one first")
        self._board.stop()  # so that it begins with the first picture
        self._board.start()
        self._started_s = self._clock.now_s()

    @property
    def running(self) -> bool:
        """Whether pictures are being played now, by the board's own word."""
        return not self._closed and self._board.running

    def wait(self, timeout_s: float) -> None:
        """Return when the last picture has been shown.

        Raises:
            DeviceTimeout: still playing after ``timeout_s``; how far is reckoned, for the board does not tell.
            DeviceError: the board says that its sequencer broke off.
            WrongState: never started.
        """
        if self._started_s is None or self._loaded is None:
            raise self._wrong("a wait for a run that never started", "a started run", "start it")
        pictures, timing = self._loaded
        deadline_s = self._clock.now_s() + timeout_s
        while self.running:
            now_s = self._clock.now_s()
            if now_s >= deadline_s:
                shown = min(pictures, round((now_s - self._started_s) * 1e6 / timing.picture_time_us))
                raise DeviceTimeout(
                    _NAME,
                    awaited="the end of the play order",
                    waited_s=timeout_s,
                    progress=f"some {shown} of {pictures} pictures shown, by the time since the start, still playing",
                    remedy="halt the modulator, and allow at least picture time times pictures",
                )
            self._clock.sleep_s(min(_POLL_S, deadline_s - now_s))
        self._board.check_health()

    def halt(self) -> None:
        """Stop at once."""
        if not self._closed:
            self._board.stop()

    def __enter__(self) -> Self:
        """Give the open device."""
        return self

    def __exit__(self, *exc: object) -> None:
        """Stop, and let go of the device, even if stopping fails."""
        if self._closed:
            return
        try:
            self.halt()
        finally:
            self._closed, self._loaded = True, None
            self._board.link.close()

    def _upload(self, sequence: PatternSequence, progress: UploadProgress | None) -> None:
        total, halves = len(sequence.planes), self._board.mirrors.controllers
        stored = told = 0
        for first in reversed(range(0, total, PATTERNS_PER_IMAGE)):
            planes = [sequence.mirror_plane(k) for k in range(first, min(first + PATTERNS_PER_IMAGE, total))]
            width = planes[0].shape[1] // halves
            for half in range(halves):
                columns = slice(half * width, (half + 1) * width)
                data = image([plane[:, columns] for plane in planes], self._settings.colour_order)
                for sent in self._board.load(first // PATTERNS_PER_IMAGE, half, data):
                    now = stored + int(len(planes) * (half + sent) / halves)
                    if progress is not None and now > told:
                        progress(now, total)
                        told = now
            stored += len(planes)

    def _refuse(self, *, closed: bool, playing: bool) -> None:
        if closed and self._closed:
            raise self._wrong("a call after the device was closed", "an open device", "open it anew")
        if playing and self._started_s is not None and self.running:
            raise self._wrong("a run that still plays", "a modulator that is idle", "wait for it, or halt it")

    def _wrong(self, saw: str, expected: str, remedy: str) -> DeviceError:
        return WrongState(device=_NAME, saw=saw, expected=expected, remedy=remedy)
