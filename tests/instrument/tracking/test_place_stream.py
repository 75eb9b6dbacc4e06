"""Positions of a stream, of values written down by the formulas of the patterns."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.plan import Plan
from instrument.schemes import FourierHadamardSettings, Scheme, position_of, scheme_of
from instrument.schemes.moment_hadamard import MomentHadamardSettings
from instrument.schemes.observation import Light, Observation
from instrument.tracking.place_stream import PlaceStream
from instrument.tracking.unwrapping import unwrapped_px
from protocols import Floats, Mask

SIZE, PERIOD = 64, 32.0
FRINGES = scheme_of(Plan(frames=100, image_size=SIZE, scheme=FourierHadamardSettings(fourier_cycles=2)))
RAMPS = scheme_of(Plan(frames=100, image_size=SIZE, scheme=MomentHadamardSettings()))


def _fringes(place_px: Floats, light: Floats | float = 100.0, contrast: float = 0.8) -> Floats:
    """Give fringes at 0 and pi / 2 along x and y, which see 1/2 + contrast / 2 cos(phase + angle) of the light, H+ and H-."""
    angle = 2 * np.pi / PERIOD * place_px
    seen = [
        0.5 + contrast / 2 * wave for axis in range(2) for wave in (np.cos(angle[:, axis]), -np.sin(angle[:, axis]))
    ]
    seen += [np.full(len(place_px), 0.7), np.full(len(place_px), 0.3)]
    return np.ascontiguousarray(np.stack(seen, axis=1) * np.broadcast_to(light, len(place_px))[:, None])


def _ramps(place_px: Floats, light: Floats | float = 100.0) -> Floats:
    """Give ramps along x and y, grey (u + 1/2) / size, of a point of light at u, H+ and H-."""
    seen = [(place_px[:, 0] + 0.5) / SIZE, (place_px[:, 1] + 0.5) / SIZE]
    seen += [np.full(len(place_px), 0.4), np.full(len(place_px), 0.6)]
    return np.ascontiguousarray(np.stack(seen, axis=1) * np.broadcast_to(light, len(place_px))[:, None])


def _path(frames: int) -> Floats:
    """Give three periods to the right and two up, on a curve of at most 3 px a frame."""
    share = np.arange(frames) / frames
    return np.stack([5 + 3 * PERIOD * share**1.2, 9 - 2 * PERIOD * share], axis=1)


def test_fringes_are_followed_over_whole_periods_either_way() -> None:
    """Without noise each frame's own phase is exact, however far the mean signal lags behind."""
    path = _path(60)
    found = PlaceStream(FRINGES, 100.0).push(_fringes(path))
    np.testing.assert_allclose(found, path, atol=1e-9)


@settings(deadline=None)
@given(place=st.tuples(st.floats(-15.9, 15.9), st.floats(-15.9, 15.9)), contrast=st.floats(0.05, 1))
def test_the_first_position_is_within_half_a_period_of_0(place: tuple[float, float], contrast: float) -> None:
    found = PlaceStream(FRINGES, 100.0).push(_fringes(np.array([place]), contrast=contrast))
    np.testing.assert_allclose(found, [place], atol=1e-9)


def test_ramps_give_the_place_itself_and_no_period() -> None:
    path = np.array([[3.0, 60.0], [60.0, 1.0], [31.5, 0.0]])
    np.testing.assert_allclose(PlaceStream(RAMPS, 100.0).push(_ramps(path)), path, atol=1e-9)


def test_the_total_light_is_a_mean_that_forgets() -> None:
    """Of lights 100, 200 and 50 with a memory of 4: (3/4 100 + 200) / (3/4 + 1), then (9/16 100 + 3/4 200 + 50) / (37/16).

    A point at u then seems to be at (u + 1/2) light / mean - 1/2.
    """
    light, mean = np.array([100.0, 200.0, 50.0]), np.array([100.0, 275 / 1.75, 256.25 / (37 / 16)])
    place = np.array([[20.0, 40.0]] * 3)
    expected = (place + 0.5) * (light / mean)[:, None] - 0.5
    np.testing.assert_allclose(PlaceStream(RAMPS, 4.0).push(_ramps(place, light)), expected, rtol=1e-12)
    np.testing.assert_allclose(PlaceStream(RAMPS, 1.0).push(_ramps(place, light)), place, rtol=1e-12)


@pytest.mark.parametrize("lost", [np.nan, np.inf, 0.0, -1.0])
def test_before_the_first_good_frame_there_is_no_position_and_later_the_last_good_one_stands_for_it(
    lost: float,
) -> None:
    path = _path(60)[:9]
    values = _fringes(path)
    values[[0, 1, 5, 6]] = lost
    stream = PlaceStream(FRINGES, 100.0)
    assert stream.push(values[:1]).shape == (0, 2)
    found = stream.push(values[1:])
    np.testing.assert_allclose(found, path[[2, 3, 4, 4, 4, 7, 8]], atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(
    cuts=st.lists(st.integers(0, 60), max_size=6),
    lost=st.sets(st.integers(0, 59), max_size=10),
    power=st.integers(-20, 20),
    scheme=st.sampled_from([FRINGES, RAMPS]),
)
def test_neither_cuts_nor_another_unit_of_light_change_a_bit(
    cuts: list[int], lost: set[int], power: int, scheme: Scheme
) -> None:
    """Units that differ by a power of two have the same digits."""
    values = (_fringes if scheme is FRINGES else _ramps)(_path(60)) + np.random.default_rng(0).normal(
        size=(60, len(scheme.columns))
    )
    values[list(lost)] = np.nan
    whole = PlaceStream(scheme, 30.0).push(values)
    stream = PlaceStream(scheme, 30.0)
    parts = [stream.push(part) for part in np.split(2.0**power * values, sorted(cuts))]
    np.testing.assert_array_equal(np.concatenate(parts), whole)


def _observed(scheme: Scheme, values: Floats, valid: Mask) -> Observation:
    light = Light(
        values=values,
        variance=np.ones_like(values),
        total=values @ scheme.light_weights,
        total_variance=np.zeros(len(values)),
        valid=valid,
        photon_counts=False,
    )
    return Observation.of(position_of(scheme), light)


def test_a_whole_run_is_unwrapped_and_frames_that_are_not_valid_lie_on_the_line_between() -> None:
    path, valid = _path(60), np.ones(60, np.bool_)
    valid[[0, 20, 21, 22, 59]] = False
    found = unwrapped_px(_observed(FRINGES, _fringes(path), valid))
    np.testing.assert_allclose(found[valid], path[valid], atol=1e-9)
    line = path[19] + np.array([[1], [2], [3]]) / 4 * (path[23] - path[19])
    np.testing.assert_allclose(found[20:23], line, atol=1e-9)
    np.testing.assert_allclose(found[[0, 59]], path[[1, 58]], atol=1e-9)


def test_positions_without_a_period_are_taken_as_they_are() -> None:
    """A jump from 3 to 60 px, of far more than half a field, stays one; the lost frame between is halfway."""
    path = np.array([[3.0, 60.0], [9.0, 9.0], [60.0, 1.0]])
    found = unwrapped_px(_observed(RAMPS, _ramps(path), np.array([True, False, True])))
    np.testing.assert_allclose(found, [[3.0, 60.0], [31.5, 30.5], [60.0, 1.0]], atol=1e-9)


def test_noise_that_hides_whole_periods_of_single_frames_is_averaged_away_before_counting() -> None:
    """Amplitude 0.4 under noise of 0.25 (a clearness of 1.6): frame by frame the count is lost, over 25 frames it is not."""
    frames = 600
    path = np.stack([np.linspace(0, 90, frames), np.linspace(0, -60, frames)], axis=1)
    values = _fringes(path, contrast=0.4) + 25 / 2 * np.random.default_rng(3).normal(size=(frames, 6)) * [
        1,
        1,
        1,
        1,
        0,
        0,
    ]
    observed = _observed(FRINGES, values, np.ones(frames, np.bool_))
    alone = np.unwrap(-np.angle(observed.signal), axis=0) * PERIOD / (2 * np.pi)

    error = unwrapped_px(observed) - path

    assert np.abs(error).max() < PERIOD / 2 + 4
    assert np.abs(np.median(error[-50:], axis=0)).max() < 1.5
    assert np.abs(np.median((alone - path)[-50:], axis=0)).max() > PERIOD / 2
