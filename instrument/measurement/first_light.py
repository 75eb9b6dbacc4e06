"""What a run shows of the bench's light before anything is known of motion and image: leak, and offsets.

Offsets of the position patterns are found as the centre of the circle on which the coefficients lie.

A periodic signal of an object that moves goes round a circle. Light that has nothing to do with the object's place, such as that
of a background, moves the circle's centre away from 0. That is seen from the run alone, whatever the light is.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from instrument.measurement.detector import noise_variance
from instrument.measurement.finding import Finding
from instrument.measurement.leak import leak_seen
from instrument.measurement.light_model import Parameter, Source
from instrument.measurement.measurement import Measurement
from instrument.measurement.ripple import lamp_factor, ripples_seen
from instrument.numerics import Circle, fit_circle
from instrument.recording import Recording
from instrument.schemes import Signals
from protocols import Floats, Mask

_BLOCK_FRAMES: Final = 25
"""Frames that are averaged at most before the circle is fitted."""

_CHORD: Final = 0.6
"""Way between successive averages, in radii, above which fewer frames are averaged: an arc's mean lies inside the circle."""

_FEWEST_BLOCKS: Final = 8
"""Averages from which a circle can be told from chance."""

_KNOWN: Final = 0.5
"""Standard deviation of the centre, in radii, above which the arc is too short to say where the centre is."""

_LEAST_RADIUS: Final = 0.08
"""Radius below which points may lie on a circle by the errors of dithered patterns alone: these are about 0.02."""

_ROUND: Final = 0.15
"""Scatter about the circle, in radii, above which the points make no circle: the object hardly moves along this axis."""

_DITHERING_PX: Final = 1.4
"""Standard deviation of the error that dithered patterns add to a signal, times the field's size: 0.02 px^2 at a period of
64 px in 128 px and an amplitude of 0.8. It is another one after each pixel of way, and less the more pixels an object has."""

_OF_EDGES: Final = 0.03
"""Standard deviation of a centre that edges of mirrors alone move, over the total light."""

_DEEP: Final = 0.5
"""Brightness of a lamp over its mean to which flicker that is deep makes it fall."""

_DARK: Final = 0.2
"""Brightness of a lamp over its mean below which a frame is left out."""

_SIGNIFICANT: Final = 12.0
"""Squared distance of the centre from 0, in units of its covariance, from which on it counts: chance 1 in 400."""


def first_light(recording: Recording | Measurement) -> Measurement:
    """Correct a recording by the leak and the offsets that the run itself shows, where it says enough; see the module.

    Numbers of the light model that were given or calibrated are kept. A measurement whose light was found is returned as it is.

    Raises:
        InputError: there are more counts than the dead time allows, or no frame is usable.
    """
    measurement = Measurement.of(recording)
    if measurement.light_found:
        return measurement
    light = measurement.light
    if light.leak.free:
        seen = leak_seen(measurement.arrived, measurement.variance, measurement.valid, measurement.scheme)
        measurement = measurement.lit_by(light.model_copy(update={"leak": seen or Parameter(value=0.0)}))
    return replace(_with_offsets(_with_ripples(_with_offsets(measurement))), light_found=True)


def _with_ripples(measurement: Measurement) -> Measurement:
    """Take out what ripples in the total light."""
    valid, weights = measurement.valid, np.abs(measurement.scheme.light_weights)
    reading = measurement.scheme.position
    if not valid.any() or not weights.any():
        return measurement
    amplitude: Floats | None = None
    total = np.where(valid, measurement.total, 0.0)
    if reading is not None and reading.period_px is not None and (total[valid] > 0).all():
        amplitude = np.abs(measurement.observe(steady=False).signal) * total[:, None]
    moment_s = measurement.pattern_time_s @ weights / weights.sum()
    ripples = ripples_seen(total, amplitude, valid, moment_s)
    return _without_dark(_noise_anew(measurement.lit_by(measurement.light.model_copy(update={"ripples": ripples}))))


def _noise_anew(measurement: Measurement) -> Measurement:
    """Estimate noise that does not depend on the light again where the lamp flickers deeply: flicker seemed to be noise."""
    lamp = lamp_factor(measurement.pattern_time_s, measurement.light.ripples)
    if measurement.photon_counts or lamp.min() > _DEEP:
        return measurement
    brightness = np.asarray(lamp.mean(axis=1), np.float64)
    noise = noise_variance(measurement.values, measurement.scheme.light_weights, measurement.valid, brightness)
    return replace(measurement, variance=noise / lamp**2)


def _without_dark(measurement: Measurement) -> Measurement:
    """Leave out the frames in which a lamp that flickers is nearly dark, and say so: divided by it, they are noise."""
    ripples = measurement.light.ripples
    dark = measurement.valid & (lamp_factor(measurement.pattern_time_s, ripples).min(axis=1) < _DARK)
    if not dark.any():
        return measurement
    frames = np.flatnonzero(dark)
    strongest = max(ripples, key=lambda ripple: ripple.amplitude * ripple.lamp_share)
    text = f"the lamp flickers by {100 * strongest.amplitude:.0f} % at {strongest.frequency_hz:.0f} Hz"
    sentence = (
        f"{text}: {len(frames)} frames in which it is darker than a {1 / _DARK:.0f}th of its mean are left out; "
        "feed the lamp with direct current, or record longer"
    )
    finding = Finding("lamp", tuple(frames.tolist()), text, sentence)
    return replace(measurement, valid=measurement.valid & ~dark, findings=(*measurement.findings, finding))


def _with_offsets(measurement: Measurement) -> Measurement:
    reading, light = measurement.scheme.position, measurement.light
    few = np.count_nonzero(measurement.valid) < _FEWEST_BLOCKS
    if reading is None or reading.period_px is None or few or any(not offset.free for offset in light.offsets):
        return measurement
    found = measurement.lit_by(light.model_copy(update={"offsets": ()})).observe(steady=True)
    offsets: dict[int, Parameter] = {}
    for axis, columns in enumerate(reading.columns.tolist()):
        response = reading.response[axis]
        circle = _circle(
            found.signal[:, axis], found.valid, reading.period_px, _DITHERING_PX / measurement.plan.image_size
        )
        if circle is None:
            offsets |= dict.fromkeys(columns, Parameter(value=0.0))
            continue
        circle = _near_zero(circle) if measurement.background_known else circle
        sigma = np.sqrt(np.einsum("kp,pq,kq->k", response, circle.covariance, response)).tolist()
        value = (response @ circle.centre).tolist() if _counts(circle) else [0.0] * len(columns)
        source: Source = "fitted" if _counts(circle) else "assumed"
        offsets |= {
            column: Parameter(value=of, sigma=error, source=source)
            for column, of, error in zip(columns, value, sigma, strict=True)
        }
    return measurement.lit_by(light.model_copy(update={"offsets": tuple(offsets[k] for k in sorted(offsets))}))


def _near_zero(circle: Circle) -> Circle:
    """Weigh the centre with the knowledge that a background was taken off: an arc that is too short would make up another."""
    certainty = np.linalg.inv(circle.covariance)
    covariance = np.asarray(np.linalg.inv(certainty + np.eye(2) / _OF_EDGES**2), np.float64)
    return replace(circle, centre=np.asarray(covariance @ certainty @ circle.centre, np.float64), covariance=covariance)


def _counts(circle: Circle) -> bool:
    """Whether the centre is not 0 by more than chance."""
    return float(circle.centre @ np.linalg.solve(circle.covariance, circle.centre)) > _SIGNIFICANT


def _circle(signal: Signals, valid: Mask, period_px: float, dithering: float) -> Circle | None:
    """Fit a circle to the means of a signal over as many frames as move little, and add what dithering makes uncertain."""
    block = _BLOCK_FRAMES
    while True:
        points = _means(signal, valid, block)
        circle = fit_circle(points) if len(points) >= _FEWEST_BLOCKS else None
        if circle is None:
            return None
        chord = float(np.percentile(np.hypot(*np.diff(points, axis=0).T), 95)) / max(circle.radius, 1e-12)
        if chord <= _CHORD:
            places = max(1.0, circle.turned_rad * period_px / (2 * np.pi))
            circle = replace(circle, covariance=circle.covariance + circle.leverage * (dithering**2 / places))
            return circle if _makes_a_circle(circle) else None
        if block == 1:
            return None
        block = max(1, min(block - 1, int(block * _CHORD / chord)))


def _makes_a_circle(circle: Circle) -> bool:
    """Whether the points lie on a circle whose centre is known."""
    round_ = circle.radius > _LEAST_RADIUS and circle.scatter < _ROUND * circle.radius
    return round_ and float(np.sqrt(circle.covariance.trace())) < _KNOWN * circle.radius


def _means(signal: Signals, valid: Mask, block: int) -> Floats:
    """``(blocks, 2)``: means over blocks of valid frames."""
    parts = np.stack([signal.real, signal.imag], axis=1)[valid]
    whole = len(parts) // block * block
    return np.asarray(parts[:whole].reshape(-1, block, 2).mean(axis=1), np.float64)
