"""The one measurement that every estimator is given: the light of all frames, made once for a recording."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from instrument.measurement.detector import light_of
from instrument.measurement.image_values import ImageValues
from instrument.numerics import smooth
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.schemes import Light, Observation, Scheme, image_rows_of, position_of, scheme_of
from protocols import Floats, InputError, Mask

_SIGNIFICANT: Final = 5  # standard errors by which the mean light must stand above nothing
_FEWEST: Final = 8  # frames from which anything can be smoothed
_DARKEST: Final = 1e-3  # of its mean: a lamp is taken as at least so bright


@dataclass(frozen=True, eq=False)
class Measurement:
    """All frames of a recording as light, with the variance of every value and a mask."""

    plan: Plan
    """What was shown."""

    scheme: Scheme
    """What the columns are."""

    values: Floats
    """``(frames, patterns_per_frame)``: light, free of dead time, dark counts and background; NaN where none was measured."""

    variance: Floats
    """Likewise: variance of each value."""

    valid: Mask
    """``(frames,)``: whether the frame is trusted and every value is finite."""

    pattern_time_s: Floats
    """As ``values``: middle of each pattern, from the first edge on."""

    frame_time_s: float
    """Time from one frame to the next."""

    photon_counts: bool
    """Whether values are photons."""

    @classmethod
    def of(cls, recording: "Recording | Measurement") -> "Measurement":
        """Correct a recording; a measurement is given back as it is.

        Raises:
            InputError: more counts than the dead time lets through, or something else than a recording.
        """
        if isinstance(recording, Measurement):
            return recording
        if not isinstance(recording, Recording):  # pyright: ignore[reportUnnecessaryIsInstance] - a script may pass a path
            raise InputError(
                saw=f"a {type(recording).__name__}",
                expected="a recording",
                remedy="open the file first: open_recording(path)",
            )
        scheme = scheme_of(recording.plan)
        values, variance = light_of(recording, scheme.light_weights)
        return cls(
            plan=recording.plan,
            scheme=scheme,
            values=values,
            variance=variance,
            valid=recording.frame_valid & np.isfinite(values).all(axis=1),
            pattern_time_s=recording.pattern_time_s,
            frame_time_s=recording.frame_time_s,
            photon_counts=recording.photon_counts,
        )

    def __len__(self) -> int:
        """Frames, those that are not valid too."""
        return len(self.values)

    @cached_property
    def total(self) -> Floats:
        """``(frames,)``: total light S of each frame; 0 where it is not valid."""
        return np.where(self.valid[:, None], self.values, 0.0) @ self.scheme.light_weights

    @cached_property
    def steady_total(self) -> Floats:
        """``(frames,)``: total light without the noise of its measurement, but with the lamp's own flicker.

        What of a jump in the total is flicker shows in the position patterns of the same frame too, whose sum goes with the
        total: the slope of their jumps on its jumps, over their ratio, is flicker's share (linear regression on third
        differences). Where the total is the sum of those very patterns nothing can be told apart, and it stays as it is.
        """
        columns = position_of(self.scheme).columns
        if np.count_nonzero(self.valid) < _FEWEST or self.scheme.light_weights[columns].any():
            return self.total
        steady = smooth(self.total, self.valid.astype(np.float64), orders=(1,)).values
        answer = np.where(self.valid, self.values[:, columns.ravel()].sum(axis=1), 0.0)
        whole = np.convolve(~self.valid, np.ones(4), "valid") == 0
        jumps, answers = np.diff(self.total, 3)[whole], np.diff(answer, 3)[whole]
        power, ratio = float(jumps @ jumps), float(answer.sum()) / max(float(self.total.sum()), 1e-300)
        share = float(jumps @ answers) / (ratio * power) if power > 0 and ratio > 0 else 0.0
        return steady + min(max(share, 0.0), 1.0) * (self.total - steady)

    def observe(self, *, steady: bool) -> Observation:
        """Give what each frame says of the position.

        Args:
            steady: whether the total light, which enters every position and does not change with motion, is taken as
                ``steady_total``: for the paper's scheme that takes a third of the coefficients' variance away.

        Raises:
            InputError: a scheme without position, or not one frame that is both valid and lit.
        """
        position = position_of(self.scheme)
        total = self.steady_total if steady else self.total
        lit = self.valid & (total > 0)
        self._expect_light(total[self.valid])
        if not lit.any():
            raise InputError(
                saw=f"no frame with light in a recording of {len(self)} frames, {np.count_nonzero(self.valid)} of them valid",
                expected="frames whose total light is above 0",
                remedy="check light source, shutter and background, and the recording's timing report",
            )
        seen = self.scheme.light_weights != 0
        squares = self.scheme.light_weights[seen] ** 2
        total_variance = np.zeros_like(total) if steady else self.variance[:, seen] @ squares
        light = Light(self.values, self.variance, total, total_variance, lit, self.photon_counts)
        return Observation.of(position, light)

    def image_values(self, *, steady_object: bool) -> ImageValues:
        """Give what the valid frames say of the image.

        Args:
            steady_object: whether the object stays inside the field, so that a change of the total light is one of the lamp
                and is divided out (smoothed over frames).

        Raises:
            InputError: no valid frame, or a scheme without image.
        """
        rows = image_rows_of(self.scheme)
        frame = np.flatnonzero(self.valid)
        if not len(frame):
            raise InputError(
                saw=f"no valid frame in a recording of {len(self)}",
                expected="at least one",
                remedy="look at the recording's timing report",
            )
        total = self.total[frame]
        lamp = np.ones(len(frame))
        if steady_object and len(frame) >= _FEWEST and (total > 0).any():
            lamp = smooth(total, np.ones(len(total)), orders=(1,)).values
            lamp = np.maximum(lamp / lamp.mean(), _DARKEST)
        return ImageValues.of(
            self.scheme,
            frame=frame,
            pairs=rows.pairs[frame % len(rows.pairs)],
            values=self.values[frame],
            variance=self.variance[frame],
            time_s=self.pattern_time_s[frame],
            lamp=lamp,
            size=self.plan.image_size,
            photon_counts=self.photon_counts,
        )

    def light_change(self) -> float:
        """Largest change of the total light in the run, relative to its median, over tenths of the run.

        Means over tenths are compared, so that noise does not count as change.
        """
        tenths = [float(np.mean(part)) for part in np.array_split(self.total[self.valid], 10) if len(part)]
        middle = float(np.median(tenths)) if tenths else 0.0
        return max(abs(tenth / middle - 1) for tenth in tenths) if middle > 0 else 0.0

    @staticmethod
    def _expect_light(total: Floats) -> None:
        """Refuse a run whose mean light could as well be the noise around none."""
        if len(total) < _FEWEST:
            return
        mean, error = float(np.mean(total)), float(np.std(total)) / np.sqrt(len(total))
        if mean < _SIGNIFICANT * error:
            raise InputError(
                saw=f"a mean light of {mean:.3g} with a standard error of {error:.2g}",
                expected="light well above the noise: an object to follow",
                remedy="check that the object is in the field, and light source and shutter",
            )
