"""Why a recording cannot be analysed, in words: looked for before the work, where it can be seen in the values themselves."""

from collections.abc import Generator
from contextlib import contextmanager
from typing import Final

import numpy as np

from instrument.measurement import HIGHEST_VALUE, Measurement
from instrument.reconstruction import Reconstruction
from instrument.recording import Recording
from instrument.tracking import Trajectory
from protocols import Floats, InputError

_RARE: Final = 0.01
"""Share of the values beyond all measure up to which these are masked."""

_SMALLEST: Final = 1e-12
_CERTAIN: Final = 5.0  # standard errors
_FIRST: Final = 4  # frames
_FAINT: Final = 0.2
"""Signal of a fringe over the total light, as of an object of bars that are finer than it: others have more."""

_ROOM_PX: Final = 4
"""Smallest object that must fit into the field beside its path."""

_CROSSES: Final = 0.3
"""Change of the total light from which on an object is taken to cross the border of the field."""

FEWEST_FRAMES: Final = 200
"""Frames in which all of an object must be inside for it to be told from a lamp that changes."""

_FEWEST_PHOTONS: Final = 6.0  # a frame


def refuse_size(recording: Recording) -> None:
    """Refuse values beyond all measure, whose squares no arithmetic bears. Single ones are masked by the screening.

    Raises:
        InputError: more than one of a hundred values of the valid frames is above 1e15, or all are below 1e-12 and not all 0.
    """
    values = np.abs(recording.values[recording.frame_valid])
    known = values[np.isfinite(values)]
    largest = float(known.max(initial=0.0))
    if np.count_nonzero(known > HIGHEST_VALUE) > _RARE * known.size or 0 < largest < _SMALLEST:
        raise InputError(
            saw=f"values up to {largest:.3g}",
            expected=f"counts, or light, between {_SMALLEST:g} and {HIGHEST_VALUE:g}",
            remedy="check the unit of the values and the settings of the counter",
        )


def refuse_hopeless(measurement: Measurement, recording: Recording | None = None) -> None:
    """Refuse values in which nothing can be found.

    Args:
        measurement: the light.
        recording: what it is of, which may know where the object was.

    Raises:
        InputError: no whole frame, no light, too few photons, or values without variation.
    """
    values = measurement.values[measurement.valid]
    if not len(values):
        raise InputError(
            saw=f"no frame of {len(measurement)} with a finite value for every pattern" + _found(measurement),
            expected="frames that were measured whole",
            remedy="look at the recording's values and its timing report, and repeat the run",
        )
    _refuse_dark(measurement, _out_of_field(recording))
    _refuse_flat(measurement)
    largest = float(np.abs(values).max(initial=0.0))
    # A scheme that only tracks shows the same patterns in every frame: of an object at rest all its frames are alike.
    same = np.ptp(values) if measurement.scheme.image_rows is None else np.ptp(values, axis=0).max()
    if len(values) > 1 and float(same) <= 1e-9 * largest:
        raise InputError(
            saw=f"a signal without variation: all {len(values)} frames have the same values, such as {values[0, 0]:.4g}",
            expected="values that change with the pattern",
            remedy="check that the counter counts the detector's pulses and that the modulator shows the patterns",
        )


def _found(measurement: Measurement) -> str:
    """What the screening of the counts found, in brackets."""
    return f" ({'; '.join(finding.text for finding in measurement.findings)})" if measurement.findings else ""


def _out_of_field(recording: Recording | None) -> str:
    """Say where the object was by stage and calibration, if it was never in the field; else where the stage was, if told."""
    if recording is None or recording.plan.motion is None:
        return ""
    motion, plan = recording.plan.motion, recording.plan
    ends_mm = motion.positions_mm(plan.run_time_s, [0.0, plan.run_time_s])
    known = None if recording.calibration is None else recording.calibration.displacement
    if known is not None and known.object_box_px is not None and known.object_at_mm is not None:
        scale = np.array([known.px_per_mm_x, known.px_per_mm_y])
        box = np.array(known.object_box_px).reshape(2, 2)
        boxes = [box + (place_mm - known.object_at_mm) * scale for place_mm in ends_mm]
        low, high = np.minimum(boxes[0][0], boxes[1][0]), np.maximum(boxes[0][1], boxes[1][1])
        beyond_px = float(np.maximum(-0.5 - high, low - (plan.image_size - 0.5)).max())
        if beyond_px > 0:
            return f"the object was never in the field, by the calibration {beyond_px:.0f} px away from it"
    return f"no object in the light while the stage went from {ends_mm[0]:.4g} to {ends_mm[1]:.4g} mm"


def _refuse_dark(measurement: Measurement, where: str) -> None:
    """Refuse a run whose light is not significantly above 0, and one of too few photons to tell where they come from."""
    total = measurement.total[measurement.valid]
    weights = measurement.scheme.light_weights
    used = weights != 0  # the variance of too few frames is infinite
    variance = measurement.variance[measurement.valid][:, used] @ weights[used] ** 2
    mean = float(total.mean())
    error = float(np.sqrt(variance.sum())) / len(total)
    unit = "counts" if measurement.photon_counts else "in the detector's unit"
    if np.isfinite(error) and mean < _CERTAIN * error:
        raise InputError(
            saw=f"{where or 'no object in the light'}: {mean:.3g} {unit} a frame on average, with a standard error "
            f"of {error:.2g}",
            expected="light well above the noise",
            remedy="check that the object was ever in the field, the stage's start and travel, light source and shutter",
        )
    if measurement.photon_counts and mean < _FEWEST_PHOTONS:
        raise InputError(
            saw=f"{mean:.2g} photons of the all-on light a frame",
            expected=f"{_FEWEST_PHOTONS:g} or more: from fewer nobody can tell where an object is",
            remedy="raise the light, or the time of a picture (a lower pattern_rate_hz)",
        )


def _refuse_flat(measurement: Measurement) -> None:
    """Refuse light that is the same for every pattern: no object stands in it."""
    rows = measurement.scheme.image_rows
    if rows is None:
        _refuse_flat_fringes(measurement)
        return
    if not measurement.valid[:_FIRST].all():
        return  # an object shows in the first patterns, which are the coarsest
    pair = [rows.positive, rows.negative]
    values = measurement.values[measurement.valid][:, pair]
    variance = np.maximum(measurement.variance[measurement.valid][:, pair].sum(axis=1), _SMALLEST)
    squares = np.diff(values, axis=1)[:, 0] ** 2 / variance
    count = len(squares)
    chance = _CERTAIN * float(np.sqrt(2 * count))
    total = float(measurement.total[measurement.valid].mean())
    # Of an object, the first pattern, which is all on, has that square alone, and the coarse ones together as much again.
    of_object = 2 * total**2 / float(variance.mean())
    if float(squares.sum()) < count + chance and of_object > 2 * chance:
        raise _flat(total, "pattern and its complement")


def _refuse_flat_fringes(measurement: Measurement) -> None:
    """Refuse light that is the same for all fringes of a scheme that only tracks: their signals are noise along both axes."""
    reading, valid = measurement.scheme.position, measurement.valid
    if reading is None or reading.period_px is None:
        return
    total, values = measurement.total[valid], measurement.values[valid]
    if not (total > 0).all():
        return
    signal = reading.signal(values, total)
    of_parts = np.einsum("apk,fak->fa", reading.weights**2, measurement.variance[valid][:, reading.columns])
    variance = np.maximum(of_parts, _SMALLEST) / total[:, None] ** 2  # of both parts together, which are alike
    count = len(total)
    squares = np.abs(signal) ** 2 / variance
    chance = _CERTAIN * float(np.sqrt(count))
    of_object = _FAINT**2 * float((1 / variance).sum(axis=0).min())
    if (squares.sum(axis=0) < count + chance).all() and of_object > 2 * chance:
        raise _flat(float(total.mean()), "fringe")


def _flat(total: float, of_what: str) -> InputError:
    return InputError(
        saw=f"light of {total:.4g} a frame that is the same for every {of_what}: no object in it",
        expected="an object that the patterns cut out of the light",
        remedy="look for ambient light on the detector, check that the object is in the field and that the modulator "
        "shows the patterns",
    )


def refuse_beyond(measurement: Measurement, trajectory: Trajectory | None) -> None:
    """Refuse a path that leaves no room for an object in the field, and name what may have made it so wide.

    Raises:
        InputError: the path is as wide as the field along an axis, and there is an image to be made.
    """
    if trajectory is None or measurement.scheme.image_rows is None or not measurement.valid.any():
        return
    wide_px: Floats = np.ptp(trajectory.displacement_px[measurement.valid], axis=0)
    size, change = measurement.plan.image_size, measurement.light_change()
    if not wide_px.max() > size - _ROOM_PX:
        return
    saw = f"a path of {wide_px[0]:.0f}, {wide_px[1]:.0f} px (x, y) in a field of {size} px"
    if change > _CROSSES:
        raise InputError(
            saw=f"{saw}, and light that changes by {100 * change:.0f} %",
            expected=f"an object all of which is inside the field in {FEWEST_FRAMES} frames or more",
            remedy="if it crosses the field, let it go more slowly, or record the frames faster; if it passes by, as one "
            "that is larger than the field, take the region wide",
        )
    raise InputError(
        saw=f"{saw}, though the light stays",
        expected="an object that moves within the field",
        remedy="raise the light if its noise is taken for motion; look for what else changes the light, for fringes that are "
        "wired otherwise than planned, and for an object that goes more than half a fringe between two frames",
    )


@contextmanager
def numbers_that_end() -> Generator[None, None, None]:
    """Let no arithmetic warning through and no singular matrix: what came of them is looked at by ``refuse_endless``.

    Raises:
        InputError: equations without a solution.
    """
    try:
        with np.errstate(all="ignore"):
            yield
    except (np.linalg.LinAlgError, ArithmeticError) as error:
        raise _nothing_found(f"equations without a solution ({error})") from error


def refuse_endless(trajectory: Trajectory | None, reconstruction: Reconstruction | None) -> None:
    """Refuse results that are no numbers.

    Raises:
        InputError: the path or the image is not finite.
    """
    found: dict[str, Floats] = {}
    if trajectory is not None:
        found["a path"] = trajectory.displacement_px
    if reconstruction is not None:
        found["an image"] = reconstruction.image
    for what, numbers in found.items():
        if not np.isfinite(numbers).all():
            raise _nothing_found(f"{what} that is not finite")


def _nothing_found(saw: str) -> InputError:
    return InputError(
        saw=f"{saw}: the values say nothing of an object, or contradict each other",
        expected="values that follow from one object, its light and its motion",
        remedy="look at the values and the timing report for lost or shifted patterns and wild counts, and repeat the run",
    )
