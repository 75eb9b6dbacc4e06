"""The fit of the dead time, on counts that are known exactly."""

import numpy as np
import pytest

from instrument.calibration import LightLadder, better, counted_hz, fit_dead_time, linear_limit_hz, name_of_line
from instrument.config import DeadTimeKind
from protocols import Floats

LIT = np.array(
    [[a <= k < a + width for k in range(8)] for width in (1, 2, 4, 8) for a in range(0, 8, width)] + [[False] * 8]
)


def ladder(
    kind: DeadTimeKind,
    *,
    edge: float = 0.0,
    dead_time_s: float = 2e-8,
    stray_hz: float = 600.0,
    seed: int | None = None,
) -> LightLadder:
    """Parts of uneven light, 20 million photons a second together, 16 mirrors wide, counted for 10 s each."""
    light: Floats = 2.5e6 * (1 + 0.1 * np.arange(-3.5, 4))
    photons: list[float] = []
    for row in LIT:
        borders = sum(row[k] != row[k + 1] for k in range(7) for _ in (0,))
        at_borders = sum(
            light[k] / 16 for k in range(8) for j in (k - 1, k + 1) if 0 <= j < 8 and row[k] and not row[j]
        )
        assert (borders > 0) == (at_borders > 0)
        photons.append(float(light @ row) - edge * at_borders + stray_hz)
    board = [share * light.sum() * (1 - 2 * edge) + stray_hz for share in (0.49, 0.51)]
    rate, boards = (counted_hz(np.array(n), dead_time_s, kind) for n in (photons, board))
    sigma, board_sigma = np.sqrt(rate / 10), np.sqrt(boards / 10)
    if seed is not None:
        random = np.random.default_rng(seed)
        rate, boards = (
            rate + sigma * random.standard_normal(len(rate)),
            boards + board_sigma * random.standard_normal(2),
        )
    return LightLadder(LIT, rate, sigma, np.full(8, 16.0), boards, board_sigma, 2.0)


def test_both_models_as_the_handbooks_have_them() -> None:
    """20 ns at 5.56 million photons a second: 5 million counts; paralyzable exp(-0.111) of them."""
    photons = np.array([5e6 / 0.9])
    assert counted_hz(photons, 2e-8, "non-paralyzable") == pytest.approx(5e6)
    assert counted_hz(photons, 2e-8, "paralyzable") == pytest.approx(5e6 / 0.9 * np.exp(-1 / 9))


@pytest.mark.parametrize("edge", [0.0, 0.05])
@pytest.mark.parametrize("kind", ["non-paralyzable", "paralyzable"])
def test_exact_counts_give_the_exact_dead_time_edge_loss_and_light(kind: DeadTimeKind, edge: float) -> None:
    fit = fit_dead_time(ladder(kind, edge=edge), kind)
    assert fit.dead_time_s == pytest.approx(2e-8, rel=2e-3)
    assert fit.edge_loss == pytest.approx(edge, abs=2e-3)
    assert fit.stray_hz == pytest.approx(600, abs=20)
    assert fit.light_hz == pytest.approx(2.5e6 * (1 + 0.1 * np.arange(-3.5, 4)), rel=1e-3)
    assert fit.degrees_of_freedom == 16 + 2 + 1 - 12


@pytest.mark.parametrize("kind", ["non-paralyzable", "paralyzable"])
def test_the_right_kind_is_found_and_the_stated_error_holds(kind: DeadTimeKind) -> None:
    wrong: list[float] = []
    for seed in range(10):
        best, between = better(ladder(kind, edge=0.02, seed=seed))
        assert best.kind == kind
        assert between > 16
        wrong.append((best.dead_time_s - 2e-8) / best.sigma_s)
    assert 0.4 < np.std(wrong) < 1.8
    assert abs(np.mean(wrong)) < 1.2


def test_a_dim_ladder_does_not_tell_the_kind_and_says_so() -> None:
    dim = ladder("non-paralyzable", seed=1)
    dim = LightLadder(
        dim.lit, dim.rate_hz / 100, dim.sigma_hz, dim.width_mirrors, dim.checker_hz / 100, dim.checker_sigma_hz, 2.0
    )
    best, between = better(dim)
    assert between < 16
    both = [fit_dead_time(dim, kind).dead_time_s for kind in ("non-paralyzable", "paralyzable")]
    assert best.sigma_s >= abs(both[0] - both[1]) * 0.999


def test_a_tenth_is_lost_at_the_linear_limit() -> None:
    """The data sheet: 5 million counts a second for 20 ns. Paralyzable 4.74 million."""
    assert linear_limit_hz(2e-8, "non-paralyzable") == pytest.approx(5e6)
    assert linear_limit_hz(2e-8, "paralyzable") == pytest.approx(4.74e6, rel=1e-3)


def test_lines_are_named() -> None:
    assert name_of_line(100.02, 2e4) == "2 times the mains of 50 Hz"
    assert name_of_line(120.0, 2e4) == "2 times the mains of 60 Hz"
    assert name_of_line(50.1, 2e4) == "the mains of 50 Hz"
    assert name_of_line(199.0, 2e4) == "4 times the mains of 50 Hz"
    assert "9998 Hz" in name_of_line(9998.0, 2e4)
    assert "20000 Hz" in name_of_line(9998.0, 2e4)
