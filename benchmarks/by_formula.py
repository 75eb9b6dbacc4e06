"""Recordings computed from the formulas of the model, for fields and runs that the simulated bench would take hours over.

The light of every pattern is that of the analysis's own model, without dithering's grey and with noise added: so that cost can be
measured. How good a result is, the simulated bench says, which shares no code with the analysis.
"""

from collections.abc import Callable

import numpy as np

from instrument.plan import Plan
from instrument.reconstruction import Field, FixedPatterns, Region, ShiftedHadamard
from instrument.recording import Recording
from instrument.schemes import image_rows_of, scheme_of
from protocols import Floats, Singles, Truth


def by_formula(
    plan: Plan, image: Floats, path: Callable[[Floats], Floats], *, sigma: float = 0.1, seed: int = 0
) -> Recording:
    """Compute a run of the scheme ``fourier-hadamard``.

    Args:
        plan: what is shown.
        image: ``(m, m)`` transmission of the object at frame 0; it must stay in the field.
        path: seconds ``(n,)`` to displacement ``(n, 2)``.
        sigma: noise on every lit pixel.
        seed: of the noise.
    """
    scheme, size = scheme_of(plan), plan.image_size
    rows, field, whole = image_rows_of(scheme), Field(plan.image_size), Region.whole(plan.image_size)
    times_s = (np.arange(plan.patterns, dtype=np.float64) + 0.5) * plan.picture_time_s
    places = path(times_s).reshape(plan.frames, plan.patterns_per_frame, 2)
    values = np.empty(places.shape[:2])
    fixed = [k for k in range(plan.patterns_per_frame) if k not in {rows.positive, rows.negative}]
    patterns = FixedPatterns.of(field.acting(scheme.fixed_patterns), field, whole)
    seen: Singles = image.astype(np.float32)
    values[:, fixed] = patterns.values(patterns.maps(seen), places[:, fixed])[0]
    for column, sign in ((rows.positive, 1), (rows.negative, -1)):
        differences = ShiftedHadamard.single(rows.pairs[: plan.frames], places[:, column], field, whole)
        values[:, column] = (image.sum() + sign * differences.matvec(seen.ravel())) / 2
    values += np.random.default_rng(seed).normal(size=values.shape) * sigma * size / np.sqrt(2)
    middle_px = path((np.arange(plan.frames, dtype=np.float64) + 0.5) * plan.frame_time_s)
    return Recording(
        plan=plan,
        values=values,
        frame_valid=np.ones(plan.frames, np.bool_),
        picture_time_s=plan.picture_time_s,
        truth=Truth(displacement_px=middle_px - middle_px[0], image=image),
    )
