"""Counts that stand still are told as what they are, and not as values that slipped."""

from dataclasses import replace

import numpy as np
import pytest

from instrument import Plan, Recording, simulate
from instrument.measurement import Measurement
from instrument.measurement.stuck_counts import saturated, stuck_counts


@pytest.mark.parametrize(("count", "level", "photon_counts", "stuck"), [
    (30, 7.0, True, 30),
    (29, 7.0, True, 0),
    (30, 0.0, True, 0),
    (30, 7.0, False, 0),
    (30, 999.0, False, 30),
])  # fmt: skip
def test_thirty_equal_values_in_a_row_stand_still(count: int, level: float, photon_counts: bool, stuck: int) -> None:  # noqa: FBT001
    """Of photons at any level but 0, of other values at the highest one."""
    values = np.arange(1000.0, 1120.0) % 100 + 100
    values[17 : 17 + count] = level
    found = stuck_counts(values.reshape(20, 6), photon_counts=photon_counts)
    assert np.flatnonzero(found).tolist() == list(range(17, 17 + stuck))


def test_what_is_not_known_and_a_run_of_one_value_are_not_stuck() -> None:
    assert not stuck_counts(np.full((20, 6), np.nan), photon_counts=False).any()
    assert not stuck_counts(np.full((20, 6), 5.0), photon_counts=True).any()
    assert stuck_counts(np.full((20, 6), 5.0), photon_counts=True).shape == (20, 6)
    two_levels = np.repeat([5.0, 7.0], 60).reshape(20, 6)
    two_levels[0, :2] = 6.0, 4.0
    assert not stuck_counts(two_levels, photon_counts=True).any()
    two_levels[19, 5] = 8.0
    assert np.count_nonzero(stuck_counts(two_levels, photon_counts=True)) == 58 + 59


@pytest.fixture(scope="module")
def run() -> Recording:
    return simulate(
        Plan(frames=200, image_size=32),
        {
            "object": "letter-B",
            "object_height_px": 10,
            "start_px": [10.3, 10.4],
            "noise": {"kind": "poisson", "peak_counts": 200.0, "seed": 2},
        },
        path=lambda time_s: np.stack([90 * time_s, 60 * time_s], axis=1),
    )


@pytest.mark.parametrize("at_most", [255.0, 120.0])
def test_a_detector_that_saturates_in_mid_run_is_told_and_no_slip(run: Recording, at_most: float) -> None:
    values = run.values.copy()
    values[100:150] = at_most
    found = Measurement.of(replace(run, values=values))
    assert [(finding.kind, finding.text) for finding in found.findings] == [
        ("stuck counts", "300 equal values in a row masked: frames 100 to 149")
    ]
    assert np.flatnonzero(~found.valid).tolist() == list(range(100, 150))


def test_a_detector_that_saturates_at_bright_patterns_is_told(run: Recording) -> None:
    at_most = float(np.round(np.quantile(run.values, 0.97)))
    found = Measurement.of(replace(run, values=np.minimum(run.values, at_most)))
    (finding,) = [one for one in found.findings if one.kind == "stuck counts"]
    count = int(np.count_nonzero(run.values >= at_most))
    assert finding.text == f"{count} values are {at_most:g}, and none is higher"
    assert found.valid.all()
    assert not [one for one in Measurement.of(run).findings if one.kind == "stuck counts"]


def test_the_highest_value_is_saturation_only_if_it_is_frequent_and_not_always_there() -> None:
    """Of 1,200 values a hundredth are 12, and twenty are asked for."""
    values = np.random.default_rng(1).integers(20, 90, (200, 6)).astype(np.float64)
    values[:20, 2] = 99.0
    assert np.count_nonzero(saturated(values, photon_counts=True)) == 20
    values[19, 2] = 50.0
    assert not saturated(values, photon_counts=True).any()
    values[:110, 2] = 99.0
    assert np.count_nonzero(saturated(values, photon_counts=True)) == 110
    assert not saturated(values, photon_counts=False).any()
    values[100:110, 2] = 50.0
    assert np.count_nonzero(saturated(values, photon_counts=False)) == 100
    values[:, 2] = 99.0
    assert not saturated(values, photon_counts=True).any()
    few = np.random.default_rng(1).poisson(10.0, (200, 6)).astype(np.float64)
    assert not saturated(np.minimum(few, 10.0), photon_counts=True).any()
    assert saturated(np.minimum(few, 11.0), photon_counts=True).any()
