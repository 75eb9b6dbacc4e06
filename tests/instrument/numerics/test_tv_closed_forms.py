"""Total variation where its minimum is known in closed form: two plateaus, each pixel seen by itself."""

from dataclasses import replace

import numpy as np
import pytest

from instrument.numerics import TvState, close_border, total_variation
from instrument.numerics.tv import relaxation_of
from protocols import Floats
from tests.support.dense import DenseSingles

HEIGHT, LEFT, RIGHT = 12, 8, 16
LOW, HIGH = 20.0, 80.0
SHAPE = (HEIGHT, LEFT + RIGHT)
PIXELS = DenseSingles(np.eye(HEIGHT * (LEFT + RIGHT)), SHAPE)


def _plateaus(reweightings: int, bregman_steps: int, strength: float = 30.0) -> tuple[TvState, float, float]:
    """Solve for the two plateaus, which must be flat, and give how far each has moved towards the other."""
    truth = np.full(SHAPE, LOW, np.float32)
    truth[:, LEFT:] = HIGH
    state = total_variation(
        PIXELS,
        truth.ravel(),
        strength=strength,
        reweightings=reweightings,
        bregman_steps=bregman_steps,
        tolerance=0,
        iterations=2000,
    )
    low, high = state.image[:, :LEFT], state.image[:, LEFT:]
    assert np.ptp(low) < 0.01
    assert np.ptp(high) < 0.01
    return state, float(low.mean()) - LOW, HIGH - float(high.mean())


def test_each_plateau_gives_lambda_over_its_width() -> None:
    """1/2 w (x - a)^2 a row against lambda times the jump: x moves by lambda / w. lambda is 30, to about 4 %."""
    state, low, high = _plateaus(0, 0)
    assert low * LEFT == pytest.approx(30.0, rel=0.12)
    assert high * RIGHT == pytest.approx(low * LEFT, rel=1e-3)
    assert state.misfit == pytest.approx(np.sqrt((LEFT * low**2 + RIGHT * high**2) / (LEFT + RIGHT)), rel=1e-3)
    assert state.eigenvalue == pytest.approx(1.05, rel=1e-5)
    _, twice, _ = _plateaus(0, 0, strength=60.0)
    assert twice == pytest.approx(2 * low, rel=1e-3)


def test_one_bregman_step_gives_the_plateaus_back() -> None:
    """The residual that is added is what the next solution takes off again."""
    _, low, high = _plateaus(0, 1)
    assert low == pytest.approx(0.0, abs=5e-3)
    assert high == pytest.approx(0.0, abs=5e-3)


def test_an_edge_that_was_found_is_penalised_by_e_over_jump_plus_e() -> None:
    """With e = 0.2 of sum x^2 / sum x of the plain solution."""
    _, low, high = _plateaus(0, 0)
    below, above = LOW + low, HIGH - high
    typical = (LEFT * below**2 + RIGHT * above**2) / (LEFT * below + RIGHT * above)
    weight = 0.2 * typical / (above - below + 0.2 * typical)
    _, freed, other = _plateaus(1, 0)
    assert freed == pytest.approx(weight * low, rel=5e-3)
    assert other == pytest.approx(weight * high, rel=5e-3)


def _stripe(parity: Floats) -> DenseSingles:
    """One row that sees one image of +1 and -1, with the eigenvalue 16 of 4 x 4 pixels."""
    return DenseSingles((1 - 2 * (parity % 2)).reshape(1, 16), (4, 4))


_ROWS, _COLUMNS = np.indices((4, 4)).astype(float)


@pytest.mark.parametrize(
    ("parity", "bound"),
    [
        pytest.param(np.zeros((4, 4)), 1.7, id="even light: 2 - 1 / 5 is above 1.7"),
        pytest.param(_COLUMNS, 2 - 1 / 3 - 0.02, id="upright stripes"),
        pytest.param(_ROWS, 2 - 1 / 3 - 0.02, id="level stripes"),
        pytest.param(_ROWS + _COLUMNS, 1.0, id="checkerboard: 2 - 1 is below 1 by the margin"),
    ],
)
def test_the_relaxation_is_bounded_by_the_image_that_the_rows_see_best(parity: Floats, bound: float) -> None:
    """1 / tau = 5/2, less 2 times 0, 1/2 or 1, is 5/2, 3/2 and 1/2: mu is its inverse, and the bound 2 - mu / 2 - 0.02."""
    assert relaxation_of(_stripe(parity), 16.0) == pytest.approx(bound, abs=1e-6)


def test_an_eigenvalue_twice_as_large_halves_mu() -> None:
    assert relaxation_of(_stripe(_ROWS + _COLUMNS), 32.0) == pytest.approx(2 - 1 / 2 - 0.02, abs=1e-6)


def test_a_start_cut_out_of_a_larger_image_ends_where_a_start_from_nothing_does() -> None:
    """Plateaus of 20 and 80, cut two columns left of the jump: one even image of 80, whose total variation is 0."""
    values = np.full((6, 12), 20.0, np.float32)
    values[:, 6:] = 80.0
    whole = total_variation(
        DenseSingles(np.eye(72), (6, 12)), values.ravel(), strength=30.0, reweightings=0, iterations=200
    )
    part, dual = whole.image[:, 8:].copy(), whole.dual[..., 8:].copy()
    dual[1, 1, :, 0] = dual[1, 3, :, 0] = 5.0  # what points across the new border, and would be kept
    close_border(dual)
    assert dual[1, 1, :, 0].tolist() == [0.0] * 6
    start = replace(TvState.zero(((6, 4),), whole.eigenvalue), images=(part,), duals=(dual,))
    cut = total_variation(
        DenseSingles(np.eye(24), (6, 4)),
        values[:, 8:].ravel(),
        strength=30.0,
        reweightings=0,
        iterations=2000,
        start=start,
    )
    np.testing.assert_allclose(cut.image, 80.0, atol=0.01)
