"""The table of image methods, and what is refused before any work."""

from typing import get_args

import numpy as np
import pytest

from instrument import analyse, reconstruct, track
from instrument.choices import Method
from instrument.plan import Plan
from instrument.reconstruction import METHODS
from instrument.recording import Recording
from protocols import InputError
from tests.support.simulation import simulate


def _recording() -> Recording:
    image = np.zeros((16, 16))
    image[4:8, 5:9] = 1.0
    return simulate(Plan(frames=40, image_size=16), image, lambda t: np.zeros((len(t), 2)), sigma=0.01)


def test_the_table_holds_the_methods_that_the_command_offers() -> None:
    assert tuple(METHODS) == get_args(Method)


def test_names_that_nobody_knows_are_refused_with_those_that_there_are() -> None:
    recording = _recording()
    motion = np.zeros((40, 2))
    with pytest.raises(InputError, match=r"saw the tracking method 'banana'; expected one of smooth, per-frame"):
        track(recording, method="banana")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match=r"saw the tracking 'banana'; expected one of joint, smooth, per-frame"):
        analyse(recording, tracking="banana")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match=r"saw the image method 'fista'; expected one of tv, tv-fourier, tv-bregman"):
        reconstruct(recording, motion, "fista")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match=r"saw the image method 'fista'"):
        analyse(recording, method="fista")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]


def test_settings_of_another_method_are_refused() -> None:
    recording = _recording()
    with pytest.raises(InputError, match=r"saw mean_filter for the method smooth, which has no such setting"):
        track(recording, mean_filter=5)
    with pytest.raises(InputError, match=r"saw a strength of 3 for the method dgi"):
        reconstruct(recording, None, "dgi", strength=3.0)
    with pytest.raises(InputError, match=r"saw a strength of 3 for the method tv-al"):
        reconstruct(recording, None, "tv-al", strength=3.0)


def test_an_object_at_rest_needs_no_motion() -> None:
    recording = _recording()
    still, zero = (reconstruct(recording, motion).image for motion in (None, np.zeros((40, 2))))
    np.testing.assert_array_equal(still, zero)
