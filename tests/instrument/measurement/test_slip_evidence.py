"""What tells slips: levels that go on, two values that are opposites, and the cheapest way through all of it."""

import numpy as np
import pytest

from instrument.measurement.change_places import change_place
from instrument.measurement.cheapest_shifts import cheapest_shifts
from instrument.measurement.levels import Levels
from instrument.measurement.opposites import deviations, noise_of, opposed, opposites
from instrument.measurement.slips import Segment, Slips, in_step_again, slips_of
from protocols import Floats

FRAMES = 400
LEVELS = np.array([60.0, 110, 160, 210, 100, 100])
"""Levels of four position patterns and of a pair whose sum is 200."""


def random(*shape: int, seed: int = 1) -> Floats:
    return np.random.default_rng(seed).standard_normal(shape)


def light_of(noise: float = 5.0, pair: float = 0.0, slope: float = 0.0, frames: int = FRAMES) -> Floats:
    """Six values a frame: levels, noise, and what a pattern has more than its complement."""
    light = LEVELS + noise * random(frames, 6) + slope * np.arange(frames)[:, None]
    more = pair * random(frames, seed=2)
    light[:, 4] += more
    light[:, 5] -= more
    return np.asarray(light, np.float64)


def lost(light: Floats, value: int) -> Floats:
    """Without one value; the last one is there twice."""
    return np.append(np.delete(light.ravel(), value), light[-1, -1]).reshape(light.shape)


def test_a_deviation_is_that_from_the_frames_around_and_has_the_variance_of_a_value() -> None:
    line = np.arange(20.0)[:, None]
    np.testing.assert_allclose(deviations(line)[3:-3], 0, atol=1e-12)
    np.testing.assert_allclose(deviations(line)[0], -2 / np.sqrt(4 / 3))  # from 1, 2 and 3
    one = np.zeros((20, 1))
    one[10] = 7.0
    np.testing.assert_allclose(deviations(one)[[10, 13, 14], 0], [7 / np.sqrt(7 / 6), -7 / 6 / np.sqrt(7 / 6), 0])
    one[11] = np.nan
    np.testing.assert_allclose(deviations(one)[10, 0], 7 / np.sqrt(6 / 5))
    assert np.isnan(deviations(one)[11, 0])
    assert abs(deviations(random(20000, 1)).std() - 1) < 0.02


def test_noise_is_what_values_show_whatever_photons_would_and_at_least_a_quarter_of_it() -> None:
    seen = noise_of(light_of(noise=20.0), np.zeros(6))
    assert np.abs(seen.mean(axis=0) / 400 - 1).max() < 0.3
    quiet = noise_of(light_of(noise=0.0), np.zeros(6))
    np.testing.assert_allclose(quiet[0], LEVELS / 4)
    np.testing.assert_allclose(noise_of(light_of(noise=0.0), np.full(6, 80.0))[0], 20)
    np.testing.assert_allclose(noise_of(1e4 * light_of(noise=0.0), np.zeros(6))[0], (100 * LEVELS) ** 2)  # 1 %


def test_noise_is_that_of_each_part_of_the_run() -> None:
    light = np.concatenate([light_of(noise=10.0, frames=64), light_of(noise=40.0, frames=64)])
    seen = noise_of(light, np.zeros(6)).mean(axis=1)
    assert 60 < seen[0] < 160
    assert 1000 < seen[-1] < 2300
    assert np.unique(seen).size == 2


def test_two_that_go_up_and_down_against_each_other_are_opposed() -> None:
    light = np.full((30, 6), 100.0)
    light[10] += [0, 0, 0, 0, 50, -45]
    light[20] += [0, 30, 0, 0, 0, 0]
    assert np.argwhere(opposed(light) & (light != 100)).tolist() == [[10, 4], [10, 5]]


@pytest.mark.parametrize("by", [-2, -1, 0, 1, 3])
def test_the_pair_is_where_two_values_are_opposites(by: int) -> None:
    """A pair of 1.5 times the noise: on average below 0 where it is, above 0 elsewhere."""
    light = np.roll(light_of(pair=7.5).ravel(), by).reshape(FRAMES, 6)
    costs, told = opposites(light, noise_of(light, np.zeros(6)), 4, 3)
    assert told
    assert costs.shape == (FRAMES, 7)
    mean = costs.mean(axis=0)
    right = [3 + by] if abs(by) < 3 else [0, 6]
    assert (mean[right] < -0.2).all()
    assert (np.delete(mean, right) > 0.2).all()


def test_noise_alone_says_next_to_nothing_and_values_alike_in_all_patterns_neither() -> None:
    light = light_of()
    costs, _ = opposites(light, noise_of(light, np.zeros(6)), 4, 3)
    assert np.abs(costs.sum(axis=0)).max() < 15
    flickers = light * (1 + 0.3 * random(FRAMES, 1, seed=5))
    costs, _ = opposites(flickers, noise_of(flickers, np.zeros(6)), 4, 3)
    assert np.ptp(costs.sum(axis=0)) < 30


def test_lines_go_through_the_frames_before_and_after() -> None:
    """Along 3 + 2 x: half a frame after frame 50 and half a frame before it."""
    light = 3 + 2 * np.arange(100.0)[:, None] @ np.ones((1, 2))
    levels = Levels.of(light, np.full((100, 2), 4.0))
    np.testing.assert_allclose(levels.before[:, 50, :, 0], 104)
    np.testing.assert_allclose(levels.after[:, 50, :, 0], 102)
    np.testing.assert_allclose(levels.before[:, 50, :, 1], 2)
    # The variance of a line of n values half a step beyond its end: (1 / n + 3 n / (n^2 - 1)) sigma^2.
    expected = [4 * (1 / n + 3 * n / (n**2 - 1)) for n in (30, 10, 4)]
    np.testing.assert_allclose(levels.before[:, 50, 0, 2], expected)
    np.testing.assert_allclose(levels.after[:, 50, 0, 2], expected)
    assert np.isnan(levels.before[:, 1]).all()
    assert np.isfinite(levels.before[:, 2]).all()
    assert np.isnan(levels.after[:, 98]).all()
    assert np.isfinite(levels.after[:, 97]).all()
    np.testing.assert_allclose(levels.jumps()[4:97], 0, atol=1e-9)


def test_values_off_their_line_make_its_variance_larger_and_unknown_ones_are_left_out() -> None:
    light = np.zeros((100, 1))
    light[50:54, 0] = [3, -3, -3, 3]  # residual of their line: 9 each, over n - 2
    line = Levels.of(light, np.ones((100, 1)), np.ones((3, 100, 1))).after[2, 50, 0]
    np.testing.assert_allclose(line, [0, 0, 36 / 2 * (1 / 4 + 12 / 15)], atol=1e-12)
    light[51:53] = np.nan
    assert np.isnan(Levels.of(light, np.ones((100, 1))).after[2, 50]).all()


def test_levels_jump_by_squares_over_their_variances_where_a_value_slipped() -> None:
    """One in step from value 1203 on early: levels 160, 210, 100, 100 become 210, 100, 100, 60."""
    light = lost(light_of(), 1203)
    levels = Levels.of(light, np.full(light.shape, 25.0))
    jumps = levels.jumps()
    assert int(jumps.argmax()) in {200, 201, 202}
    assert jumps.max() > 100
    assert np.quantile(jumps, 0.5) < 12


def test_what_bends_all_lines_is_in_their_variances() -> None:
    bent = light_of(slope=0.0) + 60 * np.sin(np.arange(FRAMES) / 5)[:, None]
    scale = Levels.of(bent, np.full(bent.shape, 25.0)).scale
    assert scale[0].min() > 4
    assert Levels.of(light_of(), np.full(bent.shape, 25.0)).scale.max() < 1.6


def shifts_of(pairs: Floats, light: Floats, jump_at: int, change: float = 50.0) -> tuple[list[int], Floats]:
    jumps = np.zeros(len(light))
    jumps[jump_at] = 120.0
    shift, margin = cheapest_shifts(pairs, jumps, Levels.of(light, np.full(light.shape, 25.0)), change, margins=True)
    plain, _ = cheapest_shifts(pairs, jumps, Levels.of(light, np.full(light.shape, 25.0)), change, margins=False)
    np.testing.assert_array_equal(plain, shift)
    return shift.tolist(), margin


def test_a_jump_is_a_slip_where_all_levels_go_on_in_another_pattern() -> None:
    light = lost(light_of(), 1203)
    shift, margin = shifts_of(np.zeros((FRAMES, 7)), light, 201)
    assert shift[:200] == [0] * 200
    assert shift[202:] == [-1] * 198
    assert 3 < margin.min() < 12  # late until then and in step from then on costs 60, not 50
    shift, _ = shifts_of(np.zeros((FRAMES, 7)), light_of(), 201)
    assert shift == [0] * FRAMES  # it jumps, but goes on nowhere else


def test_a_run_starts_with_a_shift_where_pairs_say_so_by_more_than_it_is_unlikely() -> None:
    """Each frame says 1 for a shift by +1: 400 in all, of which one start costs 20."""
    pairs = np.zeros((FRAMES, 7))
    pairs[:, 4] = -1.0
    shift, margin = shifts_of(pairs, light_of(), 0)
    assert shift == [1] * FRAMES
    assert margin.min() > 20
    assert margin[200] > 150
    pairs[21:] = 0.0
    assert shifts_of(pairs, light_of(), 0)[0] == [1] * FRAMES
    pairs[19:] = 0.0
    assert shifts_of(pairs, light_of(), 0)[0] == [0] * FRAMES


def test_the_place_of_a_change_is_told_to_the_value() -> None:
    light = lost(light_of(noise=2.0), 1203)
    noise = np.full(light.shape, 4.0)
    place, first, last = change_place(light, noise, Levels.of(light, noise), 199, (0, -1))
    assert place == 1203
    assert first == last == 1203


def test_a_place_that_is_not_told_is_one_of_several() -> None:
    """Value 1204 is lost, H+, and H- after it has the same level."""
    light = lost(light_of(noise=2.0), 1204)
    noise = np.full(light.shape, 4.0)
    _, first, last = change_place(light, noise, Levels.of(light, noise), 202, (0, -1))
    assert first <= 1204
    assert last == 1205


def test_frames_passed_over_go_on_along_their_lines() -> None:
    """Levels rise by 4 a frame; the two frames in which the shift changes hold nothing."""
    light = lost(light_of(noise=1.0, slope=4.0), 1203)
    light[200:202] = np.nan
    jumps = np.zeros(FRAMES)
    jumps[201] = 100.0
    levels = Levels.of(light, np.full(light.shape, 1.0))
    shift, _ = cheapest_shifts(np.zeros((FRAMES, 7)), jumps, levels, 50.0, margins=False)
    assert shift[:200].tolist() == [0] * 200
    assert shift[202:].tolist() == [-1] * 198


def test_what_one_way_costs_more_than_another_is_its_margin() -> None:
    """Without levels, jumps or a change: each other shift s costs 10 a frame, and 20 and 10 (|s| - 1) at its start."""
    pairs = np.full((20, 7), 10.0)
    pairs[:, 3] = 0.0
    light = np.full((20, 6), np.nan)
    shift, margin = cheapest_shifts(pairs, np.zeros(20), Levels.of(light, np.ones((20, 6))), 50.0, margins=True)
    assert shift.tolist() == [0] * 20
    # A start with +-1 that is back at once costs 20, 10 for its frame, 0.75 of 50, and six unknown levels of 5.
    assert margin[0] == pytest.approx(20 + 10 + 37.5 + 30)
    # The last frame alone: 50, six unknown levels, and its own.
    assert margin[-1] == pytest.approx(50 + 30 + 10)


def test_a_place_near_the_ends_is_told_too() -> None:
    for value in (27, 6 * FRAMES - 27):
        light = lost(light_of(noise=2.0), value)
        noise = np.full(light.shape, 4.0)
        place, _, _ = change_place(light, noise, Levels.of(light, noise), value // 6, (0, -1))
        assert abs(place - value) <= 1


def late(by: int) -> Slips:
    return Slips((Segment(0, 10, by),), np.full(10, True))


def test_values_are_moved_back_by_less_than_half_a_frame_and_not_across_one_that_is_not_sure() -> None:
    values = np.arange(60.0).reshape(10, 6)
    np.testing.assert_array_equal(in_step_again(values, late(2))[:9], values[:9] + 2)
    assert np.isnan(in_step_again(values, late(2))[9, 4:]).all()
    np.testing.assert_array_equal(in_step_again(values, late(-2))[1:], values[1:] - 2)
    assert np.isnan(in_step_again(values, late(3))).all()
    np.testing.assert_array_equal(
        in_step_again(values[:, :2].copy(), Slips((Segment(0, 10, 1),), np.full(10, True)))[0], [1, 6]
    )
    unsure = late(2)
    unsure.sure[5] = False
    assert np.flatnonzero(np.isnan(in_step_again(values, unsure)).any(axis=1)).tolist() == [4, 5, 9]


def test_nothing_is_said_of_few_frames_of_few_counts_or_without_a_pair() -> None:
    light = np.roll(light_of(pair=40.0, noise=1.0).ravel(), 1).reshape(FRAMES, 6)
    wild, photons = np.zeros(light.shape, bool), np.zeros(6)
    assert slips_of(light, wild, photons, (4, 5)).segments == (Segment(0, FRAMES, 1),)
    assert not slips_of(light, wild, photons, None).any
    assert not slips_of(light, wild, photons, (3, 5)).any
    assert not slips_of(light[:15], wild[:15], photons, (4, 5)).any
    assert not slips_of(light / 40, wild, photons, (4, 5)).any  # pairs of 8 counts
    assert slips_of(light / 40, wild, np.full(6, 1e-3), (4, 5)).any
    assert not slips_of(np.full_like(light, np.nan), wild, photons, (4, 5)).any
