"""The board: reports, commands, modes, memory, sequencer (sheet, sections 2, 3, 8)."""

import struct
import threading
from collections import Counter, deque
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from protocols import Bytes
from sim_backends.bench import OpticalBench, Projection
from sim_backends.wire.dlpc900.picture import BadImage, Picture, decode
from sim_backends.wire.dlpc900.settings import (
    Abort,
    Dlpc900EmulatorSettings,
    Error,
    LostReply,
    LostReport,
    Unplugged,
    WrongEcho,
)
from sim_backends.wire.dlpc900.table import Definition, define

_REPORT = 64
_BUFFER = 512
_KINDS = {"DLP6500": 1, "DLP9000": 2, "DLP670S": 3}
_MIRRORS = {"DLP6500": (1920, 1080), "DLP9000": (2560, 1600), "DLP670S": (2716, 1600)}
_SHORTEST_US = 105
_ENTRIES = 400
_TEXTS = {5: "command not allowed in the current mode", 6: "invalid command parameter", 14: "exposure out of range"}
_PATTERN_MODES = frozenset({1, 2, 3})


@dataclass
class _Upload:
    """An image on its way to one controller."""

    number: int
    size: int
    data: bytearray = field(default_factory=bytearray)


class EmulatedDlpc900:
    """An open HID device: ``write`` and ``read`` of 64-byte reports. Each report lets ``report_s`` of the bench's time pass."""

    def __init__(self, settings: Dlpc900EmulatorSettings, bench: OpticalBench) -> None:
        """Switch it on."""
        self._settings, self._bench = settings, bench
        self._lock = threading.RLock()
        self._columns, self._rows = _MIRRORS[settings.model]
        self._halves = 2 if settings.model == "DLP9000" else 1
        self._mode: int = settings.power_up_mode
        self._error = 0
        self._reports: deque[bytes] = deque()
        self._typed = b""
        self._written = 0
        self._seen: Counter[int] = Counter()
        self._gone = False
        self._definitions: dict[int, Definition] = {}
        self._playable: tuple[Definition, ...] = ()
        self._repeats = 1
        self._images: dict[tuple[int, int], Picture] = {}
        self._uploads: dict[int, _Upload] = {}
        self._trigger = struct.pack("<Bhh", 0, 0, 20)
        self._ends_s = 0.0
        self._aborts_s: float | None = None

    # Reports

    def write(self, report: bytes) -> None:
        """Take a report of the host.

        Raises:
            OSError: it is unplugged.
        """
        with self._lock:
            self._written += 1
            for fault in self._settings.faults:
                if isinstance(fault, Unplugged) and self._written >= fault.nth and not self._gone:
                    self._gone = True
                    self._bench.dark()
            self._alive()
            self._pass(self._settings.report_s)
            if any(isinstance(fault, LostReport) and self._written == fault.nth for fault in self._settings.faults):
                return
            self._typed += report[:_REPORT]
            (length,) = struct.unpack("<H", self._typed[2:4])
            if len(self._typed) < 4 + length:
                return
            packet, self._typed = self._typed[: 4 + length], b""
            self._packet(packet)

    def read(self, timeout_s: float) -> bytes:
        """Give the next report, or nothing when the time is over.

        Raises:
            OSError: it is unplugged.
        """
        with self._lock:
            self._alive()
            if not self._reports:
                self._pass(timeout_s)
                return b""
            self._pass(self._settings.report_s)
            return self._reports.popleft()

    def close(self) -> None:
        """The device stays as it is."""

    def _pass(self, duration_s: float) -> None:
        clock = self._bench.clock
        clock.advance_to(clock.now_s() + duration_s)

    def _alive(self) -> None:
        if self._gone:
            raise OSError("read error: no such device")

    def _packet(self, packet: bytes) -> None:
        flags, sequence, length, command = struct.unpack("<BBHH", packet[:6])
        data = packet[6:]
        self._seen[command] += 1
        struck = [
            fault
            for fault in self._settings.faults
            if isinstance(fault, Error | LostReply | WrongEcho)
            and (fault.command, fault.nth) == (command, self._seen[command])
        ]
        refused = [fault.code for fault in struck if isinstance(fault, Error)]
        if length > _BUFFER - 4:
            answer: bytes | int = 6
        elif refused:
            answer = refused[0]
        else:
            answer = self._ask(command) if flags & 0x80 else self._set(command, data)
        if isinstance(answer, int):
            if answer or command != 0x0100:
                self._error = answer
            answer, failed = b"", bool(answer)
        else:
            failed = False
        if flags & 0xC0 and not any(isinstance(fault, LostReply) for fault in struck):
            echo = sequence ^ any(isinstance(fault, WrongEcho) for fault in struck)
            reply = struct.pack("<BBH", flags | (0x20 if failed else 0), echo, len(answer)) + answer
            reply += bytes(-len(reply) % _REPORT)
            self._reports = deque(reply[at : at + _REPORT] for at in range(0, len(reply), _REPORT))

    # Questions

    def _ask(self, command: int) -> bytes | int:
        """Give the answer, or the number of an error."""
        settings, now_s = self._settings, self._bench.clock.now_s()
        if command == 0x0100:
            error, self._error = self._error, 0
            return bytes([error])
        if command == 0x0101:
            return _TEXTS.get(self._error, "").encode().ljust(128, b"\0")
        if command == 0x0205:
            major, minor, patch = map(int, settings.firmware.split("."))
            return struct.pack("<4I", *[major << 24 | minor << 16 | patch] * 4)
        if command == 0x0206:
            return bytes([_KINDS[settings.model]]) + settings.model.encode().ljust(31, b"\0")
        if command == 0x1A0A:
            aborted = self._aborts_s is not None and now_s >= self._aborts_s
            second = self._halves == 2 and settings.second_controller
            return bytes([settings.initialized | second << 4 | aborted << 6])
        if command == 0x1A0B:
            return bytes([settings.memory_good])
        if command == 0x1A0C:
            return bytes([self._running << 1])
        if command == 0x1A1B:
            return bytes([self._mode])
        return self._trigger if command == 0x1A1E else 3

    @property
    def _running(self) -> bool:
        return self._bench.clock.now_s() < self._ends_s

    # Settings

    def _set(self, command: int, data: bytes) -> int:
        """Carry out a command; give the number of its error, 0 for none."""
        if command == 0x1A1B:
            return self._change_mode(data)
        if command in {0x1A2A, 0x1A2C, 0x1A2B, 0x1A2D}:
            if self._mode != 3:
                return 5
            controller = command >= 0x1A2C
            return self._begin(controller, data) if command in {0x1A2A, 0x1A2C} else self._take(controller, data)
        if command not in {0x1A24, 0x1A1E, 0x1A31, 0x1A34}:
            return 3
        if self._mode not in _PATTERN_MODES:
            return 5
        if command == 0x1A24:
            return self._sequence(data)
        if self._running and command != 0x1A34:
            return 5
        if command == 0x1A1E:
            return self._set_trigger(data)
        if command == 0x1A31:
            return self._configure(data)
        defined = define(data, _SHORTEST_US)
        if isinstance(defined, int):
            return defined
        self._definitions[defined[0]] = defined[1]
        self._playable = ()
        return 0

    def _change_mode(self, data: bytes) -> int:
        if len(data) != 1 or data[0] > 3:
            return 6
        if self._running:
            return 5
        if data[0] != self._mode:
            self._images.clear()
            self._definitions.clear()
            self._playable = ()
        self._mode = data[0]
        return 0

    def _set_trigger(self, data: bytes) -> int:
        if len(data) != 5:
            return 6
        inverted, rising, falling = struct.unpack("<Bhh", data)
        in_order = rising > falling if inverted & 1 else rising < falling
        if not (in_order and min(rising, falling) >= -20 and max(rising, falling) <= 20_000):
            return 13
        self._trigger = data
        return 0

    def _begin(self, controller: bool, data: bytes) -> int:  # noqa: FBT001
        if len(data) != 6 or controller >= self._halves:
            return 6
        number, size = struct.unpack("<HI", data)
        if number > 17:
            return 17
        before = self._uploads.get(controller)
        if before is not None and len(before.data) < before.size:
            self._uploads.pop(controller)  # the one before was never finished
        if any(number > loaded for loaded, half in self._images if half == controller) and self._order_broken(
            number, controller
        ):
            return 17
        self._uploads[controller] = _Upload(number, size)
        self._images.pop((number, controller), None)
        return 0

    def _order_broken(self, number: int, controller: bool) -> bool:  # noqa: FBT001
        """Whether this image follows one with a smaller index: they are to come in reverse order. A new round begins anew."""
        last = self._uploads.get(controller)
        if last is not None and number == last.number + 1:
            return True
        for key in [key for key in self._images if key[1] == controller]:
            del self._images[key]
        return False

    def _take(self, controller: bool, data: bytes) -> int:  # noqa: FBT001
        upload = self._uploads.get(controller)
        if upload is None or len(data) < 2:
            return 6
        (n,) = struct.unpack("<H", data[:2])
        if n > 504 or n != len(data) - 2 or len(upload.data) + n > upload.size:
            return 6
        upload.data += data[2:]
        if len(upload.data) == upload.size:
            try:
                picture = decode(bytes(upload.data), self._columns // self._halves, self._rows)
            except BadImage:
                return 9
            self._images[upload.number, int(controller)] = picture
        return 0

    def _configure(self, data: bytes) -> int:
        if len(data) != 6:
            return 6
        entries, self._repeats = struct.unpack("<HI", data)
        if not 1 <= entries <= _ENTRIES or any(k not in self._definitions for k in range(entries)):
            return 6
        playable = tuple(self._definitions[k] for k in range(entries))
        wanted = {(entry.image, half) for entry in playable for half in range(self._halves)}
        if not wanted <= self._images.keys():
            return 7
        self._playable = playable
        return 0

    # The sequencer

    def _sequence(self, data: bytes) -> int:
        if len(data) != 1 or data[0] > 2:
            return 6
        if data[0] != 2:
            if self._running:
                self._bench.dark()
            self._ends_s = min(self._ends_s, self._bench.clock.now_s())
            return 0
        if not self._playable or self._running:
            return 5
        entries = self._playable * max(1, self._repeats)
        times = {entry.exposure_us + entry.dark_us for entry in entries}
        if len(times) != 1 or any(entry.dark_us for entry in entries) or self._repeats == 0:
            return 16  # the bench shows pictures of one length, lit from end to end, and not for ever
        order = np.arange(len(entries))
        inverted, rising, _ = struct.unpack("<Bhh", self._trigger)
        del inverted
        picture_s = times.pop() * 1e-6
        start_s = self._bench.clock.now_s() + self._settings.start_delay_s
        images = dict(self._images)

        @lru_cache(maxsize=64)
        def mirrors(index: int) -> Bytes:
            entry = entries[index]
            halves = [
                images[entry.image, half].plane(entry.bit, self._settings.colour_order) for half in range(self._halves)
            ]
            return np.concatenate(halves, axis=1)

        silent = tuple(k for k, entry in enumerate(entries) if not entry.edge)
        self._ends_s = start_s + len(order) * picture_s
        self._aborts_s = None
        for fault in self._settings.faults:
            if isinstance(fault, Abort) and fault.picture < len(order):
                order = order[: fault.picture]
                self._aborts_s = self._ends_s = start_s + fault.picture * picture_s
        self._bench.show(Projection(start_s, picture_s, mirrors, order, sync_delay_s=-rising * 1e-6, silent=silent))
        return 0
