"""What the values of a run say of their alignment, asked piece by piece, so that a run of any length needs the same memory."""

from importlib import import_module
from typing import TYPE_CHECKING, Final

import numpy as np

from instrument.schemes import Scheme
from protocols import Floats, Mask

if TYPE_CHECKING:
    from instrument.measurement import Segment, Slips

PIECE: Final = 8192
"""Frames that are looked at together: 2.5 s at 20 kHz and six patterns. A run of no more is looked at as a whole."""

_AGAIN: Final = 256
"""Frames at the end of a piece that are looked at once more, with what follows them: a slip shows by both sides of it."""


class SlipWatch:
    """Holds the values of the last ``PIECE`` frames; of those before only where they slipped, and which frames are sure."""

    def __init__(self, scheme: Scheme, patterns: int, patterns_per_frame: int) -> None:
        """Nothing has come yet. What looks for slips is loaded here: not while a counter counts, or while a run is to end.

        Args:
            scheme: what is shown.
            patterns: in the whole run.
            patterns_per_frame: of the scheme.
        """
        import_module("instrument.measurement")  # compiled loops: loaded by who runs, not by who checks a plan

        self._scheme = scheme
        self._per_frame = patterns_per_frame
        room = min(patterns, PIECE * patterns_per_frame)
        self._values = np.empty(room + patterns_per_frame, np.float32)
        self._held = 0  # patterns
        self._first_frame = 0  # of those that are held
        self._segments: list[Segment] = []
        self._sure: list[Mask] = []
        self._looked: tuple[int, Slips | None] = (0, None)

    @property
    def held_bytes(self) -> int:
        """Memory for values."""
        return self._values.nbytes

    def see(self, values: Floats, frame_valid: Mask, *, photon_counts: bool) -> None:
        """Take the next values.

        Args:
            values: ``(n,)`` in play order.
            frame_valid: ``(frames,)`` of the run from its start: whether edges let a frame be used.
            photon_counts: whether the values count photons.
        """
        while len(values):
            now = values[: len(self._values) - self._held]
            self._values[self._held : self._held + len(now)] = now
            self._held += len(now)
            values = values[len(now) :]
            if self._held == len(self._values) and self._held > PIECE * self._per_frame:
                self._settle(frame_valid, photon_counts=photon_counts)

    def _settle(self, frame_valid: Mask, *, photon_counts: bool) -> None:
        """Look at the frames that are held, and let all but the last ones go."""
        found = self._found(frame_valid, photon_counts=photon_counts)
        done = PIECE - _AGAIN
        self._add(self._segments, self._sure, found, done)
        self._first_frame += done
        left = self._values[done * self._per_frame : self._held].copy()
        self._values[: len(left)] = left
        self._held = len(left)

    def slips(self, frame_valid: Mask, *, photon_counts: bool) -> "Slips | None":
        """Give what was found in all whole frames so far; None where there is none. Asking changes nothing."""
        frames = self._first_frame + self._held // self._per_frame
        if not frames:
            return None
        if self._looked[0] != frames:
            from instrument.measurement import Slips  # noqa: PLC0415 - as in __init__

            segments, sure = list(self._segments), list(self._sure)
            found = self._found(frame_valid, photon_counts=photon_counts)
            self._add(segments, sure, found, len(found.sure))
            self._looked = frames, Slips(tuple(segments), np.concatenate(sure))
        return self._looked[1]

    def _found(self, frame_valid: Mask, *, photon_counts: bool) -> "Slips":
        from instrument.measurement import slips_of_counts  # noqa: PLC0415 - as in __init__

        frames = self._held // self._per_frame
        values = self._values[: frames * self._per_frame].reshape(frames, self._per_frame).astype(np.float64)
        valid = frame_valid[self._first_frame : self._first_frame + frames]
        return slips_of_counts(values, valid, self._scheme, photon_counts=photon_counts)

    def _add(self, segments: "list[Segment]", sure: list[Mask], found: "Slips", frames: int) -> None:
        """Add what was found in the first frames that are held to what stands for those before."""
        from instrument.measurement import Segment  # noqa: PLC0415 - as in __init__

        for segment in found.segments:
            first, end = self._first_frame + segment.first_frame, self._first_frame + min(segment.end_frame, frames)
            if first >= end:
                continue
            pattern = self._first_frame * self._per_frame + segment.first_pattern
            if segments and segments[-1].shift == segment.shift:
                before = segments.pop()
                first, pattern = before.first_frame, before.first_pattern
            segments.append(Segment(first, end, segment.shift, pattern))
        # Where nothing slipped, a frame that goes with no neighbour is left to the analysis.
        sure.append(found.sure[:frames] if found.any or not self._sure else np.ones(frames, bool))
