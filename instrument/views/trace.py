"""A displacement over a run of any length, in constant memory."""

import numpy as np

from protocols import Floats


class Trace:
    """A displacement over a whole run in constant memory: every 1st, 2nd, 4th... frame, as the run gets longer."""

    def __init__(self, most: int = 512) -> None:
        """Keep at most so many frames; ``most`` is even."""
        self._kept_px = np.zeros((most, 4))
        self._count = 0
        self.stride = 1
        """Every how manieth frame is kept."""
        self._frames = 0
        self.last_px: tuple[float, float] | None = None
        """x, y of the newest frame."""
        self.last_sigma_px: tuple[float, float] = (np.nan, np.nan)
        """Their standard uncertainty; NaN where none is known."""

    @property
    def displacement_px(self) -> Floats:
        """``(n, 2)``: the frames kept."""
        return self._kept_px[: self._count, :2]

    @property
    def sigma_px(self) -> Floats:
        """``(n, 2)``: standard uncertainty of these; NaN where none is known."""
        return self._kept_px[: self._count, 2:]

    def add(self, displacement_px: Floats, sigma_px: Floats | None = None) -> None:
        """Take the next frames, ``(n, 2)``, and their uncertainty, where somebody states it."""
        frames = len(displacement_px)
        if sigma_px is None or len(sigma_px) != frames:
            sigma_px = np.full((frames, 2), np.nan)
        if frames:
            x_px, y_px = displacement_px[-1].tolist()
            self.last_px = (x_px, y_px)
            sigma_x_px, sigma_y_px = sigma_px[-1].tolist()
            self.last_sigma_px = (sigma_x_px, sigma_y_px)
        for place_px in np.concatenate([displacement_px, sigma_px], axis=1):
            if self._frames % self.stride == 0:
                if self._count == len(self._kept_px):
                    self._count //= 2
                    self.stride *= 2
                    self._kept_px[: self._count] = self._kept_px[::2].copy()
                self._kept_px[self._count] = place_px
                self._count += 1
            self._frames += 1
