"""Where light is steady, and where it falls or rises at an end of the run. Runs of 400 frames: means over 21, and late over 9."""

import numpy as np
import pytest

from instrument.analysis.changing_light import fall_of, rise_of
from protocols import Floats

FRAMES = 400
VALID = np.ones(FRAMES, bool)


def light(first: int, last_level: float) -> Floats:
    """A hundred, and from a frame on along a line to another level in the last; noise of a half."""
    total = np.full(FRAMES, 100.0)
    total[first:] = np.linspace(100.0, last_level, FRAMES - first)
    return total + 0.5 * np.where(np.arange(FRAMES) % 2, 1.0, -1.0)


def test_a_long_fall_begins_where_its_means_do() -> None:
    """It loses a half a frame: 1.5 % of the mean over 21 are lost at about 302, whose mean begins at 292."""
    found = fall_of(light(300, 50.0), VALID)
    assert found is not None
    assert found.half == 10
    assert 289 <= found.frames.start <= 295
    assert found.frames.stop == FRAMES
    assert found.light[350] == pytest.approx(0.7475, abs=0.003)
    assert found.light[100] == pytest.approx(1.0, abs=0.003)


def test_a_late_fall_is_seen_in_shorter_means() -> None:
    """3 % in the last 8 frames: 1.1 % of the last mean over 11, 2.1 % of that over 5. 1.5 % of one over 9 at 396 or 397."""
    found = fall_of(light(392, 97.0), VALID)
    assert found is not None
    assert found.half == 4
    assert 390 <= found.frames.start <= 393
    assert found.light[399] == pytest.approx(0.979, abs=0.002)


def test_a_rise_is_a_fall_from_the_end() -> None:
    total = light(300, 50.0)
    fall, rise = fall_of(total, VALID), rise_of(total[::-1], VALID)
    assert fall is not None
    assert rise is not None
    assert (rise.frames.start, rise.frames.stop) == (0, FRAMES - fall.frames.start)
    np.testing.assert_array_equal(rise.light, fall.light[::-1])
    assert rise_of(total, VALID) is None
    assert fall_of(total[::-1], VALID) is None


@pytest.mark.parametrize("frames", [1, 2, FRAMES])
def test_steady_light_does_not_fall(frames: int) -> None:
    assert fall_of(light(300, 100.0)[:frames], VALID[:frames]) is None
    assert fall_of(np.zeros(frames), VALID[:frames]) is None


def test_a_lamp_that_falls_from_the_beginning_on_or_flickers_is_none() -> None:
    assert fall_of(np.linspace(100.0, 60.0, FRAMES), VALID) is None
    for phase in np.linspace(0, 2 * np.pi, 8, endpoint=False):
        assert fall_of(100 + 20 * np.cos(2 * np.pi * np.arange(FRAMES) / 21 + phase), VALID) is None


@pytest.mark.parametrize("masked", [slice(380, FRAMES), slice(0, 60), slice(300, 350)])
def test_frames_that_are_not_valid_count_for_nothing(masked: slice) -> None:
    """More of them than a mean reaches over: light that nobody measured has not fallen."""
    total, valid = light(300, 100.0), VALID.copy()
    valid[masked] = False
    total[masked] = -1e6
    assert (fall_of(total, valid), rise_of(total, valid)) == (None, None)


def test_a_fall_is_seen_as_far_as_it_was_measured() -> None:
    """Of 300 frames of 100 and a fall to 50 in 400, the last 30 are masked: the light of frame 369 stands for them, 65.2."""
    total, valid = light(300, 50.0), VALID.copy()
    valid[370:] = False
    total[370:] = 0.0
    found = fall_of(total, valid)
    assert found is not None
    assert 289 <= found.frames.start <= 295
    assert found.light[350] == pytest.approx(0.7475, abs=0.003)
    assert found.light[399] == pytest.approx(0.655, abs=0.01)
