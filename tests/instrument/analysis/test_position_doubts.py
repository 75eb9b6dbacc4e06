"""Position values that contradict each other, or hardly say anything, are told, also where there is no image to tell it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from instrument import Plan, Recording, analyse, simulate
from instrument.analysis.position_doubts import position_doubts
from instrument.measurement import Measurement
from protocols import Floats, InputError, Integers

TRACKING_ONLY = ["fourier-3step", "fourier-4step", "moment-complementary"]


def recorded(scheme: str, **scene: Any) -> Recording:
    """A letter that goes 10 px along x and 6 along y, in fringes of 32 px."""
    plan = Plan.model_validate({"frames": 240, "image_size": 64, "scheme": scheme})
    noise = {"kind": "poisson", "peak_counts": 500.0, "seed": 3}
    table = {"object": "letter-B", "object_height_px": 18, "start_px": [24.4, 29.7], "noise": noise, **scene}
    way_px_s = np.array([10.0, 6.0]) / plan.run_time_s
    return simulate(plan, table, path=lambda time_s: np.multiply.outer(time_s, way_px_s))


def with_values(recording: Recording, values: Floats | Integers) -> Recording:
    return replace(recording, values=values.reshape(recording.values.shape).astype(np.float64))


def doubts(recording: Recording, *, with_image: bool = False, beside_background: bool = False) -> tuple[str, ...]:
    return position_doubts(Measurement.of(recording), with_image=with_image, beside_background=beside_background)


@pytest.mark.parametrize("scheme", TRACKING_ONLY)
def test_values_that_slipped_are_told_as_both_axes_see_other_light(scheme: str) -> None:
    """One value lost in mid-run, and all values a pattern late: the path is off by pixels, and no image says so."""
    run = recorded(scheme)
    flat = run.values.ravel()
    middle = flat.size // 2
    for wrong in (np.append(np.delete(flat, middle), flat[-1]), np.roll(flat, 1)):
        (told,) = doubts(with_values(run, wrong))
        assert "values slipped to other patterns" in told
        assert float(told.split("by up to ")[1].split(" %")[0]) > 10


@pytest.mark.parametrize("scheme", TRACKING_ONLY)
@pytest.mark.parametrize("flaw", [{}, {"mirror_transition_s": 12.5e-6, "edge_loss": 0.1, "led_flicker": 0.3}])
def test_a_bench_with_flaws_contradicts_nothing(scheme: str, flaw: dict[str, float]) -> None:
    assert doubts(recorded(scheme, **flaw)) == ()


def test_light_of_one_axis_that_is_a_seventh_less_is_told_and_a_twentieth_is_not() -> None:
    run = recorded("moment-complementary")
    for share, told in ((0.86, 1), (0.95, 0)):
        values = run.values.astype(np.float64)
        values[120:, :2] *= share
        assert len(doubts(replace(with_values(run, values), photon_counts=False))) == told


def test_of_a_letter_as_long_as_a_fringe_the_weak_axis_is_told() -> None:
    """30 px high: along y some 5 % of its light change with the fringes, along x 30 %."""
    run = recorded("fourier-3step", object_height_px=30, start_px=[20, 20])
    (told,) = doubts(run)
    assert "with the fringes along y" in told
    assert float(told.removeprefix("only ").split(" %")[0]) < 15
    assert doubts(run, beside_background=True) == ()
    assert told in analyse(run).figures.doubts


def test_of_fine_bars_a_fifth_is_doubted_unless_an_image_was_found_with_the_path() -> None:
    """Bars of 2 px: 18 and 27 % of their light change with the fringes along x and along y."""
    run = recorded("fourier-hadamard", object="bars", object_height_px=2, start_px=[20, 20])
    (told,) = doubts(run)
    assert "with the fringes along x" in told
    assert doubts(run, with_image=True) == ()


@pytest.mark.parametrize("counts", [50.0, 2000.0])
def test_light_that_is_the_same_for_all_fringes_is_refused(counts: float) -> None:
    run = recorded("fourier-3step")
    for seed in range(3):
        empty = with_values(run, np.random.default_rng(seed).poisson(counts, run.values.shape))
        with pytest.raises(InputError, match="the same for every fringe: no object in it"):
            analyse(empty)


def test_an_image_of_a_few_patterns_is_told_to_be_a_guess() -> None:
    run = recorded("hadamard").first(10)
    (doubt,) = [text for text in analyse(run).figures.doubts if "too few" in text]
    assert doubt == "10 frames are too few for an image: it is a guess; record 64 or more, better some hundred"
