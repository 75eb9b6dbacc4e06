"""The light model applied to a stream: the same as to a whole run, in whatever blocks the frames come."""

import numpy as np
import pytest

from instrument.measurement import LightModel, LightStream, Parameter
from instrument.measurement.leak import without_leak
from instrument.plan import Plan
from instrument.schemes import scheme_of

SCHEME = scheme_of(Plan(frames=40, image_size=16))


@pytest.mark.parametrize("block", [1, 7, 40])
def test_a_leak_is_taken_out_over_the_ends_of_blocks_as_of_the_whole_run(block: int) -> None:
    values = np.random.default_rng(1).uniform(50.0, 150.0, (40, 6))
    stream = LightStream(SCHEME, LightModel(leak=Parameter(value=0.1)))
    found = np.concatenate([stream.take(values[first : first + block]) for first in range(0, 40, block)])
    np.testing.assert_allclose(found, without_leak(values, 0.1), rtol=1e-12)


def test_the_first_two_patterns_by_hand() -> None:
    """Y = (1 - c) v + c v before, dark before the first: 90 = 0.9 v, so v = 100; 100 = 0.9 v + 0.1 x 100, so v = 100 again."""
    values = np.array([[90.0, 100.0, 100.0, 100.0, 100.0, 100.0]])
    found = LightStream(SCHEME, LightModel(leak=Parameter(value=0.1))).take(values)
    np.testing.assert_allclose(found, 100.0)


def test_offsets_are_shares_of_the_total_light() -> None:
    """A total of 120 + 80 = 200, of which 1, 2, 3 and 4 % are taken from the four fringes."""
    light = LightModel(offsets=tuple(Parameter(value=share) for share in (0.01, 0.02, 0.03, 0.04)))
    found = LightStream(SCHEME, light).take(np.array([[100.0, 100.0, 100.0, 100.0, 120.0, 80.0]]))
    np.testing.assert_allclose(found, [[98.0, 96.0, 94.0, 92.0, 120.0, 80.0]])


def test_what_was_not_measured_stays_so_and_an_ideal_bench_changes_nothing() -> None:
    values = np.array([[100.0, np.nan, 100.0, 100.0, 120.0, 80.0]])
    np.testing.assert_array_equal(LightStream(SCHEME, LightModel()).take(values), values)
    leaking = LightStream(SCHEME, LightModel(leak=Parameter(value=0.1))).take(values)
    assert np.isnan(leaking).tolist() == [[False, True, False, False, False, False]]
