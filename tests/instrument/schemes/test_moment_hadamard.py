"""What the four patterns of Guo 2022 are, and what their values mean."""

import numpy as np
import pytest
from pydantic import ValidationError

from instrument.patterns import ramp
from instrument.plan import Plan
from instrument.schemes import image_rows_of, position_of, scheme_of
from tests.support.plans import plan_of

SMALL = plan_of("moment-hadamard", frames=1, image_size=8)


def test_a_run_of_1666_frames_has_3334_unique_patterns_and_6665_pictures() -> None:
    """Two ramps and 2 x 1,666 Hadamard patterns; 4 x 1,666 pictures and the guard, two dithering samples a pixel side."""
    sequence = scheme_of(plan_of("moment-hadamard", frames=1666)).sequence()

    assert len(sequence.planes) == 3334
    assert len(np.unique(sequence.planes.reshape(3334, -1), axis=0)) == 3334
    assert len(sequence.play_order) == 6665
    assert sequence.play_order[:8].tolist() == [0, 1, 2, 3, 0, 1, 4, 5]
    assert sequence.samples == 256


def test_the_guard_is_the_dark_complement_of_the_all_one_pattern() -> None:
    sequence = scheme_of(plan_of("moment-hadamard", frames=5, image_size=16)).sequence()

    assert len(sequence.planes) == 2 + 2 * 5
    assert sequence.play_order[-1] == 3
    assert not sequence.sample_plane(3).any()


def test_decoding_of_one_frame_by_hand() -> None:
    """S = 6 + 4 = 10 and m = 8: the centroid is 8 x 5 / 10 - 1/2 = 3.5 px and 8 x 2.5 / 10 - 1/2 = 1.5 px."""
    scheme = scheme_of(SMALL)
    values = np.array([[5.0, 2.5, 6.0, 4.0]])
    total = values @ scheme.light_weights

    assert total.tolist() == [10.0]
    np.testing.assert_allclose(position_of(scheme).signal(values, total), [[3.5, 1.5]], atol=1e-12)
    assert position_of(scheme).period_px is None


def test_each_column_says_what_it_is() -> None:
    """The patterns begin at 0, 1/4, 1/2 and 3/4 of the frame: their middles are 3/8 and 1/8 of it before and after its middle."""
    columns = scheme_of(SMALL).columns

    assert [column.role for column in columns] == ["moment", "moment", "hadamard", "hadamard"]
    assert [column.axis for column in columns] == ["x", "y", None, None]
    assert [column.sign for column in columns] == [1, 1, 1, -1]
    np.testing.assert_allclose([column.after_middle_frames for column in columns], [-3 / 8, -1 / 8, 1 / 8, 3 / 8])
    rows = image_rows_of(scheme_of(SMALL))
    assert (rows.positive, rows.negative) == (2, 3)


def test_a_lit_pixel_is_found_where_it_is_by_grey_ramps() -> None:
    """Row 2, column 5, of transmission 0.7: any centroid is that pixel, however bright."""
    image = np.zeros((8, 8))
    image[2, 5] = 0.7
    values = np.array([[float((image * ramp(8, "x")).sum()), float((image * ramp(8, "y")).sum()), 0.7, 0.0]])

    np.testing.assert_allclose(position_of(scheme_of(SMALL)).signal(values, np.array([0.7])), [[5.0, 2.0]], atol=1e-12)


def test_the_binary_ramps_light_as_many_samples_as_the_grey_ones() -> None:
    """Half of all; error diffusion loses at most what leaves the pattern at its borders. In each eighth of the field too."""
    patterns = scheme_of(plan_of("moment-hadamard", frames=1, image_size=64)).fixed_patterns.astype(np.float64)

    assert patterns.shape == (2, 128, 128)
    assert patterns.mean(axis=(1, 2)) == pytest.approx([0.5, 0.5], abs=0.005)
    eighths = (np.arange(8) + 0.5) / 8
    np.testing.assert_allclose(patterns[0].mean(axis=0).reshape(8, 16).mean(axis=1), eighths, atol=0.02)
    np.testing.assert_allclose(patterns[1].mean(axis=1).reshape(8, 16).mean(axis=1), eighths, atol=0.02)


def test_the_dithering_samples_of_a_pixel_are_two_and_must_be_whole_mirrors() -> None:
    assert plan_of("moment-hadamard", frames=1).scheme.model_dump()["upsampling"] == 2
    with pytest.raises(ValidationError, match="upsampling is 2: it must divide superpixel = 1"):
        Plan.model_validate({"frames": 1, "superpixel": 1, "scheme": "moment-hadamard"})
