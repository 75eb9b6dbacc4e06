"""What is believed of a run whose path and image contradict each other.

The axes of the run are exchanged. The quick looks at it are real, and the misfits of what is followed in full are given.
"""

from dataclasses import replace

import numpy as np
import pytest

from instrument import Plan, Recording, reconstruct, simulate
from instrument.analysis.explanations import explained
from instrument.analysis.find import Found
from instrument.analysis.otherwise import otherwise, squares_of
from instrument.measurement import Measurement, Slips
from protocols import Floats, InputError

PLAN = Plan(frames=128, image_size=32)
EXCHANGED = "the fringes along x and y are exchanged"


def path(time_s: Floats) -> Floats:
    return np.stack([9 * time_s / PLAN.run_time_s, 3 * time_s / PLAN.run_time_s], axis=1)


@pytest.fixture(scope="module")
def recording() -> Recording:
    scene = {
        "object": "letter-B",
        "object_height_px": 10,
        "start_px": [12.4, 15.7],
        "noise": {"kind": "pixel", "sigma": 0.1},
    }
    return simulate(PLAN, scene, path=path)


@pytest.fixture(scope="module")
def run(recording: Recording) -> Measurement:
    """With the axes exchanged; nobody asks whether values slipped."""
    measurement = Measurement.of(replace(recording, values=recording.values[:, [2, 3, 0, 1, 4, 5]]))
    return replace(measurement, slips=None)


def unasked(_slips: Slips) -> Measurement:
    raise AssertionError


def believed(run: Measurement, as_planned: tuple[float, float] | None, otherwise_: tuple[float, float]) -> list[str]:
    """Give what was followed in full, and at the end what was believed, by misfits of positions and image."""
    asked: list[str] = []

    def find(other: Measurement) -> Found:
        asked.append(other.findings[-1].text)
        return Found(other, position_misfit=otherwise_[0], usual_misfit=otherwise_[1])

    found = None
    if as_planned is not None:
        image = replace(reconstruct(run, None, "conventional"), misfit=as_planned[1])
        found = Found(run, reconstruction=image, position_misfit=as_planned[0], usual_misfit=as_planned[1])
    better = otherwise(run, found, find, unasked)
    return [*asked, "nothing" if better is None else better[0].findings[-1].text]


def test_only_the_likeliest_is_followed_in_full_and_believed(run: Measurement) -> None:
    assert believed(run, (2.0, 1.0), (1.0, 1.0)) == [EXCHANGED, EXCHANGED]


def test_it_is_believed_where_nothing_was_found_as_planned(run: Measurement) -> None:
    assert believed(run, None, (1.0, 1.0)) == [EXCHANGED, EXCHANGED]
    assert believed(run, None, (1.49, 1.0)) == [EXCHANGED, EXCHANGED]
    assert believed(run, None, (1.51, 1.0)) == [EXCHANGED, "nothing"]


def test_nothing_is_looked_at_where_position_and_image_agree(run: Measurement) -> None:
    assert believed(run, (1.09, 1.0), (0.9, 0.9)) == ["nothing"]
    assert believed(run, (np.nan, np.nan), (0.9, 0.9)) == ["nothing"]


@pytest.mark.parametrize(
    ("position_misfit", "image_misfit", "word"),
    [
        (np.sqrt(1 + 0.49 * 0.44), 1.0, EXCHANGED),  # of 1.2^2 - 1 = 0.44 it must leave less than half
        (np.sqrt(1 + 0.51 * 0.44), 1.0, "nothing"),
        (1.0, 1.019, EXCHANGED),  # the image may be worse by 0.02
        (1.0, 1.021, "nothing"),
        (
            np.sqrt(1 + 0.51 * 0.44),
            np.sqrt(1 - 51 / 128),
            EXCHANGED,
        ),  # a sum of squares that falls by 50 says so by itself
        (np.sqrt(1 + 0.51 * 0.44), np.sqrt(1 - 49 / 128), "nothing"),
    ],
)
def test_it_must_explain_far_more(run: Measurement, position_misfit: float, image_misfit: float, word: str) -> None:
    assert believed(run, (1.2, 1.0), (position_misfit, image_misfit))[-1] == word


@pytest.mark.parametrize(("image_misfit", "word"), [(1.021, EXCHANGED), (1.019, "nothing")])
def test_where_positions_agree_both_ways_a_blurred_image_tells_exchanged_axes(
    run: Measurement, image_misfit: float, word: str
) -> None:
    assert believed(run, (1.0, image_misfit), (1.0, np.sqrt(image_misfit**2 - 51 / 128)))[-1] == word


def test_what_refuses_explains_nothing(run: Measurement) -> None:
    def refuse(other: Measurement) -> Found:
        raise InputError(saw=other.findings[-1].text, expected="an object", remedy="none")

    assert otherwise(run, Found(run, position_misfit=2.0, usual_misfit=1.0), refuse, unasked) is None


def test_squares_are_those_of_valid_frames(run: Measurement) -> None:
    valid = np.arange(400) < 32
    assert squares_of(Found(replace(run, valid=valid), usual_misfit=2.0)) == 128.0


@pytest.mark.parametrize(("position_misfit", "looks"), [(0.4, 0), (0.9, 1), (1.2, 0)])
def test_slips_are_looked_for_where_positions_agree_by_their_noise_and_the_image_does_not(
    recording: Recording, position_misfit: float, looks: int
) -> None:
    """Values without noise have not slipped, and positions that disagree ask for other explanations first."""
    measurement, asked = Measurement.of(recording), list[Slips]()

    def screen(slips: Slips) -> Measurement:
        asked.append(slips)
        raise InputError(saw="a shift", expected="none", remedy="none")

    def find(other: Measurement) -> Found:
        return Found(other, position_misfit=position_misfit, usual_misfit=1.2)

    if looks:
        with pytest.raises(InputError):
            explained(measurement, find, screen)
    else:
        explained(measurement, find, screen)
    assert len(asked) == looks
