"""The controller in its own words: identity, health, look-up table, images, trigger."""

import struct
from collections.abc import Iterator, Sequence

from drivers.dlpc900.constants import (
    DATA_BYTES,
    DISPLAY_MODE,
    HARDWARE,
    HARDWARE_STATUS,
    LAST_ERROR,
    LOAD_BEGIN,
    LOAD_DATA,
    LUT_CONFIGURE,
    LUT_DEFINE,
    MAIN_STATUS,
    MODELS,
    ON_THE_FLY,
    PATTERNS_PER_IMAGE,
    RUNNING,
    SEQUENCE,
    START,
    STOP,
    SYSTEM_STATUS,
    TRIGGER_OUT_2,
    TROUBLES,
    VERSION,
    Mirrors,
)
from drivers.dlpc900.link import Link, refused
from protocols import DeviceError, DriverUnavailable


class Board:
    """A DLPC900 and its mirrors."""

    def __init__(self, link: Link, device: str) -> None:
        """Ask who is there, and whether it is well.

        Raises:
            DriverUnavailable: a mirror array that this driver does not know.
            DeviceError: the controller says that something is wrong.
        """
        self.link, self._device = link, device
        kind, *tag = link.read(HARDWARE)
        if kind not in MODELS:
            raise DriverUnavailable(
                device=device,
                saw=f"hardware {kind} ({bytes(tag).split(bytes(1))[0].decode('ascii', 'replace')})",
                expected=" or ".join(f"{number} ({model.name})" for number, model in MODELS.items()),
                remedy="use one of these boards; the driver does not know the mirrors of others",
            )
        self.mirrors: Mirrors = MODELS[kind]
        (version,) = struct.unpack("<I", link.read(VERSION)[:4])
        self.firmware = f"{version >> 24}.{version >> 16 & 0xFF}.{version & 0xFFFF}"
        self.check_health()

    def check_health(self) -> None:
        """Ask for the hardware and the system status.

        Raises:
            DeviceError: names what the controller says is wrong.
        """
        status, memory = self.link.read(HARDWARE_STATUS)[0], self.link.read(SYSTEM_STATUS)[0]
        wrong = [text for bit, text in TROUBLES.items() if status >> bit & 1]
        if not status & 1:
            wrong.append("its start has failed")
        if self.mirrors.controllers == 2 and not status >> 4 & 1:
            wrong.append("the second controller is missing")
        if not memory & 1:
            wrong.append("the test of its memory has failed")
        if wrong:
            raise DeviceError(
                device=self._device,
                saw=f"hardware status 0x{status:02X}: {', '.join(wrong)}",
                expected="a controller that is well",
                remedy="switch the board off and on; check firmware and mirrors if it stays",
            )

    @property
    def running(self) -> bool:
        """Whether the sequencer runs, by its own word."""
        return bool(self.link.read(MAIN_STATUS)[0] & RUNNING)

    def stop(self) -> None:
        """Stop the sequencer; the next start is from the beginning."""
        self.link.write(SEQUENCE, bytes([STOP]))

    def start(self) -> None:
        """Start the sequencer."""
        self.link.write(SEQUENCE, bytes([START]))

    def begin(self, play_order: Sequence[int], picture_time_us: int) -> None:
        """Go into the on-the-fly mode, and define one entry of the table for each picture."""
        self.stop()  # before and after the change: some boards lock up otherwise
        self.link.write(DISPLAY_MODE, bytes([ON_THE_FLY]))
        self.stop()
        white, exposure = 0x70, picture_time_us.to_bytes(3, "little")  # LEDs all on, 1 bit, no wait for a trigger
        for entry, plane in enumerate(play_order):
            place, bit = divmod(plane, PATTERNS_PER_IMAGE)
            where = struct.pack("<H", bit << 11 | place)
            self.link.write(LUT_DEFINE, struct.pack("<H", entry) + exposure + bytes([white]) + bytes(4) + where)

    def load(self, number: int, controller: int, image: bytes) -> Iterator[float]:
        """Send one image, header and data, to one controller; give the part that is stored so far, again and again.

        Raises:
            DeviceRefused: it was not taken.
        """
        self.link.write(LOAD_BEGIN[controller], struct.pack("<HI", number, len(image)))
        for start in range(0, len(image), DATA_BYTES):
            part = image[start : start + DATA_BYTES]
            self.link.stream(LOAD_DATA[controller], struct.pack("<H", len(part)) + part)
            if start + len(part) < len(image):
                yield start / len(image)
        code = self.link.read(LAST_ERROR)[0]
        if code:
            raise refused(self._device, code, f"image {number}")
        yield 1.0

    def finish(self, pictures: int, trigger_delay_us: int, trigger_width_us: int) -> tuple[int, int]:
        """Make the table effective, to be played once, and set TRIG_OUT2; give its two delays as read back."""
        self.link.write(LUT_CONFIGURE, struct.pack("<HI", pictures, 1))
        edges = struct.pack("<Bhh", 0, -trigger_delay_us, trigger_width_us - trigger_delay_us)
        self.link.write(TRIGGER_OUT_2, edges)
        _, rising_us, falling_us = struct.unpack("<Bhh", self.link.read(TRIGGER_OUT_2)[:5])
        return rising_us, falling_us
