"""The scheme that shows pictures by name: what is played, and what is refused."""

import numpy as np
import pytest
from pydantic import ValidationError

from instrument.patterns import picture
from instrument.plan import Plan
from instrument.schemes import scheme_of
from instrument.session import simulate


def plan(frames: int, show: list[str], each: int = 1) -> Plan:
    table = {"name": "pictures", "show": show, "each": each}
    return Plan.model_validate({"frames": frames, "image_size": 16, "superpixel": 4, "scheme": table})


def test_pictures_are_played_in_their_order_and_from_the_start_again() -> None:
    show = ["white", "half", "white"]
    sequence = scheme_of(plan(9, show, each=2)).sequence()
    names = ["white", "white", "half", "half", "white", "white", "white", "white", "half", "black"]
    for index, name in zip(sequence.play_order, names, strict=True):
        np.testing.assert_array_equal(sequence.sample_plane(int(index)), picture(name, 16))
    assert len(sequence.planes) == 3


def test_values_are_the_light_of_each_picture() -> None:
    image = np.zeros((16, 16))
    image[4, 3] = image[10, 12] = 0.5
    recording = simulate(plan(5, ["white", "half", "black", "not half", "block:10,12,1,1"]), image=image)
    np.testing.assert_allclose(recording.values[:, 0] / recording.values[0, 0], [1, 0.5, 0, 0.5, 0.5])
    assert recording.timing is not None
    assert recording.timing.verdict == "good"


def test_a_run_whose_light_changes_wildly_is_not_taken_for_one_that_slipped() -> None:
    noise = {"kind": "poisson", "peak_counts": 100, "seed": 1}
    recording = simulate(plan(600, ["white", "black", "black", "half", "white"]), {"noise": noise})
    assert recording.timing is not None
    assert recording.timing.verdict == "good"
    assert recording.timing.slipped == ()


@pytest.mark.parametrize(("show", "word"), [([], "show"), (["wite"], "wite"), (["columns:0-17"], "17")])
def test_names_of_no_picture_are_refused_with_the_plan(show: list[str], word: str) -> None:
    with pytest.raises(ValidationError, match=word):
        plan(5, show)


def test_a_plan_file_reads_them(tmp_path: pytest.TempPathFactory) -> None:
    assert plan(5, ["white"]) == Plan.from_json(plan(5, ["white"]).model_dump_json())
