"""Spatial light modulators that show binary patterns under their own clock.

**The N + 1 edge rule.** A counter closes a pattern's bin at the *next* sync edge, so N patterns need N + 1 edges.
The guard picture that gives the last edge belongs to the **sequence**: the last entry of every play order is a dark plane.
A modulator adds nothing: it plays the order once as given, one picture and one sync edge for each entry.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, Self, TypeAlias, runtime_checkable

import numpy as np
from pydantic import NonNegativeFloat, NonNegativeInt, PositiveInt

from protocols.errors import PatternMemoryFull, PictureTimeTooShort, PlanError
from protocols.values import Bytes, DeviceIdentity, Frozen, Integers

UploadProgress: TypeAlias = Callable[[int, int], None]
"""Called with (unique patterns stored so far, unique patterns in all)."""


class ModulatorLimits(Frozen):
    """Limits of a modulator as read from the device, and the checks of a sequence and its timing against them."""

    columns: PositiveInt
    """Number of mirrors in a row."""

    rows: PositiveInt
    """Number of rows of mirrors."""

    shortest_picture_time_us: PositiveInt
    """Shortest time from one picture to the next, in whole microseconds."""

    longest_picture_time_us: PositiveInt
    """Longest time from one picture to the next, in whole microseconds."""

    unique_patterns: PositiveInt
    """Number of bit planes that the device can hold now."""

    play_order_entries: PositiveInt
    """Length of the longest play order in pictures, the guard picture included."""

    longest_upload_s: NonNegativeFloat = 0.0
    """Longest time that storing one unique pattern takes, in seconds; 0 where that is not worth a word."""

    def check_sequence(self, sequence: "PatternSequence", device: str) -> None:
        """Refuse a sequence for other mirrors, or one that does not fit; ``device`` is the name that the error carries.

        Raises:
            PlanError: the sequence was made for another mirror geometry.
            PatternMemoryFull: more unique patterns, or a longer play order, than the device holds.
        """
        self.check_geometry(sequence.grid, device)
        self.check_unique_patterns(len(sequence.planes), device)
        self.check_play_order(len(sequence.play_order), device)

    def check_geometry(self, grid: "PixelGrid", device: str) -> None:
        """Refuse patterns that were made for another mirror array.

        Raises:
            PlanError: names both geometries.
        """
        if (grid.columns, grid.rows) != (self.columns, self.rows):
            raise PlanError(
                device=device,
                saw=f"patterns for {grid.columns} x {grid.rows} mirrors",
                expected=f"{self.columns} x {self.rows}",
                remedy="build the sequence with the columns and rows of this modulator's limits",
            )

    def check_unique_patterns(self, unique_patterns: int, device: str) -> None:
        """Refuse more unique patterns than the device holds.

        Raises:
            PatternMemoryFull: names both numbers.
        """
        if unique_patterns > self.unique_patterns:
            raise PatternMemoryFull(device, unique_patterns, self.unique_patterns)

    def check_play_order(self, pictures: int, device: str) -> None:
        """Refuse a play order of more pictures, the guard included, than the device keeps.

        Raises:
            PatternMemoryFull: names both numbers.
        """
        if pictures > self.play_order_entries:
            raise PatternMemoryFull(device, pictures, self.play_order_entries, "pictures in the play order")

    def check_timing(self, timing: "ModulatorTiming", device: str) -> None:
        """Refuse a picture time that the device does not play, or a sync pulse that does not end within a picture.

        Raises:
            PictureTimeTooShort: faster than the device can play; names the shortest time.
            PlanError: slower than the device can play, or a sync pulse as long as the picture.
        """
        self.check_picture_time(timing.picture_time_us, device)
        longest_us = timing.picture_time_us - 1
        if timing.sync_width_us > longest_us:
            raise PlanError(
                device=device,
                saw=f"a sync width of {timing.sync_width_us} us in a picture time of {timing.picture_time_us} us",
                expected=f"at most {longest_us} us, shorter than the picture time",
                remedy="shorten sync_width_us, or lower pattern_rate_hz",
            )

    def check_picture_time(self, picture_time_us: int, device: str) -> None:
        """Refuse a picture time outside what the device can play.

        Raises:
            PictureTimeTooShort: names the shortest time, and the rate that would do.
            PlanError: longer than the longest; names it, and the rate that would do.
        """
        if picture_time_us < self.shortest_picture_time_us:
            raise PictureTimeTooShort(device, picture_time_us, self.shortest_picture_time_us)
        if picture_time_us > self.longest_picture_time_us:
            raise PlanError(
                device=device,
                saw=f"a picture time of {picture_time_us} us",
                expected=f"at most {self.longest_picture_time_us} us",
                remedy=f"raise pattern_rate_hz to {1e6 / self.longest_picture_time_us:g} or more",
            )


class ModulatorTiming(Frozen):
    """Timing of a modulator's pictures. It is read back from the device, never assumed."""

    picture_time_us: PositiveInt
    """Time from the start of one picture to the start of the next, in whole microseconds."""

    sync_delay_us: NonNegativeInt = 0
    """Time from the sync edge to the start of its picture, in microseconds. 0 makes a counter's bins the pictures themselves."""

    sync_width_us: PositiveInt = 5
    """Length of the sync pulse in microseconds: longer than the counter's input filter, shorter than the picture time."""


class PixelGrid(Frozen):
    """Place of the square image grid on the modulator's mirrors, centred."""

    image_size: PositiveInt
    """Side of the image in pixels (m)."""

    superpixel: PositiveInt
    """Side of one image pixel in mirrors."""

    columns: PositiveInt = 1024
    """Number of mirrors in a row of the whole modulator."""

    rows: PositiveInt = 768
    """Number of rows of mirrors of the whole modulator."""

    @property
    def side_mirrors(self) -> int:
        """Side of the image field in mirrors."""
        return self.image_size * self.superpixel

    @property
    def origin(self) -> tuple[int, int]:
        """Row and column of the field's first mirror, from 0: the field is centred on the modulator."""
        return (self.rows - self.side_mirrors) // 2, (self.columns - self.side_mirrors) // 2

    @property
    def fits(self) -> bool:
        """Whether the field lies on the modulator whole."""
        return self.side_mirrors <= min(self.rows, self.columns)


@dataclass(frozen=True, eq=False)
class PatternSequence:
    """Unique bit planes, packed, and the order in which to play them.

    Planes are kept at the patterns' own resolution, ``samples`` a side, and become mirrors on request
    (``mirror_plane``): 3,336 patterns of 128 x 128 are 7 MB here and 328 MB as mirrors of a 1024 x 768 modulator.
    """

    planes: Bytes
    """``(unique, samples, ceil(samples / 8))`` bit planes, 8 samples a byte along a row, the leftmost in the highest bit."""

    play_order: Integers
    """``(pictures,)`` index into ``planes`` of each picture. The last one is the guard: a dark plane."""

    grid: PixelGrid
    """Place of the patterns' field on the mirrors."""

    samples: int
    """Side of a pattern in samples: ``grid.image_size`` times the upsampling ratio of the dithering."""

    def __post_init__(self) -> None:
        """Refuse a sequence that cannot be played.

        Raises:
            PlanError: shapes that do not agree, an index out of range, or no dark guard picture at the end.
        """
        width = -(-self.samples // 8)
        if self.planes.ndim != 3 or self.planes.shape[1:] != (self.samples, width):
            raise _bad(f"planes of shape {self.planes.shape}", f"(unique, {self.samples}, {width})")
        if self.grid.side_mirrors % self.samples:
            raise _bad(f"{self.samples} samples on {self.grid.side_mirrors} mirrors", "whole mirrors a sample")
        if not self.grid.fits:
            raise _bad(
                f"a field of {self.grid.side_mirrors} mirrors a side",
                f"at most {min(self.grid.rows, self.grid.columns)}",
            )
        if len(self.play_order) < 2 or not 0 <= self.play_order.min() <= self.play_order.max() < len(self.planes):
            raise _bad("a play order that is too short or points outside the planes", "two or more valid indices")
        if self.planes[self.play_order[-1]].any():
            raise _bad("a play order that ends on a lit picture", "a dark guard picture as the last entry")

    @property
    def n_patterns(self) -> int:
        """Number of patterns that are data: all pictures but the guard."""
        return len(self.play_order) - 1

    @cached_property
    def _scale(self) -> int:
        return self.grid.side_mirrors // self.samples

    def sample_plane(self, index: int) -> Bytes:
        """Give plane ``index`` as ``(samples, samples)`` of 0 and 1."""
        return np.unpackbits(self.planes[index], axis=-1, count=self.samples)

    def mirror_plane(self, index: int) -> Bytes:
        """Give plane ``index`` as the modulator wants it: ``(rows, columns / 8)``, packed, dark outside the field."""
        grid = self.grid
        top, left = grid.origin
        # One row of mirrors for each row of samples is packed, and then repeated: the rows between are the same bytes.
        lines = np.zeros((self.samples, grid.columns), np.uint8)
        lines[:, left : left + grid.side_mirrors] = self.sample_plane(index).repeat(self._scale, 1)
        mirrors = np.zeros((grid.rows, -(-grid.columns // 8)), np.uint8)
        mirrors[top : top + grid.side_mirrors] = np.packbits(lines, axis=-1).repeat(self._scale, 0)
        return mirrors


def _bad(saw: str, expected: str) -> PlanError:
    return PlanError(saw=saw, expected=expected, remedy="change image_size, superpixel or upsampling in plan.toml")


@runtime_checkable
class PatternModulator(Protocol):
    """Shows binary patterns under its own clock and gives one sync edge for each picture.

    Life: ``load`` -> ``start`` -> ``wait`` (or ``halt``); ``start`` again replays. ``halt`` is allowed at any time, from
    any thread, and twice. As a context manager it is open from construction on and closed (halted, memory freed) on exit.
    """

    @property
    def identity(self) -> DeviceIdentity:
        """Identity of the board and of its mirror array."""
        ...

    @property
    def limits(self) -> ModulatorLimits:
        """Geometry in mirrors, shortest and longest picture time, and memory in unique patterns."""
        ...

    def load(
        self, sequence: PatternSequence, timing: ModulatorTiming, progress: UploadProgress | None = None
    ) -> ModulatorTiming:
        """Store each unique pattern once and return the timing that the device will keep.

        The device stores all or nothing: after an error it holds no half sequence and can be loaded again.
        ``ModulatorLimits`` has the checks of both arguments.

        Raises:
            PatternMemoryFull: more unique patterns, or a longer play order, than the device holds.
            PictureTimeTooShort: faster than the device can play; names the shortest.
            PlanError: the sequence was made for another mirror geometry, or the timing is not one that the device has.
        """
        ...

    def start(self) -> None:
        """Play the order once, from the first picture, and return at once.

        Raises:
            WrongState: nothing is loaded, or the last run still plays.
        """
        ...

    @property
    def running(self) -> bool:
        """Whether pictures are being played now."""
        ...

    def wait(self, timeout_s: float) -> None:
        """Return when the last picture has been shown.

        Raises:
            DeviceTimeout: still playing after ``timeout_s``.
            WrongState: never started.
        """
        ...

    def halt(self) -> None:
        """Stop at once and show nothing. Never raises for a device that is already idle."""
        ...

    def __enter__(self) -> Self:
        """Give the open device."""
        ...

    def __exit__(self, *exc: object) -> None:
        """Halt and let go of the device, even if halting fails."""
        ...
