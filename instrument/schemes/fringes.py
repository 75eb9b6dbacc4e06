"""The Fourier half of a scheme: its settings, and the binary fringes that stand for its columns."""

from collections.abc import Sequence

import numpy as np
from pydantic import PositiveInt

from instrument.patterns import fourier_pattern
from instrument.schemes.columns import Axis, Column, in_play_order
from instrument.schemes.hadamard_pairs import DitheredSettings
from protocols import Bytes


class FringeSettings(DitheredSettings):
    """Settings of every scheme that shows dithered Fourier patterns."""

    fourier_cycles: PositiveInt = 2
    """Periods of the Fourier patterns across the field: f = cycles / m. Motion is unambiguous within m / (2 cycles)."""

    def check(self, image_size: int, superpixel: int) -> None:
        """Refuse samples that are no whole mirrors, and fringes too fine for the pixels."""
        super().check(image_size, superpixel)
        if 2 * self.fourier_cycles >= image_size:
            raise ValueError(f"scheme.fourier_cycles is {self.fourier_cycles}: it must be below image_size / 2")


def stepped_columns(steps: int) -> tuple[Column, ...]:
    """Give the columns of fringes whose phase goes round in equal steps: all of x, then all of y.

    Args:
        steps: fringes an axis; their phases in rad are 2 pi k / steps.
    """
    axes: tuple[Axis, Axis] = ("x", "y")
    return in_play_order(
        *(
            Column(role="fourier", axis=axis, phase_rad=2 * np.pi * step / steps)
            for axis in axes
            for step in range(steps)
        )
    )


def fringe_patterns(columns: Sequence[Column], image_size: int, settings: FringeSettings) -> Bytes:
    """Make the binary pattern of each Fourier column, in the order of the columns.

    Args:
        columns: all patterns of a frame.
        image_size: pixels a side of the field (m).
        settings: frequency of the fringes, and dithering samples a side of a pixel.

    Returns:
        ``(n, samples, samples)`` of 0 and 1, samples = m upsampling.
    """
    fringes = [(column.phase_rad, column.axis) for column in columns if column.role == "fourier"]
    return np.stack(
        [
            fourier_pattern(image_size, settings.fourier_cycles, phase_rad, axis, settings.upsampling)
            for phase_rad, axis in fringes
            if axis is not None
        ]
    )
