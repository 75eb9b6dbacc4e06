"""A displacement over a run of any length, in constant memory."""

import numpy as np

from protocols import Floats


class Trace:
    """A displacement over a whole run in constant memory: every 1st, 2nd, 4th... frame, as the run gets longer."""

    def __init__(self, most: int = 512) -> None:
        """Keep at most so many frames; ``most`` is even."""
        self._kept_px = np.zeros((most, 2))
        self._count = 0
        self.stride = 1
        """Every how manieth frame is kept."""
        self._frames = 0
        self.last_px: tuple[float, float] | None = None
        """x, y of the newest frame."""

    @property
    def displacement_px(self) -> Floats:
        """``(n, 2)``: the frames kept."""
        return self._kept_px[: self._count]

    def add(self, displacement_px: Floats) -> None:
        """Take the next frames, ``(n, 2)``."""
        if len(displacement_px):
            x_px, y_px = displacement_px[-1].tolist()
            self.last_px = (x_px, y_px)
        for place_px in displacement_px:
            if self._frames % self.stride == 0:
                if self._count == len(self._kept_px):
                    self._count //= 2
                    self.stride *= 2
                    self._kept_px[: self._count] = self._kept_px[::2].copy()
                self._kept_px[self._count] = place_px
                self._count += 1
            self._frames += 1
