"""The mean of several measurements, with numbers that a pencil gives."""

from datetime import UTC, datetime

import pytest

from instrument.calibration import pooled
from instrument.config import DisplacementSection
from protocols import InputError

DATE = datetime(2026, 1, 2, tzinfo=UTC)


def section(x: float, y: float, variance: float, *, size: int = 32, rms: float = 0.1) -> DisplacementSection:
    return DisplacementSection(
        date=DATE,
        image_size=size,
        superpixel=4,
        px_per_mm_x=x,
        px_per_mm_y=y,
        covariance=((variance, 0.0), (0.0, variance)),
        method="moving run",
        rms_residual_px=rms,
    )


def test_the_mean_is_weighted_by_the_uncertainties() -> None:
    """Weights 100 and 25: (100 x 2 + 25 x 2.1) / 125 = 2.02, variance 1 / 125; both differ by 0.1, half their sigma of 0.22."""
    found = pooled({"a": section(2.0, 1.0, 0.01, rms=0.3), "b": section(2.1, 1.0, 0.04, rms=0.4)}, DATE)
    assert (found.px_per_mm_x, found.px_per_mm_y) == pytest.approx((2.02, 1.0))
    assert found.covariance[0] == pytest.approx((0.008, 0.0))
    assert found.covariance[1] == pytest.approx((0.0, 0.008))
    assert found.degrees_of_freedom is None
    assert found.rms_residual_px == pytest.approx((0.125) ** 0.5)
    assert (found.method, found.date, found.image_size, found.superpixel) == ("moving run", DATE, 32, 4)


def test_measurements_that_differ_by_more_than_they_say_enlarge_the_uncertainty() -> None:
    """Two of sigma 0.01, 0.03 from their mean along x: chi-square 2 x 9 = 18 over 2 degrees of freedom, a scatter of 3."""
    found = pooled({"a": section(5.0, 1.0, 1e-4), "b": section(5.06, 1.0, 1e-4)})
    assert found.px_per_mm_x == pytest.approx(5.03)
    assert found.covariance[0][0] == pytest.approx(9 * 1e-4 / 2)
    assert found.degrees_of_freedom == 2
    three = pooled({name: section(x, 1.0, 1e-4) for name, x in (("a", 5.0), ("b", 5.06), ("c", 5.03))})
    assert three.degrees_of_freedom == 4


def test_one_measurement_is_what_it_is() -> None:
    only = section(2.0, 1.0, 0.01)
    assert pooled({"a": only}) is only


def test_one_that_does_not_agree_is_named() -> None:
    good = {name: section(2.0 + k / 1000, 1.0, 1e-6) for k, name in enumerate("abc")}
    pooled(good)
    with pytest.raises(InputError, match=r"a displacement by d\.h5 that is 1\.9 % from that by the others"):
        pooled({**good, "d.h5": section(2.0, 1.042, 1e-6)})
    pooled({**good, "d.h5": section(2.0, 1.042, 1e-4)})  # 4 of its standard deviations
    pooled({**good, "d.h5": section(2.0, 1.02, 1e-6)})  # less than a hundredth


def test_pixels_of_two_sizes_are_refused() -> None:
    with pytest.raises(InputError, match=r"32 px of 4 x 4 mirrors in a, and 64 px of 4 x 4 in b"):
        pooled({"a": section(2.0, 1.0, 0.01), "b": section(4.0, 2.0, 0.01, size=64)})
