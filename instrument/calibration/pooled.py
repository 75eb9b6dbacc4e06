"""Several measurements of the same displacement made one: their mean by their covariances.

Where they differ by more than their own uncertainties say, which runs of a real bench do (light that is uneven, a controller that
lags), the covariance of the mean is enlarged by what they differ, as in ``line_fit`` (the Birge ratio of metrology: R. T. Birge,
Phys. Rev. 40, 207 (1932)).
"""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Final

import numpy as np

from instrument.config import DisplacementSection
from protocols import Floats, InputError

_OUTLIER: Final = 6.0  # standard deviations from the mean of the others
_LEAST_OUTLIER: Final = 0.01  # of the scale: what differs by less is no mistake
_AXES: Final = 2


def pooled(sections: Mapping[str, DisplacementSection], date: datetime | None = None) -> DisplacementSection:
    """Give the displacement that several measurements say together.

    Args:
        sections: each measurement by the name that messages call it; one at least. One is given back as it is.
        date: of the calibration; None for now.

    Raises:
        InputError: measurements in pixels of different sizes; or one that does not agree with the others.
    """
    names, every = list(sections), list(sections.values())
    _refuse_other_grids(names, every)
    if len(every) == 1:
        return every[0]
    _refuse_outlier(names, every)
    mean, covariance, scatter = _mean(every)
    (xx, xy), (yx, yy) = covariance.tolist()
    return DisplacementSection(
        date=date or datetime.now(UTC),
        image_size=every[0].image_size,
        superpixel=every[0].superpixel,
        px_per_mm_x=float(mean[0]),
        px_per_mm_y=float(mean[1]),
        covariance=((xx, (xy + yx) / 2), ((xy + yx) / 2, yy)),
        degrees_of_freedom=_AXES * (len(every) - 1) if scatter > 1 else None,
        method=every[0].method,
        rms_residual_px=float(np.sqrt(np.mean([(each.rms_residual_px or 0.0) ** 2 for each in every]))),
    )


def _mean(sections: Sequence[DisplacementSection]) -> tuple[Floats, Floats, float]:
    """Mean ``(2,)``, its covariance ``(2, 2)``, and the root of chi-square over its degrees of freedom."""
    places = np.array([(each.px_per_mm_x, each.px_per_mm_y) for each in sections])
    weights: Floats = np.asarray(np.linalg.inv(np.array([each.covariance for each in sections])), np.float64)
    covariance: Floats = np.asarray(np.linalg.inv(weights.sum(axis=0)), np.float64)
    mean: Floats = covariance @ np.einsum("nab,nb->a", weights, places)
    freedom = _AXES * (len(sections) - 1)
    residual: Floats = places - mean
    square = float(np.einsum("na,nab,nb->", residual, weights, residual))
    scatter = float(np.sqrt(square / freedom)) if freedom else 1.0
    return mean, np.asarray(covariance * max(1.0, scatter) ** 2, np.float64), scatter


def _refuse_other_grids(names: Sequence[str], sections: Sequence[DisplacementSection]) -> None:
    first = sections[0]
    for name, each in zip(names, sections, strict=True):
        if (each.image_size, each.superpixel) != (first.image_size, first.superpixel):
            raise InputError(
                saw=f"{first.image_size} px of {first.superpixel} x {first.superpixel} mirrors in {names[0]}, and "
                f"{each.image_size} px of {each.superpixel} x {each.superpixel} in {name}",
                expected="pixels of one size: a calibration holds for one",
                remedy="calibrate with those of each size by themselves",
            )


def _refuse_outlier(names: Sequence[str], sections: Sequence[DisplacementSection]) -> None:
    """Refuse the measurement that is farthest from all others, if that is no chance."""
    worst, deviation, relative = 0, 0.0, 0.0
    for k, each in enumerate(sections):
        others, covariance, _ = _mean([*sections[:k], *sections[k + 1 :]])
        off = np.array([each.px_per_mm_x, each.px_per_mm_y]) - others
        sigmas = float(np.sqrt(off @ np.linalg.inv(covariance + np.array(each.covariance)) @ off))
        if sigmas > deviation:
            worst, deviation, relative = k, sigmas, float(np.hypot(*off) / np.hypot(*others))
    if deviation > _OUTLIER and relative > _LEAST_OUTLIER:
        raise InputError(
            saw=f"a displacement by {names[worst]} that is {100 * relative:.1f} % from that by the others, "
            f"{deviation:.1f} standard deviations",
            expected="measurements of one bench that agree",
            remedy="look for missed steps, a loose object or changed optics in that one, and leave it out",
        )
