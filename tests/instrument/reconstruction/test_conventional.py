"""The inverse Hadamard transform by hand, and against pictures that others measured and published."""

import numpy as np
import pytest
from PIL import Image

from instrument.patterns import hadamard_order, hadamard_signs
from instrument.patterns.hadamard import HadamardOrder
from instrument.reconstruction import inverse_hadamard
from tests.support.measured import MEASURED

DENBO = MEASURED / "denbo"


@pytest.mark.parametrize("order", ["tv", "hyperbolic", "natural"])
def test_all_coefficients_give_the_image_back(order: HadamardOrder) -> None:
    image = np.random.default_rng(0).random((8, 8))
    values = hadamard_signs(8, hadamard_order(8, order)).reshape(64, 64) @ image.ravel()
    assert np.allclose(inverse_hadamard(values, hadamard_order(8, order), 8), image, atol=1e-12)


def test_one_coefficient_is_the_mean_light() -> None:
    """The first pattern is all one: 32 lit of 64 pixels spread evenly are 0.5."""
    assert np.allclose(inverse_hadamard(np.array([32.0]), np.array([[0, 0]]), 8), 0.5)


def test_values_of_a_pattern_shown_twice_are_averaged() -> None:
    assert np.allclose(inverse_hadamard(np.array([30.0, 34.0]), np.array([[0, 0], [0, 0]]), 8), 0.5)


@pytest.mark.skipif(not DENBO.is_dir(), reason="measured data not there: set KINOPIX_DATA")
@pytest.mark.parametrize(
    ("vector", "picture"), [("boat_roi001", "boat_0.5"), ("boat_roi009", "boat_4.5"), ("boat_roi017", "boat_8.5")]
)
def test_measured_vectors_give_the_published_pictures(vector: str, picture: str) -> None:
    """Fixes order, sign and orientation: natural order, 32 x 32; the pictures show each pixel as 12 x 12."""
    with np.load(DENBO / "denbo_errors_car_vectors.npz") as archive:
        values = archive[vector].astype(np.float64)
    with Image.open(DENBO / f"{picture}.png") as file:
        published = np.asarray(file.convert("L"), np.float64)[6::12, 6::12]
    image = inverse_hadamard(values, hadamard_order(32, "natural", len(values)), 32)
    assert published.shape == image.shape == (32, 32)
    assert np.corrcoef(image.ravel(), published.ravel())[0, 1] >= 0.999
