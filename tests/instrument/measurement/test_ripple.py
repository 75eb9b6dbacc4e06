# pyright: reportPrivateUsage=false
"""Periodic light: cosines that were put in by hand."""

import numpy as np
import pytest

from instrument.measurement.ripple import Ripple, _line, ripples_seen, without_ripples
from protocols import Floats, Mask

FRAME_S = 300e-6
FRAMES = 1000
TIME_S = np.arange(FRAMES, dtype=np.float64) * FRAME_S
ALL: Mask = np.ones(FRAMES, np.bool_)


def _total(*ripples: Ripple, mean: float = 50.0, noise: float = 0.0, seed: int = 0) -> Floats:
    rng = np.random.default_rng(seed)
    parts = sum((ripple.at(TIME_S) for ripple in ripples), np.zeros(FRAMES))
    return np.asarray(mean * (1 + parts + noise * rng.standard_normal(FRAMES)), np.float64)


def test_a_ripple_by_hand() -> None:
    """100 Hz: largest at its phase over 2 pi 100 Hz, the opposite half a period later."""
    ripple = Ripple(frequency_hz=100, amplitude=0.3, phase_rad=np.pi / 2)
    np.testing.assert_allclose(ripple.at(np.array([0.0, 2.5e-3, 5e-3, 7.5e-3])), [0, 0.3, 0, -0.3], atol=1e-12)


@pytest.mark.parametrize("phase_rad", [-3.0, -1.0, 0.5, 2.0])
@pytest.mark.parametrize("frequency_hz", [100.0, 120.0, 333.3])
def test_a_cosine_without_noise_is_found_as_it_was_made(frequency_hz: float, phase_rad: float) -> None:
    (found,) = ripples_seen(
        _total(Ripple(frequency_hz=frequency_hz, amplitude=0.1, phase_rad=phase_rad)), None, ALL, TIME_S
    )[:1]
    assert found.frequency_hz == pytest.approx(frequency_hz, rel=3e-4)
    assert found.amplitude == pytest.approx(0.1, rel=5e-3)
    assert found.phase_rad == pytest.approx(phase_rad, abs=0.02)
    assert found.lamp_share == 1.0


@pytest.mark.parametrize("phase_rad", [-3.0, 0.5, 2.0])
def test_a_deep_ripple_of_few_periods_is_told_from_the_drift_that_it_looks_like(phase_rad: float) -> None:
    """Nine periods of 0.98 bend the polynomial of the drift by some 3 %: where the lamp is darkest, that is all its light."""
    frames = 300
    deep = Ripple(frequency_hz=100.0, amplitude=0.98, phase_rad=phase_rad)
    drift = np.linspace(1.2, 0.8, frames)
    (found,) = ripples_seen(_total(deep)[:frames] * drift, None, ALL[:frames], TIME_S[:frames])[:1]
    assert found.amplitude == pytest.approx(0.98, abs=0.003)
    assert found.frequency_hz == pytest.approx(100.0, abs=0.03)
    assert found.phase_rad == pytest.approx(phase_rad, abs=0.01)


def test_two_lines_are_found_the_stronger_first() -> None:
    lines = [Ripple(frequency_hz=f, amplitude=a, phase_rad=1.0) for f, a in ((200.0, 0.03), (100.0, 0.1))]
    found = ripples_seen(_total(*lines, noise=0.02), None, ALL, TIME_S)
    assert [ripple.frequency_hz for ripple in found] == pytest.approx([100.0, 200.0], abs=0.3)
    assert [ripple.amplitude for ripple in found] == pytest.approx([0.1, 0.03], abs=0.004)


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_the_lamp_s_ripple_is_in_the_signals_and_ambient_light_is_not(share: float) -> None:
    """Amplitudes that ripple by the lamp's share of what the total does."""
    ripple = Ripple(frequency_hz=100, amplitude=0.2, phase_rad=0.7)
    noise = np.random.default_rng(1).standard_normal((2, FRAMES))
    amplitude = np.stack([10 * (1 + share * ripple.at(TIME_S)), 30 * (1 + share * ripple.at(TIME_S))]) + 0.3 * noise
    found = ripples_seen(_total(ripple, noise=0.01), np.asarray(amplitude.T, np.float64), ALL, TIME_S)
    assert len(found) == 1
    assert found[0].lamp_share == pytest.approx(share, abs=0.02)


def test_signals_that_do_not_say_leave_it_to_the_lamp() -> None:
    ripple = Ripple(frequency_hz=100, amplitude=0.05, phase_rad=0.0)
    noisy = 10 + 5 * np.random.default_rng(1).standard_normal((FRAMES, 2))
    (found,) = ripples_seen(_total(ripple, noise=0.01), noisy, ALL, TIME_S)
    assert found.lamp_share == 1.0


def test_white_noise_has_no_line_in_two_hundred_runs_but_by_chance() -> None:
    found = [ripples_seen(_total(noise=0.05, seed=seed), None, ALL, TIME_S) for seed in range(200)]
    assert sum(bool(lines) for lines in found) <= 2


@pytest.mark.parametrize("frames", [600, 601, 1000])
def test_a_change_from_frame_to_frame_is_no_line(frames: int) -> None:
    """At half the frame rate sine and cosine are one: each amplitude fits, with a phase of its own. What is near it is found."""
    index = np.arange(frames)
    alternating = np.asarray(50 * (1 + 0.1 * (-1.0) ** index), np.float64)
    assert ripples_seen(alternating, None, ALL[:frames], TIME_S[:frames]) == ()
    near = Ripple(frequency_hz=(0.5 - 10 / frames) / FRAME_S, amplitude=0.1, phase_rad=0.4)
    (found,) = ripples_seen(_total(near)[:frames], None, ALL[:frames], TIME_S[:frames])[:1]
    assert found.frequency_hz == pytest.approx(near.frequency_hz, rel=1e-4)
    assert found.amplitude == pytest.approx(0.1, rel=0.02)


def test_drift_is_no_line() -> None:
    """Half of the light goes, smoothly, over the run: below 40 Hz everything is drift."""
    drifting = 50 * (1 - 0.5 * np.sin(np.pi * TIME_S / TIME_S[-1]) ** 2) + _total(noise=0.01, mean=1.0) - 1
    assert ripples_seen(drifting, None, ALL, TIME_S) == ()
    slow = Ripple(frequency_hz=35, amplitude=0.1, phase_rad=0.0)
    assert all(line.amplitude < 0.05 for line in ripples_seen(_total(slow), None, ALL, TIME_S))


def test_holes_do_not_hide_a_line() -> None:
    ripple = Ripple(frequency_hz=100, amplitude=0.1, phase_rad=1.0)
    valid = np.arange(FRAMES) % 10 != 3
    found = ripples_seen(np.where(valid, _total(ripple), 0.0), None, valid, TIME_S)
    assert found[0].amplitude == pytest.approx(0.1, rel=0.01)
    assert found[0].frequency_hz == pytest.approx(100, abs=0.05)


@pytest.mark.parametrize(("frames", "found"), [(63, 0), (250, 0), (290, 1)])
def test_eight_periods_are_the_fewest(frames: int, found: int) -> None:
    """100 Hz at 300 us a frame: 8 periods are 267 frames."""
    total = _total(Ripple(frequency_hz=100, amplitude=0.1, phase_rad=1.0))[:frames]
    lines = ripples_seen(total, None, ALL[:frames], TIME_S[:frames])
    assert sum(abs(line.frequency_hz - 100) < 2 for line in lines) == found


def test_a_run_of_which_half_is_missing_says_nothing() -> None:
    total = _total(Ripple(frequency_hz=100, amplitude=0.1, phase_rad=1.0))
    assert ripples_seen(total, None, np.arange(FRAMES) % 2 == 0, TIME_S) != ()
    assert ripples_seen(total, None, np.arange(FRAMES) < 499, TIME_S) == ()
    assert ripples_seen(total - 60, None, ALL, TIME_S) == ()


def test_what_the_model_adds_is_taken_out() -> None:
    """A lamp that ripples multiplies, ambient light adds half of the total's share to each pattern."""
    time_s = np.arange(60, dtype=np.float64).reshape(10, 6) * 50e-6
    light = np.random.default_rng(2).uniform(10, 60, (10, 6))
    lamp = Ripple(frequency_hz=100, amplitude=0.2, phase_rad=0.3)
    both = Ripple(frequency_hz=130, amplitude=0.1, phase_rad=2.0, lamp_share=0.25)
    arrived = light * (1 + 0.25 * both.at(time_s)) + 0.75 * both.at(time_s) * 100 / 2
    arrived = arrived * (1 + lamp.at(time_s))
    np.testing.assert_allclose(without_ripples(arrived, time_s, (lamp, both), 100.0), light)
    assert without_ripples(arrived, time_s, (), 100.0) is arrived


def test_a_line_of_eight_periods_and_a_part_beside_a_constant_is_fitted_exactly() -> None:
    """A projection on cosine and sine would be off by some percent, as they are not at right angles to each other and to 1."""
    time_s = np.arange(600, dtype=np.float64) * 3e-4
    series = np.asarray(0.02 + 0.1 * np.cos(2 * np.pi * 47.3 * time_s - 0.4), np.float64)
    line = _line(series, time_s, 46.9, 1.4)
    assert line.frequency_hz == pytest.approx(47.3, abs=1e-3)
    assert line.amplitude == pytest.approx(0.1, abs=1e-5)
    assert line.phase_rad == pytest.approx(0.4, abs=1e-3)
