"""The light model applied to a stream of frames, as they come."""

from importlib import import_module

import numpy as np

from instrument.measurement.image_values import fixed_columns
from instrument.measurement.leak import without_gaps
from instrument.measurement.light_model import LightModel
from instrument.schemes import Scheme
from protocols import Floats


class LightStream:
    """Takes leak and offsets out of frames while a run goes on, with numbers that an earlier analysis found.

    It gives the same as ``Measurement.lit_by`` does of a whole run, but for ripples and for what edges cost the total light.
    """

    def __init__(self, scheme: Scheme, light: LightModel) -> None:
        """Prepare for one run.

        Args:
            scheme: what is shown.
            light: what an analysis found of the bench.
        """
        self._leak = light.leak.value
        self._weights = scheme.light_weights
        self._columns = fixed_columns(scheme)
        offsets = [offset.value for offset in light.offsets]
        self._offsets = np.array(offsets if len(offsets) == len(self._columns) else [0.0] * len(self._columns))
        self._state = np.zeros(1)
        if self._leak:
            import_module("scipy.signal")  # slow to load: only what leaks needs it, and not while frames come

    def take(self, values: Floats) -> Floats:
        """Correct the next frames.

        Args:
            values: ``(n, patterns_per_frame)`` in play order; NaN where none was measured.

        Returns:
            Values of the same shape.
        """
        corrected = values if self._leak == 0 else self._without_leak(values)
        if self._offsets.any():
            corrected = corrected.copy()
            corrected[:, self._columns] -= (corrected @ self._weights)[:, None] * self._offsets
        return corrected

    def _without_leak(self, values: Floats) -> Floats:
        """Solve y_k = (1 - c) v_k + c v_(k-1) over the ends of frames and blocks; see ``leak.without_leak``."""
        from scipy.signal import lfilter  # noqa: PLC0415 - as in __init__

        filled = without_gaps(values)
        share = 1 / (1 - self._leak)
        solved, self._state = lfilter([share], [1.0, self._leak * share], filled.ravel(), zi=self._state)
        return np.where(np.isfinite(values), np.asarray(solved, np.float64).reshape(values.shape), np.nan)
