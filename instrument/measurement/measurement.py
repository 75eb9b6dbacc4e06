"""The measurement that every estimator is given: the light of all frames, corrected once for a recording."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from instrument.choices import Normalise
from instrument.measurement.detector import light_of
from instrument.measurement.edge_light import with_edge_light
from instrument.measurement.finding import Finding
from instrument.measurement.image_values import ImageValues, fixed_columns
from instrument.measurement.lamp import to_one_moment
from instrument.measurement.leak import difference_variance_ratio, leak_variance_ratio, without_leak
from instrument.measurement.light_model import IDEAL, LightModel
from instrument.measurement.ripple import lamp_factor, without_ripples
from instrument.measurement.screening import screened
from instrument.measurement.slips import Slips
from instrument.numerics import coverage_factor, smooth
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.schemes import Light, Observation, Scheme, Signals, as_signals, image_rows_of, position_of, scheme_of
from protocols import Floats, InputError, Mask
from protocols.field_docs import with_fields

_SIGNIFICANT: Final = 5  # standard errors by which the mean light must be above 0
_FEWEST_FRAMES: Final = 8  # below which nothing is smoothed
_LEAST_LAMP: Final = 1e-3  # brightness assumed at least, over the lamp's mean


@with_fields
@dataclass(frozen=True, eq=False)
class Measurement:
    """All frames of a recording as light, with the variance of every value and a mask of valid frames."""

    plan: Plan
    """Plan of the run."""

    scheme: Scheme
    """Scheme, which says what each column of the values is."""

    values: Floats
    """``(frames, patterns_per_frame)``: light without dead time, dark counts and background; NaN where none was measured."""

    variance: Floats
    """``(frames, patterns_per_frame)``: variance of each value."""

    valid: Mask
    """``(frames,)``: whether the timing audit found the frame valid and every value is finite."""

    pattern_time_s: Floats
    """``(frames, patterns_per_frame)``: time of the middle of each pattern after the first edge."""

    frame_time_s: float
    """Time from one frame to the next."""

    photon_counts: bool
    """Whether the values count photons."""

    arrived: Floats
    """``(frames, patterns_per_frame)``: light as it arrived, of which the picture before is a part; NaN likewise."""

    light: LightModel = IDEAL
    """What the bench does to the light, as far as ``values`` are free of it."""

    background_known: bool = False
    """Whether a background was recorded and is taken off, so that little light is left that has nothing to do with the object."""

    light_found: bool = False
    """Whether the run itself was asked what the light model is."""

    normalise: Normalise = "smoothed"
    """By what values are divided against a lamp that changes; ``auto`` is ``smoothed`` here."""

    findings: tuple[Finding, ...] = ()
    """What the screening of the counts found, and mended or masked."""

    slips: Slips | None = None
    """By how many patterns the values came late or early; None where this was not looked for."""

    @classmethod
    def of(cls, recording: "Recording | Measurement", slips: Slips | None = None) -> "Measurement":
        """Screen a recording, and correct it for dead time, dark counts and its background. A measurement is returned as it is.

        Args:
            recording: the recording.
            slips: by how many patterns its values came late or early; None to find that by its counts.

        Raises:
            InputError: there are more counts than the dead time allows, or the argument is no recording.
        """
        if isinstance(recording, Measurement):
            return recording
        if not isinstance(recording, Recording):  # pyright: ignore[reportUnnecessaryIsInstance] - a script may pass a path
            raise InputError(
                saw=f"a {type(recording).__name__}",
                expected="a recording",
                remedy="open the file first: open_recording(path)",
            )
        screening = screened(recording, slips)
        recording = screening.recording
        scheme = scheme_of(recording.plan)
        values, variance = light_of(recording, scheme.light_weights)
        if screening.inverted is not None:
            single = fixed_columns(scheme)
            variance[:, single] = light_of(screening.inverted, scheme.light_weights)[1][:, single]
        measurement = cls(
            plan=recording.plan,
            scheme=scheme,
            values=values,
            arrived=values,
            variance=variance,
            valid=recording.frame_valid & np.isfinite(values).all(axis=1),
            pattern_time_s=recording.pattern_time_s,
            frame_time_s=recording.frame_time_s,
            photon_counts=recording.photon_counts,
            findings=screening.findings,
            slips=screening.slips,
            background_known=recording.background is not None,
        )
        return measurement.lit_by(LightModel.of(recording.light, recording.calibration, recording.plan))

    def lit_by(self, light: LightModel) -> "Measurement":
        """Correct what arrived by another light model."""
        if light == self.light:
            return self
        before, after = (leak_variance_ratio(model.leak.value) for model in (self.light, light))
        values = without_leak(self.arrived, light.leak.value)
        loss_a_side = light.edge_loss.value / self.plan.superpixel
        lit = self.valid & np.isfinite(values).all(axis=1)
        mean_total = float((values[lit] @ self.scheme.light_weights).mean()) if light.ripples and lit.any() else 0.0
        values = without_ripples(values, self.pattern_time_s, light.ripples, mean_total)
        values = with_edge_light(values, self.scheme, self.plan.image_size, loss_a_side)
        ratio: Floats = np.full(self.pattern_time_s.shape, after / before)
        if light.ripples != self.light.ripples:  # what is divided by a dark lamp is noisier than what came
            dark, bright = (lamp_factor(self.pattern_time_s, model.ripples) for model in (light, self.light))
            ratio = ratio * (bright / dark) ** 2
        return replace(self, light=light, values=values, variance=self.variance * ratio)

    def first(self, frames: int) -> "Measurement":
        """Give the first frames."""
        return replace(
            self,
            values=self.values[:frames],
            variance=self.variance[:frames],
            valid=self.valid[:frames],
            pattern_time_s=self.pattern_time_s[:frames],
            arrived=self.arrived[:frames],
        )

    @property
    def edge_loss_a_side(self) -> float:
        """Share of a pattern pixel's light that is lost at each side that borders a dark one."""
        return self.light.edge_loss.value / self.plan.superpixel

    @cached_property
    def centre(self) -> Signals:
        """``(2,)``: centre of the signals along x and y, which the offsets of the patterns move away from 0."""
        reading = position_of(self.scheme)
        if not self.light.offsets:
            return np.zeros(2, np.complex128)
        offset = np.array([parameter.value for parameter in self.light.offsets])
        of_axis = offset[np.searchsorted(fixed_columns(self.scheme), reading.columns)]
        return as_signals(np.einsum("apk,ak->ap", reading.weights, of_axis))

    def __len__(self) -> int:
        """Give the number of frames, those that are not valid included."""
        return len(self.values)

    @cached_property
    def total(self) -> Floats:
        """``(frames,)``: total light S of each frame; 0 where the frame is not valid."""
        return np.where(self.valid[:, None], self.values, 0.0) @ self.scheme.light_weights

    @cached_property
    def steady_total(self) -> Floats:
        """``(frames,)``: total light without the noise of its measurement, but with the lamp's own flicker.

        Flicker changes the total and, in proportion, the sum of the position patterns of the same frame; measurement noise does
        not. The share of flicker in the third differences of the total is therefore the slope of their linear regression, that of
        the sum on that of the total, over the ratio of sum and total. Where the total is computed from the position patterns
        themselves, the two cannot be told apart, and the total is returned as it is.
        """
        columns = position_of(self.scheme).columns
        if np.count_nonzero(self.valid) < _FEWEST_FRAMES or self.scheme.light_weights[columns].any():
            return self.total
        steady = smooth(self.total, self.valid.astype(np.float64), orders=(1,)).values
        position_sum = np.where(self.valid, self.values[:, columns.ravel()].sum(axis=1), 0.0)
        whole = np.convolve(~self.valid, np.ones(4), "valid") == 0
        of_total, of_sum = np.diff(self.total, 3)[whole], np.diff(position_sum, 3)[whole]
        power, ratio = float(of_total @ of_total), float(position_sum.sum()) / max(float(self.total.sum()), 1e-300)
        share = float(of_total @ of_sum) / (ratio * power) if power > 0 and ratio > 0 else 0.0
        return steady + min(max(share, 0.0), 1.0) * (self.total - steady)

    @property
    def student_ratio(self) -> float:
        """Factor on a standard deviation by which 1.96 of it hold the truth with 95 % though the noise is only estimated.

        Noise that does not depend on the light is estimated from a median of differences between frames, which is as good as a
        quarter of as many degrees of freedom: Student's t takes the place of the normal distribution. 1 for photon counts.
        """
        if self.photon_counts:
            return 1.0
        freedom = max(1, int(np.count_nonzero(self.valid)) // 4)
        return coverage_factor(freedom) / coverage_factor(None)

    @property
    def smoothed(self) -> bool:
        """Whether values are divided by the total light as it is smoothed over frames."""
        return self.normalise in {"auto", "smoothed"}

    def observe(self, *, steady: bool, as_measured: bool = False) -> Observation:
        """Give what each frame says of the object's position.

        Args:
            steady: whether the total light, which enters every position and does not change with motion, is taken as
                ``steady_total``. For the paper's scheme that removes a third of the coefficients' variance.
            as_measured: whether values are left as they are where the lamp changes within a frame.

        Raises:
            InputError: the scheme has no position, or no frame is both valid and lit.
        """
        position = position_of(self.scheme)
        steady = steady and self.smoothed
        total = self.steady_total if steady else self.total
        lit = self.valid & (total > 0)
        self._require_light(total[self.valid])
        if not lit.any():
            raise InputError(
                saw=f"no frame with light in a recording of {len(self)} frames, {np.count_nonzero(self.valid)} of them valid",
                expected="frames whose total light is above 0",
                remedy="check light source, shutter and background, and the recording's timing report",
            )
        used = self.scheme.light_weights != 0
        squares = self.scheme.light_weights[used] ** 2
        total_variance = np.zeros_like(total) if steady else self.variance[:, used] @ squares
        values = self.values
        if self.smoothed and not as_measured:
            values = values * to_one_moment(self.steady_total, lit, self.pattern_time_s, self.scheme.light_weights)
        light = Light(values, self.variance, total, total_variance, lit, self.photon_counts)
        return Observation.of(position, light, self.centre)

    def image_values(self, *, steady_object: bool) -> ImageValues:
        """Give what the valid frames say of the image.

        Args:
            steady_object: whether the object stays inside the field, so that a change of the total light stems from the lamp
                and is divided out (smoothed over frames).

        Raises:
            InputError: there is no valid frame, or the scheme has no image.
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
        changes = self.normalise != "off" and steady_object
        if changes and len(frame) >= _FEWEST_FRAMES and (total > 0).any():
            lamp = smooth(total, np.ones(len(total)), orders=(1,)).values if self.smoothed else total
            lamp = np.maximum(lamp / lamp.mean(), _LEAST_LAMP)
        every, time_s = np.ones(len(frame), np.bool_), self.pattern_time_s[frame]
        bright = self.values[frame]
        if self.smoothed:
            bright = bright * to_one_moment(lamp, every, time_s, self.scheme.light_weights)
        values = ImageValues.of(
            self.scheme,
            frame=frame,
            pairs=rows.pairs[frame % len(rows.pairs)],
            values=bright,
            variance=self.variance[frame],
            time_s=time_s,
            lamp=lamp,
            size=self.plan.image_size,
            photon_counts=self.photon_counts,
        )
        ratio = difference_variance_ratio(self.light.leak.value)
        return replace(values, difference_variance=values.difference_variance * ratio)

    def light_change(self) -> float:
        """Give the largest change of the total light in the run, relative to its median.

        Means over tenths of the run are compared, so that noise does not count as change.
        """
        tenths = [float(np.mean(part)) for part in np.array_split(self.total[self.valid], 10) if len(part)]
        middle = float(np.median(tenths)) if tenths else 0.0
        return max(abs(tenth / middle - 1) for tenth in tenths) if middle > 0 else 0.0

    @staticmethod
    def _require_light(total: Floats) -> None:
        """Refuse a run whose mean light is not significantly above 0."""
        if len(total) < _FEWEST_FRAMES:
            return
        mean, error = float(np.mean(total)), float(np.std(total)) / np.sqrt(len(total))
        if mean < _SIGNIFICANT * error:
            raise InputError(
                saw=f"a mean light of {mean:.3g} with a standard error of {error:.2g}",
                expected="light well above the noise: an object to follow",
                remedy="check that the object is in the field, and light source and shutter",
            )
