"""Why a recording cannot be analysed, in words: looked for before the work, where it can be seen in the values themselves."""

from collections.abc import Generator
from contextlib import contextmanager
from typing import Final

import numpy as np

from instrument.measurement import Measurement
from instrument.reconstruction import Reconstruction
from instrument.recording import Recording
from instrument.tracking import Trajectory
from protocols import Floats, InputError

_LARGEST: Final = 1e15  # beyond, whole counts are not whole any more in double precision
_SMALLEST: Final = 1e-12
_EXCHANGED: Final = 0.25  # of the light: less for the all-on pattern than for its dark complement, and by far
_CERTAIN: Final = 5.0  # standard errors


def refuse_size(recording: Recording) -> None:
    """Refuse values beyond all measure, whose squares no arithmetic bears.

    Raises:
        InputError: the largest value of the valid frames is above 1e15, or below 1e-12 and not 0.
    """
    values = recording.values[recording.frame_valid]
    largest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
    if largest > _LARGEST or 0 < largest < _SMALLEST:
        raise InputError(
            saw=f"values up to {largest:.3g}",
            expected=f"counts, or light, between {_SMALLEST:g} and {_LARGEST:g}",
            remedy="check the unit of the values and the settings of the counter",
        )


def refuse_hopeless(measurement: Measurement) -> None:
    """Refuse values in which nothing can be found.

    Raises:
        InputError: values without variation, or pairs of patterns that are exchanged.
    """
    values = measurement.values[measurement.valid]
    if not len(values):
        raise InputError(
            saw=f"no frame of {len(measurement)} with a finite value for every pattern",
            expected="frames that were measured whole",
            remedy="look at the recording's values and its timing report, and repeat the run",
        )
    largest = float(np.abs(values).max(initial=0.0))
    # A scheme that only tracks shows the same patterns in every frame: of an object at rest all its frames are alike.
    same = np.ptp(values) if measurement.scheme.image_rows is None else np.ptp(values, axis=0).max()
    if len(values) > 1 and float(same) <= 1e-9 * largest:
        raise InputError(
            saw=f"a signal without variation: all {len(values)} frames have the same values, such as {values[0, 0]:.4g}",
            expected="values that change with the pattern",
            remedy="check that the counter counts the detector's pulses and that the modulator shows the patterns",
        )
    _refuse_exchanged(measurement)


def _refuse_exchanged(measurement: Measurement) -> None:
    """Look at the frames whose Hadamard pattern is all on: its light is all there is, and its complement's none."""
    rows = measurement.scheme.image_rows
    if rows is None:
        return
    pairs = rows.pairs[np.arange(len(measurement)) % len(rows.pairs)]
    frames = np.flatnonzero((pairs == 0).all(axis=1) & measurement.valid)
    columns = [(k, column.sign) for k, column in enumerate(measurement.scheme.columns) if column.role == "hadamard"]
    bright = [k for k, sign in columns if sign > 0]
    dark = [k for k, sign in columns if sign < 0]
    if not len(frames) or len(bright) != 1 or len(dark) != 1:
        return
    on, off = measurement.values[frames, bright[0]], measurement.values[frames, dark[0]]
    error = float(np.sqrt(measurement.variance[frames][:, [bright[0], dark[0]]].sum()))
    total = float(on.sum() + off.sum())
    if total <= 0 or float(on.sum()) >= _EXCHANGED * total or float(off.sum() - on.sum()) < _CERTAIN * error:
        return
    raise InputError(
        saw=f"H- before H+: the all-on pattern gives H+/S = {float(on.sum()) / total:.2f}",
        expected="nearly 1",
        remedy="look for a sync edge too few or too many at the start of the run, or for a modulator that inverts its pictures",
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
