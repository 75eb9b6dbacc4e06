"""A scheme whose patterns came in another order than it says, or inverted, as on a bench that is wired otherwise."""

from dataclasses import dataclass, replace
from itertools import product
from typing import Final

import numpy as np

from instrument.schemes.columns import Column
from instrument.schemes.reading import PositionReading, fourier_reading
from instrument.schemes.scheme import ImageRows, Scheme
from protocols import Bytes, Floats, PatternSequence

AXES_EXCHANGED: Final = "the fringes along x and y are exchanged"
"""Name of the way of wiring by which the position values of an object near the field's diagonal stay those of its image."""


@dataclass(frozen=True, eq=False)
class Exchanged:
    """What was planned, with the patterns of some columns exchanged."""

    planned: Scheme
    """The scheme as it was planned."""

    order: tuple[int, ...]
    """For each column, that of the planned scheme whose pattern was shown there."""

    inverted: bool = False
    """Whether the fringes were shown with bright and dark exchanged, which moves them by half a period."""

    @property
    def name(self) -> str:
        """Name of the planned scheme."""
        return self.planned.name

    @property
    def columns(self) -> tuple[Column, ...]:
        """Patterns of a frame as they were shown, each at the time of its column."""
        planned = self.planned.columns
        return tuple(
            self._inverted(planned[shown]).model_copy(update={"start": slot.start, "end": slot.end})
            for shown, slot in zip(self.order, planned, strict=True)
        )

    @property
    def light_weights(self) -> Floats:
        """Weights of the total light."""
        return self.planned.light_weights[list(self.order)]

    @property
    def position(self) -> PositionReading | None:
        """The reading of the fringes where they are."""
        planned = self.planned.position
        if planned is None or planned.period_px is None:
            return planned
        return replace(fourier_reading(self.columns, planned.period_px), ramps=planned.ramps, turn=planned.turn)

    @property
    def fixed_patterns(self) -> Bytes:
        """Patterns of the columns but those of ``image_rows``, in the order in which they were shown."""
        rows = self.planned.image_rows
        pair = () if rows is None else (rows.positive, rows.negative)
        single = [k for k in range(len(self.order)) if k not in pair]
        shown = self.planned.fixed_patterns[[single.index(self.order[k]) for k in single]]
        if self.inverted:
            fringes = [n for n, k in enumerate(single) if self.columns[k].role == "fourier"]
            shown[fringes] = 1 - shown[fringes]
        return shown

    @property
    def image_rows(self) -> ImageRows | None:
        """The Hadamard pattern of each frame, and its complement, where they are."""
        rows = self.planned.image_rows
        if rows is None:
            return None
        return replace(rows, positive=self.order.index(rows.positive), negative=self.order.index(rows.negative))

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """Give the sequence that was planned."""
        return self.planned.sequence(columns, rows)

    def _inverted(self, column: Column) -> Column:
        """Give a column as it is where fringes are inverted."""
        if not self.inverted or column.role != "fourier":
            return column
        return column.model_copy(update={"phase_rad": column.phase_rad + np.pi})


def exchanges(scheme: Scheme) -> dict[str, Exchanged]:
    """Give the likely ways in which the patterns of a scheme with fringes may be wired otherwise, by name.

    Both axes may be exchanged, and the order of phases along each, which makes the displacement along it one with the other sign;
    or bright and dark, of the fringes, of the Hadamard pair, or of both.

    Args:
        scheme: what was planned.

    Returns:
        The schemes as they would be; none where the scheme has no fringes.
    """
    reading, rows = scheme.position, scheme.image_rows
    if reading is None or reading.period_px is None or reading.columns.shape[1] < 2:
        return {}
    planned = np.arange(len(scheme.columns))
    found: dict[str, Exchanged] = {}
    for swapped, *reversed_axes in product((False, True), repeat=3):
        order = planned.copy()
        for axis, is_reversed in enumerate(reversed_axes):
            shown = reading.columns[1 - axis if swapped else axis]
            order[reading.columns[axis]] = shown[::-1] if is_reversed else shown
        names = [AXES_EXCHANGED] if swapped else []
        which = [name for name, is_reversed in zip("xy", reversed_axes, strict=True) if is_reversed]
        names += [f"phases in the place of {' and '.join(which)} come in the reverse order"] if which else []
        if names:
            found[", and ".join(names)] = Exchanged(scheme, tuple(order.tolist()))
    found["the fringes are inverted"] = Exchanged(scheme, tuple(planned.tolist()), inverted=True)
    if rows is not None:
        order = planned.copy()
        order[[rows.positive, rows.negative]] = rows.negative, rows.positive
        found["H- comes first: exchanged"] = Exchanged(scheme, tuple(order.tolist()))
        found["the modulator inverts its pictures"] = Exchanged(scheme, tuple(order.tolist()), inverted=True)
    return found
