"""Lines to and from GRBL: one at a time, each answered by ``ok`` or an error; alarms and resets may come at any time."""

from collections.abc import Callable
from typing import Final, TypeVar

from drivers.grbl.codec import (
    SOFT_RESET,
    STATUS,
    WHO,
    Alarm,
    Event,
    Okay,
    Refused,
    Report,
    Version,
    Welcome,
    understand,
)
from drivers.grbl.codes import ERRORS, LOST, SILENT, alarm_in_words
from drivers.serial_line import Answer, LineWire
from protocols import DeviceRefused, DeviceTimeout

EventT = TypeVar("EventT")


class GrblLink:
    """Sends lines, and keeps what the controller has said about itself.

    An ``ok`` does not tell which line it answers. So after an answer that did not come, the next line waits behind a *fence*:
    ``$I``, which is answered by a line like no other; what comes before it is old.
    """

    def __init__(self, wire: LineWire) -> None:
        self.wire: Final = wire
        self.homing = False
        """Whether ``$H`` was sent and is not answered yet: the controller is mute until it is."""

        self.homed = False
        """Whether homing has ended well, and nothing came after that loses the position."""

        self.alarm = 0
        """Number of the last alarm; 0 where there was none since the last homing."""

        self.silent = False
        """Whether the controller will say nothing until it is reset: after a limit switch was hit."""

        self.greeted = False
        """Whether it has welcomed us since the port was opened: it started anew."""

        self._doubtful = True

    @property
    def trouble(self) -> str:
        """The last alarm in words; empty where there is none."""
        return alarm_in_words(self.alarm) if self.alarm else ""

    def ask(self, data: bytes, picks: Callable[[Event], EventT | None], awaited: str) -> Answer[EventT]:
        """Send a real-time byte, and wait for an answer that ``picks`` knows."""
        return self.wire.exchange(data, lambda line: picks(self._hear(line)), awaited)

    def status(self) -> Answer[Report]:
        """Ask for a status line, and once more where none comes.

        Raises:
            DeviceTimeout: no answer, twice.
        """
        try:
            return self.ask(STATUS, _report, "a status line")
        except DeviceTimeout:
            return self.ask(STATUS, _report, "a status line")

    def command(self, data: bytes, *, stops: int | None = None, limit_s: float | None = None) -> list[Event]:
        """Send a line and wait for its ``ok``; give what came before it.

        Raises:
            DeviceRefused: ``error:N``, in words.
            DeviceTimeout: no answer.
            DeviceError: a stop came after ``stops``; nothing was sent.
        """
        with self.wire.turn:
            if self._doubtful:
                self._fence()
            return self._command(data, stops, limit_s)

    def begin_home(self, data: bytes, *, stops: int) -> None:
        """Send the line that homes; its ``ok`` comes when homing is over."""
        with self.wire.turn:
            self.pump()
            if self._doubtful:
                self._fence()
            self.homed, self.alarm = False, 0
            self.homing = True  # before the bytes leave, so that a stop knows which stop it must be
            try:
                self.wire.put(data, unless_stopped_since=stops)
            except BaseException:
                self.homing = False
                raise

    def pump(self) -> None:
        """Take in what has come by itself."""
        for line in self.wire.lines():
            event = self._hear(line)
            if self.homing and isinstance(event, Okay | Refused):
                self.homing, self.homed = False, isinstance(event, Okay)

    def reset(self) -> None:
        """Reset a controller that is silent after an alarm, and wait until it has started again, locked.

        Raises:
            DeviceTimeout: it does not come back.
        """
        self.ask(SOFT_RESET, _started, "the controller's welcome")

    def version(self, boot_s: float) -> str:
        """Ask who is there until somebody answers.

        Raises:
            DeviceTimeout: nobody did in ``boot_s``.
        """
        until_s = self.wire.clock.now_s() + boot_s
        while True:
            try:
                return self._fence()
            except DeviceTimeout:
                if self.wire.clock.now_s() >= until_s:
                    raise

    def _hear(self, line: bytes) -> Event:
        event = understand(line)
        if isinstance(event, Alarm):
            self.alarm, self.homing = event.code, False
            self.homed = self.homed and event.code not in LOST
            self.silent = event.code in SILENT
        elif isinstance(event, Welcome):
            self.homing = self.homed = self.silent = False
            self.greeted = True
        return event

    def _fence(self) -> str:
        """Drop what is old: everything until the answer to ``$I``. Gives the version.

        Where ``$I`` is refused, the refusal cannot be told from an old one, and the wait ends by its time.
        """
        version = self.wire.exchange(WHO, lambda line: _version(self._hear(line)), "the version").value
        self.wire.exchange(b"", lambda line: _ended(self._hear(line)), "the ok after the version")
        self._doubtful = False
        return version

    def _command(self, data: bytes, stops: int | None, limit_s: float | None) -> list[Event]:
        heard: list[Event] = []

        def ends(line: bytes) -> Event | None:
            event = self._hear(line)
            if isinstance(event, Okay | Refused):
                return event
            heard.append(event)
            return None

        try:
            end = self.wire.exchange(data, ends, "ok", unless_stopped_since=stops, limit_s=limit_s).value
        except DeviceTimeout:
            self._doubtful = True
            raise
        if isinstance(end, Refused):
            meaning, remedy = ERRORS.get(
                end.code, ("an error that is not of stages", "look it up in GRBL's error list")
            )
            also = f"; {self.trouble}" if self.trouble else ""
            raise DeviceRefused(
                self.wire.device,
                code=f"error:{end.code}",
                saw=f"{data!r} refused: {meaning}{also}",
                expected="ok",
                remedy=remedy,
            )
        return heard


def _report(event: Event) -> Report | None:
    return event if isinstance(event, Report) else None


def _version(event: Event) -> str | None:
    return event.text if isinstance(event, Version) else None


def _ended(event: Event) -> bool | None:
    return True if isinstance(event, Okay) else None


def _started(event: Event) -> bool | None:
    return True if isinstance(event, Welcome) else None
