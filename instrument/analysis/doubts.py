"""Reasons to doubt a result, each in a sentence with its likeliest cause and what to do about it."""

from typing import Final

import numpy as np

from instrument.analysis.leaving import share_inside
from instrument.analysis.position_doubts import position_doubts
from instrument.measurement import Measurement
from instrument.reconstruction import Reconstruction
from instrument.tracking import Trajectory

_LIGHT_CHANGE: Final = 0.05
"""Relative change of the total light above which the figures warn."""

_SIGMAS: Final = 4.0
"""Standard errors that noise alone may change it by."""

_INSIDE: Final = 0.98
"""Share of the object that is inside the field where it stays there."""

_LIT: Final = 0.25
"""Transmission over that of the brightest pixel above which a pixel is lit."""

_BORDER: Final = 0.1
"""Share of the pixels along a side of the image that are lit from which on the object reaches across that side."""

_MISFIT: Final = 1.5
"""Misfit above which the figures warn."""

_OVERFIT: Final = 0.5
"""Unknowns of an image over the values that it was found from, above which motion and image explain each other's errors."""

_LEFT_OVER: Final = 0.6
"""Misfit below which the same is so of an image whose unknowns nobody counted."""

_FEW_FRAMES: Final = 64
"""Frames below which no image helps to find the path."""

_VAGUE: Final = 1 / 8
"""Standard deviation over the period of the fringes above which a path may be off by whole periods: errors of half a
period, which lead to a wrong one, are then within four standard deviations."""


def doubts_of(
    measurement: Measurement, trajectory: Trajectory | None, reconstruction: Reconstruction | None
) -> tuple[str, ...]:
    """Give the reasons to doubt path and image of a run, beside what was found in its counts and what its stage did.

    Args:
        measurement: measurement that was analysed.
        trajectory: path found; None where the scheme has no position.
        reconstruction: image found; None where the scheme has none.
    """
    used = int(np.count_nonzero(measurement.valid))
    passes = reconstruction is not None and reconstruction.wide
    return (
        *(() if passes else _light_doubts(measurement, stays=_stays(trajectory, reconstruction))),
        *_border_doubts(used, trajectory, reconstruction),
        *_frame_doubts(used, trajectory, reconstruction),
        *(() if passes else _path_doubts(measurement, trajectory)),
        *(() if passes else _position_doubts(measurement, trajectory, reconstruction)),
        *(_misfit_doubts(reconstruction) if trajectory is None or used >= _FEW_FRAMES else ()),
        *_moment_doubts(measurement),
    )


def _position_doubts(
    measurement: Measurement, trajectory: Trajectory | None, reconstruction: Reconstruction | None
) -> tuple[str, ...]:
    """Say what the position values say against each other, where there is a path by them."""
    if trajectory is None:
        return ()
    background = reconstruction is not None and reconstruction.still is not None
    return position_doubts(measurement, with_image=trajectory.method == "joint", beside_background=background)


def _path_doubts(measurement: Measurement, trajectory: Trajectory | None) -> tuple[str, ...]:
    """Say that the path may be off by whole periods of the fringes."""
    sigma_px = vague_px(measurement, trajectory)
    position = measurement.scheme.position
    if sigma_px is None or position is None:
        return ()
    vague = (
        f"the displacement is known to {sigma_px:.3g} px only, and fringes repeat every {position.period_px:.3g} px, so that the "
        "path may be off by whole periods: take more light, or more frames"
    )
    return (vague,)


def vague_px(measurement: Measurement, trajectory: Trajectory | None) -> float | None:
    """Give the uncertainty of a path that may be off by whole periods of the fringes; None where it is not so large."""
    position = measurement.scheme.position
    if trajectory is None or position is None or position.period_px is None or np.count_nonzero(measurement.valid) < 2:
        return None
    sigma_px = float(np.median(trajectory.sigma_px[measurement.valid].max(axis=1)))
    return sigma_px if _VAGUE * position.period_px < sigma_px < np.inf else None


def _moment_doubts(measurement: Measurement) -> tuple[str, ...]:
    """Say what no run of moments can tell: whose light its centroid is of. The noise alone is in their uncertainty."""
    position = measurement.scheme.position
    if position is None or position.period_px is not None or measurement.background_known:
        return ()
    why = (
        "moments take all light for the object's: a background or ambient light makes displacement and speed too small by its "
        "share of the light, which the stated intervals do not cover; record a background and give it with --background, "
        "or use a scheme of fringes"
    )
    return (why,)


def _chance_of_light(measurement: Measurement) -> float:
    """Relative change of the light by which tenths of a run differ by noise alone."""
    weights, valid = measurement.scheme.light_weights, measurement.valid
    used = weights != 0
    variance = measurement.variance[valid][:, used] @ weights[used] ** 2
    total = float(np.median(measurement.total[valid]))
    of_tenth = float(np.sqrt(variance.mean() / max(len(variance) / 10, 1.0)))
    return _SIGMAS * measurement.student_ratio * of_tenth / total if total > 0 and np.isfinite(of_tenth) else 0.0


def _stays(trajectory: Trajectory | None, reconstruction: Reconstruction | None) -> bool:
    """Whether the object stays in the field by its own image and path."""
    if reconstruction is None or not (reconstruction.image > 0).any():
        return False
    if trajectory is None:
        return True
    seen = trajectory.displacement_px[np.isfinite(trajectory.sigma_px).all(axis=1)]
    return bool(len(seen)) and float(share_inside(reconstruction.at_patterns, seen).min()) > _INSIDE


def entangled(reconstruction: Reconstruction, values: int) -> bool:
    """Whether an image has so many unknowns that motion and image explain each other's errors."""
    if reconstruction.unknowns is None:
        return bool(reconstruction.misfit < _LEFT_OVER)
    return reconstruction.unknowns > _OVERFIT * values


def _frame_doubts(used: int, trajectory: Trajectory | None, reconstruction: Reconstruction | None) -> tuple[str, ...]:
    """Say for what there are too few frames."""
    if used < 2 and trajectory is not None:
        image = "" if reconstruction is None else ", and its image is hardly more than its total light"
        return (f"one frame cannot tell of a motion{image}: record more frames",)
    if reconstruction is None:
        return ()
    if used < _FEW_FRAMES:
        path = "the path is that of the position patterns alone, with an uncertainty that their own scatter tells"
        few = (
            f"{used} frames are too few for an image: it is a guess{'' if trajectory is None else f', and {path}'}; record "
            f"{_FEW_FRAMES} or more, better some hundred"
        )
        return (few,)
    if trajectory is None:
        return ()
    if entangled(reconstruction, used):
        why = (
            "too few frames to judge the result: motion and image have half as many unknowns as there are values and explain "
            "their noise too, so that no uncertainty is stated; record more frames"
        )
        return (why,)
    return ()


def _border_doubts(used: int, trajectory: Trajectory | None, reconstruction: Reconstruction | None) -> tuple[str, ...]:
    """Say that the object may be larger than the field: its image goes from one border to the other of what stays inside."""
    if reconstruction is None or trajectory is None or used < _FEW_FRAMES or reconstruction.wide:
        return ()
    if not crosses_all(reconstruction):
        return ()
    why = (
        "the image goes from border to border of what stays inside the field: of an object that is larger than the field, "
        "neither path nor image can be trusted; take the region wide if it passes by, or "
        "make it smaller on the modulator"
    )
    return (why,)


def crosses_all(reconstruction: Reconstruction) -> bool:
    """Whether an image goes from one border to the other of what stays inside the field."""
    area, image = reconstruction.region, reconstruction.at_patterns
    part = image[area.top : area.top + area.height, area.left : area.left + area.width]
    lit = part > _LIT * part.max()
    left, right, top, bottom = (float(side.mean()) for side in (lit[:, 0], lit[:, -1], lit[0], lit[-1]))
    return max(min(left, right), min(top, bottom)) >= _BORDER


def _light_doubts(measurement: Measurement, *, stays: bool) -> tuple[str, ...]:
    """Say what may change the light, unless the object was found to come into the field or to leave it."""
    found: list[str] = []
    light_change = measurement.light_change()
    crosses = any(finding.kind in {"comes into the field", "leaves the field"} for finding in measurement.findings)
    if not crosses and light_change > max(_LIGHT_CHANGE, _chance_of_light(measurement)):
        change = f"the field's total light changed by {100 * light_change:.0f} % in the run: "
        found.append(
            change
            + "the object stays inside by its own path, so that the lamp drifts, which is divided out and makes dark frames "
            "noisier, or the field is not evenly lit, which bends the path: steady the lamp, or give the field's profile"
            if stays
            else change
            + "a lamp that drifts is allowed for, an object that leaves the field is not: keep it inside, or record "
            "fewer frames"
        )
    return tuple(found)


def _misfit_doubts(reconstruction: Reconstruction | None) -> tuple[str, ...]:
    """Say what may be left unexplained."""
    if reconstruction is None or not reconstruction.misfit > _MISFIT:
        return ()
    left = (
        f"motion and image leave {reconstruction.misfit:.1f} times the noise unexplained: doubt both; look for an object that "
        "leaves the field or turns, or counts beyond the linear limit; in very much light, detail finer than a pixel does it too"
    )
    return (left,)
