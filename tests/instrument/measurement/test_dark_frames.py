"""Frames without light are told from dim ones, from short dips, and from what few photons may do by chance."""

from dataclasses import replace

import numpy as np
import pytest

from instrument import Plan, Recording, simulate
from instrument.analysis import analyse
from instrument.measurement import Measurement
from instrument.measurement.dark_frames import dark_frames
from protocols import Floats

PLAN = Plan(frames=400, image_size=32)


def light(level: float, frames: slice, noise: float = 1.0) -> Floats:
    """A hundred frames of 100, some of them at another level."""
    total = np.full(100, 100.0)
    total[frames] = level
    return total + noise * np.where(np.arange(100) % 2, 1.0, -1.0)


@pytest.mark.parametrize(
    ("level", "frames", "dark"),
    [
        (0.0, slice(30, 50), range(29, 51)),
        (0.0, slice(30, 39), range(29, 40)),
        (0.0, slice(30, 38), range(0)),
        (1.5, slice(30, 50), range(29, 51)),
        (2.5, slice(30, 50), range(0)),
        (0.0, slice(0, 50), range(51)),
        (0.0, slice(80, 100), range(79, 100)),
    ],
)
def test_nine_frames_in_a_row_are_dark_or_none(level: float, frames: slice, dark: range) -> None:
    """At a fiftieth of the light or less, and with the frame before and after, which may be dark in part."""
    assert np.flatnonzero(dark_frames(light(level, frames), photon_counts=False)).tolist() == list(dark)


def test_nothing_is_dark_where_dim_light_would_not_be_seen() -> None:
    """Steps of twice the noise are 2.1 times it by their median; four thirds of that are more than 8 of 100 from 2.9 on."""
    frames = slice(30, 50)
    assert not dark_frames(light(0.0, frames, 10.0), photon_counts=False).any()
    assert not dark_frames(light(0.0, frames, 3.0), photon_counts=False).any()
    assert dark_frames(light(0.0, frames, 2.5), photon_counts=False).any()
    assert dark_frames(light(0.0, frames, 3.0), photon_counts=True).any()


def test_what_is_not_known_is_not_dark() -> None:
    total = light(np.nan, slice(30, 50))
    assert not dark_frames(total, photon_counts=False).any()
    assert not dark_frames(np.zeros(100), photon_counts=False).any()
    assert not dark_frames(total[:17], photon_counts=False).any()


@pytest.fixture(scope="module")
def run() -> Recording:
    noise = {"kind": "poisson", "peak_counts": 500.0, "seed": 2}
    return simulate(
        PLAN,
        {"object": "letter-B", "object_height_px": 10, "start_px": [10.3, 10.4], "noise": noise},
        path=lambda time_s: np.stack([90 * time_s, 60 * time_s], axis=1),
    )


def shuttered(run: Recording, frames: slice) -> Recording:
    values = run.values.copy()
    values[frames] = np.random.default_rng(1).poisson(0.3, values[frames].shape)
    return replace(run, values=values)


def test_a_shutter_in_the_run_is_told_and_no_slip(run: Recording) -> None:
    found = Measurement.of(shuttered(run, slice(150, 200)))
    assert [(finding.kind, finding.text) for finding in found.findings] == [
        ("no light", "52 frames without light masked: 149 to 200")
    ]
    assert np.flatnonzero(~found.valid).tolist() == list(range(149, 201))


def test_of_a_run_that_begins_in_the_dark_displacement_counts_from_the_first_frame_that_was_measured(
    run: Recording,
) -> None:
    found = analyse(shuttered(run, slice(0, 60)))
    assert found.reference_frame == found.figures.reference_frame == 61
    assert found.figures.rows()["displacement from"] == "frame 61, whose image is shown"
    assert found.trajectory is not None
    assert found.truth_px is not None
    assert found.trajectory.displacement_px[61].tolist() == [0, 0]
    assert np.mean((found.trajectory.displacement_px - found.truth_px)[61:] ** 2) < 0.05


def test_a_few_frames_after_a_dark_beginning_are_as_sure_as_a_few_alone(run: Recording) -> None:
    """39 frames: no image, and no uncertainty of a frame 0 that lies in the dark."""
    found, alone = (analyse(some).figures.sigma_px for some in (shuttered(run, slice(0, 360)), run.first(39)))
    assert found is not None
    assert alone is not None
    assert 0.3 < found / alone < 3
