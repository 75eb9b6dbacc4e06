"""From shares of light to signals and positions, against formulas of the literature and by hand."""

import numpy as np
import pytest

from instrument.patterns import ramp
from instrument.schemes import Column, Light, Observation, fourier_reading, in_play_order, moment_reading
from instrument.schemes.reading import PositionReading
from protocols import Floats


def _steps(count: int) -> tuple[Column, ...]:
    """So many phase steps along x, then along y."""
    phases = [2 * np.pi * k / count for k in range(count)]
    along_x = [Column(role="fourier", axis="x", phase_rad=phase) for phase in phases]
    along_y = [Column(role="fourier", axis="y", phase_rad=phase) for phase in phases]
    return in_play_order(*along_x, *along_y)


def test_three_steps_give_the_formula_of_zhang_2019() -> None:
    """O~ = (2 I0 - I120 - I240) / 3 x 2 / 2 ...: up to the common factor 2/3, (2 I0 - I120 - I240) + j sqrt 3 (I120 - I240)."""
    values = np.array([[5.0, 3.0, 4.0, 2.0, 6.0, 1.0]])
    total = np.array([8.0])
    x, y = (fourier_reading(_steps(3), 64.0).signal(values, total)[0] * total[0] * 3 / 2).tolist()
    assert x == pytest.approx((2 * 5 - 3 - 4) + 1j * np.sqrt(3) * (3 - 4))
    assert y == pytest.approx((2 * 2 - 6 - 1) + 1j * np.sqrt(3) * (6 - 1))


def test_four_steps_give_the_papers_equation_3() -> None:
    """O~ = (I0 - I180) + j (I90 - I270)."""
    values = np.array([[5.0, 3.0, 4.0, 2.0, 6.0, 1.0, 0.5, 2.5]])
    total = np.array([8.0])
    x, y = (fourier_reading(_steps(4), 64.0).signal(values, total)[0] * total[0]).tolist()
    assert x == pytest.approx((5 - 4) + 1j * (3 - 2))
    assert y == pytest.approx((6 - 0.5) + 1j * (1 - 2.5))


def test_each_axis_tells_the_total_light_where_its_patterns_add_to_a_constant() -> None:
    """Three fringes add to 3/2 and four to 2, a ramp and its complement to 1; of two fringes or one ramp nothing is constant."""
    for steps in (3, 4):
        weights = fourier_reading(_steps(steps), 64.0).light_weights
        assert weights is not None
        np.testing.assert_allclose(weights, np.full((2, steps), 2 / steps), atol=1e-12)
    ramps = [Column(role="moment", axis=axis, sign=sign) for axis in ("x", "y") for sign in (1, -1)]
    weights = moment_reading(in_play_order(*ramps), 16).light_weights
    assert weights is not None
    np.testing.assert_allclose(weights, np.ones((2, 2)), atol=1e-12)
    assert moment_reading(in_play_order(*ramps[::2]), 16).light_weights is None
    assert fourier_reading(in_play_order(*_steps(4)[:2], *_steps(4)[4:6]), 64.0).light_weights is None


def test_columns_of_each_axis_are_found_wherever_they_stand() -> None:
    columns = in_play_order(
        Column(role="hadamard"),
        Column(role="moment", axis="y"),
        Column(role="moment", axis="x"),
        Column(role="hadamard", sign=-1),
    )
    reading = moment_reading(columns, 16)
    assert reading.columns.tolist() == [[2], [1]]
    np.testing.assert_allclose(reading.after_middle_frames, [[1 / 8], [-1 / 8]])


def test_a_moment_is_the_centroid_in_pixel_coordinates() -> None:
    """One lit pixel in column 3, row 11 of 16; then half of the light in column 5."""
    reading = moment_reading(in_play_order(Column(role="moment", axis="x"), Column(role="moment", axis="y")), 16)
    image = np.zeros((16, 16))
    image[11, 3] = 2.0
    assert reading.signal(_seen(image), np.array([2.0]))[0].real == pytest.approx([3.0, 11.0])
    image[11, 5] = 2.0
    assert reading.signal(_seen(image), np.array([4.0]))[0].real == pytest.approx([4.0, 11.0])
    assert reading.period_px is None


def _seen(image: Floats) -> Floats:
    return np.array([[float((image * ramp(len(image), axis)).sum()) for axis in ("x", "y")]])


def test_displacement_is_minus_the_phase_over_two_pi_f() -> None:
    """A quarter of a period of 64 px is 16 px; beyond half a period it comes back from the other side."""
    reading = fourier_reading(_steps(2), 64.0)
    turned = np.exp(-2j * np.pi * np.array([[16.0, -10.0], [40.0, 0.0]]) / 64)
    np.testing.assert_allclose(reading.displacement_px(turned, 1.0), [[16.0, -10.0], [-24.0, 0.0]], atol=1e-9)
    np.testing.assert_allclose(reading.displacement_px(turned[:1], turned[0]), [[0.0, 0.0]], atol=1e-9)


def _observation(reading: PositionReading, path_px: Floats, *, photons: float, seed: int | None) -> Observation:
    """Frames of a point-like object of that many photons a frame, without noise or with that of photons."""
    shares = reading.shares(reading.direction(path_px) * 0.8 if reading.period_px else reading.direction(path_px))
    values = photons * shares.reshape(len(path_px), -1)
    if seed is not None:
        values = np.random.default_rng(seed).poisson(values).astype(np.float64)
    count = len(path_px)
    light = Light(
        values=values,
        variance=np.maximum(values, 1.0),
        total=np.full(count, photons),
        total_variance=np.zeros(count),
        valid=np.ones(count, np.bool_),
        photon_counts=True,
    )
    return Observation.of(reading, light)


@pytest.mark.parametrize("steps", [2, 3, 4])
def test_the_stated_variance_is_that_of_simulated_photons(steps: int) -> None:
    """4,000 frames at one place; two steps of quarter waves are those of the six-pattern scheme."""
    quarter = (0.0, np.pi / 2)
    columns = (
        _steps(steps)
        if steps > 2
        else in_play_order(
            *(Column(role="fourier", axis=axis, phase_rad=phase) for axis in ("x", "y") for phase in quarter)
        )
    )
    path = np.tile([7.0, 21.0], (4000, 1))
    found = _observation(fourier_reading(columns, 64.0), path, photons=2000.0, seed=1)
    seen = found.reading.displacement_px(found.signal, found.reading.origin)
    np.testing.assert_allclose(found.variance_px2(path).mean(axis=0), seen.var(axis=0), rtol=0.1)


def test_the_stated_variance_of_a_centroid_is_that_of_simulated_photons() -> None:
    columns = in_play_order(Column(role="moment", axis="x"), Column(role="moment", axis="y"))
    path = np.tile([7.0, 21.0], (4000, 1))
    found = _observation(moment_reading(columns, 32), path, photons=2000.0, seed=1)
    np.testing.assert_allclose(found.variance_px2(path).mean(axis=0), found.signal.real.var(axis=0), rtol=0.1)
    # Of a Poisson count of mean N c, c = (u + 1/2) / 32, the variance of the position is 32^2 c / N.
    np.testing.assert_allclose(found.variance_px2(path)[0], [32**2 * 7.5 / 32 / 2000, 32**2 * 21.5 / 32 / 2000])


def test_positions_in_mid_frame_undo_that_patterns_are_shown_one_after_the_other() -> None:
    """3 px a frame: of six equal patterns the x pair is a third of a frame early, the y pair in the middle."""
    columns = in_play_order(
        *(Column(role="fourier", axis=axis, phase_rad=phase) for axis in ("x", "y") for phase in (0.0, np.pi / 2)),
        Column(role="hadamard"),
        Column(role="hadamard", sign=-1),
    )
    reading = fourier_reading(columns, 64.0)
    middle_px = np.asarray(3.0 * np.arange(40)[:, None] * [1.0, 1.0], np.float64)
    values = np.zeros((40, 6))
    for axis in range(2):
        for k, column in enumerate(reading.columns[axis].tolist()):
            place_px = middle_px[:, axis] + 3.0 * reading.after_middle_frames[axis, k]
            values[:, column] = 0.5 + 0.5 * np.cos(-2 * np.pi / 64 * place_px - columns[int(column)].phase_rad)
    total = np.ones(40)
    light = Light(values, np.ones_like(values), total, 0 * total, np.ones(40, np.bool_), photon_counts=False)
    found = Observation.of(reading, light)
    raw = found.reading.displacement_px(found.signal, found.expected_direction(middle_px))
    plain = found.reading.displacement_px(found.signal, np.exp(-2j * np.pi * middle_px / 64))
    np.testing.assert_allclose(raw, 0.0, atol=1e-9)
    np.testing.assert_allclose(plain.mean(axis=0), [-1.0, 0.0], atol=0.05)
    np.testing.assert_allclose(found.in_mid_frame_px(middle_px), middle_px, atol=1e-9)
