"""Counts that stand still are told as what they are, and not as values that slipped."""

from dataclasses import replace

import numpy as np
import pytest

from instrument import Plan, Recording, simulate
from instrument.measurement import Measurement
from instrument.measurement.stuck_counts import stuck_counts


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
