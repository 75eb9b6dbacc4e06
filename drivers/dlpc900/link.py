"""Commands and replies over reports of 64 bytes (fact sheet, section 2)."""

import struct
from threading import Lock
from typing import Final

from drivers.dlpc900.constants import ERROR_TEXT, ERRORS, LAST_ERROR
from drivers.dlpc900.transport import REPORT, HidReports
from protocols import Clock, DeviceDisconnected, DeviceRefused, DeviceTimeout

_READ, _REPLY, _ERROR = 0x80, 0x40, 0x20


class Link:
    """One command at a time: the controller has one buffer, which the next command would overwrite."""

    def __init__(self, reports: HidReports, clock: Clock, device: str, reply_s: float) -> None:
        """Take over an open device.

        Args:
            reports: the device.
            clock: for the time-outs.
            device: name that errors carry.
            reply_s: longest wait for a reply.
        """
        self._reports, self._clock, self._device, self._reply_s = reports, clock, device, reply_s
        self._lock: Final = Lock()
        self._sequence = 0

    def read(self, command: int) -> bytes:
        """Ask, and once more where no answer comes; give its data.

        Raises:
            DeviceRefused: the error flag is set.
            DeviceTimeout: no answer with this question's number, twice.
            DeviceDisconnected: the device is gone.
        """
        with self._lock:
            try:
                return self._exchange(_READ | _REPLY, command, b"")
            except DeviceTimeout:
                return self._exchange(_READ | _REPLY, command, b"")

    def write(self, command: int, data: bytes) -> None:
        """Set something, and wait until the controller has taken it; raises as ``read``."""
        with self._lock:
            self._exchange(_REPLY, command, data)

    def stream(self, command: int, data: bytes) -> None:
        """Send data without waiting for a reply; ``read(LAST_ERROR)`` tells later whether it was taken."""
        with self._lock:
            self._send(0, command, data)

    def close(self) -> None:
        """Let go of the device."""
        self._reports.close()

    def _send(self, flags: int, command: int, data: bytes) -> None:
        self._sequence = (self._sequence + 1) & 0xFF
        packet = struct.pack("<BBHH", flags, self._sequence, len(data) + 2, command) + data
        packet += bytes(-len(packet) % REPORT)
        try:
            for start in range(0, len(packet), REPORT):
                self._reports.write(packet[start : start + REPORT])
        except OSError as error:
            raise self._gone(error) from error

    def _exchange(self, flags: int, command: int, data: bytes) -> bytes:
        self._send(flags, command, data)
        begun_s = self._clock.now_s()
        while True:
            rest_s = begun_s + self._reply_s - self._clock.now_s()
            report = self._next(rest_s) if rest_s > 0 else b""
            if not report:
                raise DeviceTimeout(
                    self._device,
                    awaited=f"a reply to command 0x{command:04X}",
                    waited_s=self._clock.now_s() - begun_s,
                    progress="no report with its number",
                    remedy="check the USB cable; switch the board off and on if it does not come back",
                )
            if len(report) >= 4 and report[1] == self._sequence:
                break  # an older reply is passed over
        flag, _, length = struct.unpack("<BBH", report[:4])
        answer = report[4:]
        while len(answer) < length:
            more = self._next(self._reply_s)
            if not more:
                break
            answer += more
        if flag & _ERROR and command not in {LAST_ERROR, ERROR_TEXT}:
            raise self._refused(command)
        return answer[:length]

    def _next(self, timeout_s: float) -> bytes:
        try:
            return self._reports.read(timeout_s)
        except OSError as error:
            raise self._gone(error) from error

    def _refused(self, command: int) -> DeviceRefused:
        code = self._exchange(_READ | _REPLY, LAST_ERROR, b"")[0]
        return refused(self._device, code, f"command 0x{command:04X}")

    def _gone(self, error: OSError) -> DeviceDisconnected:
        return DeviceDisconnected(
            device=self._device,
            saw=f"a USB device that fails ({error})",
            expected="an open DLPC900",
            remedy="check cable and power, and open it again; what it shows now is not known",
        )


def refused(device: str, code: int, what: str) -> DeviceRefused:
    """Give the error of something that the controller did not take."""
    return DeviceRefused(
        device,
        code=str(code),
        saw=f"{what} refused: {ERRORS.get(code, 'an error that the guide does not know')}",
        expected="no error",
        remedy="see the fact on this code in TI's guide; switch the board off and on if it stays",
    )
