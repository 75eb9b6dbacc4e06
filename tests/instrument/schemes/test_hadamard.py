"""What the two patterns of conventional imaging are, and what it gives of an object at rest."""

import numpy as np
import pytest

from instrument.analysis import analyse
from instrument.numerics import psnr
from instrument.patterns import hadamard_signs
from instrument.schemes import image_rows_of, scheme_of
from instrument.tracking import StreamingTracker, track
from protocols import Floats, InputError
from tests.support.plans import plan_of
from tests.support.simulation import simulate


def _image(size: int) -> Floats:
    """A square ring, 0.5 and 1 bright."""
    image = np.zeros((size, size))
    image[4:12, 3:11] = 1.0
    image[6:10, 5:9] = 0.5
    return image


def _rest(time_s: Floats) -> Floats:
    return np.zeros((len(time_s), 2))


def test_a_run_of_1666_frames_has_3332_unique_patterns_and_3333_pictures() -> None:
    """2 x 1,666 pictures and the guard, which is the dark complement of the first pattern."""
    sequence = scheme_of(plan_of("hadamard", frames=1666)).sequence()

    assert len(sequence.planes) == 3332
    assert len(np.unique(sequence.planes.reshape(3332, -1), axis=0)) == 3332
    assert sequence.play_order.tolist() == [*range(3332), 1]
    assert not sequence.sample_plane(1).any()
    assert sequence.samples == 128


def test_patterns_repeat_when_all_have_been_shown() -> None:
    """8 x 8 = 64 pairs in 70 frames: 128 planes, the 65th frame is the first one again."""
    sequence = scheme_of(plan_of("hadamard", frames=70, image_size=8)).sequence()

    assert len(sequence.planes) == 128
    assert sequence.play_order[128:132].tolist() == [0, 1, 2, 3]


def test_the_values_of_one_frame_by_hand() -> None:
    """Frame 1 of the TV order lights the upper or the left half; 12 + 4 = 16 of light, I_H = 8."""
    scheme = scheme_of(plan_of("hadamard", frames=2, image_size=8))
    values = np.array([[16.0, 0.0], [12.0, 4.0]])
    rows = image_rows_of(scheme)

    assert (values @ scheme.light_weights).tolist() == [16.0, 16.0]
    assert (values[:, rows.positive] - values[:, rows.negative]).tolist() == [16.0, 8.0]
    sign = hadamard_signs(8, rows.pairs[1:2])[0]
    assert abs(sign[:4].sum()) + abs(sign[:, :4].sum()) == 32  # one half along one axis is all +1


def test_each_column_says_what_it_is() -> None:
    scheme = scheme_of(plan_of("hadamard", frames=1))

    assert [(column.role, column.axis, column.sign) for column in scheme.columns] == [
        ("hadamard", None, 1),
        ("hadamard", None, -1),
    ]
    assert [column.after_middle_frames for column in scheme.columns] == [-0.25, 0.25]
    assert scheme.fixed_patterns.shape == (0, 128, 128)
    assert scheme.position is None


def test_all_patterns_give_the_image_of_an_object_at_rest_exactly() -> None:
    """The inverse transform of all 256 coefficients."""
    recording = simulate(plan_of("hadamard", frames=256, image_size=16), _image(16), _rest)

    found = analyse(recording, method="conventional")

    assert found.image is not None
    np.testing.assert_allclose(found.image, _image(16), atol=1e-9)
    assert found.figures.psnr_db is not None
    assert 200 < found.figures.psnr_db <= 300
    assert found.trajectory is None
    assert found.refinements == 0
    assert found.figures.travel_px is None
    assert found.figures.displacement_mse_px2 is None
    assert set(found.figures.rows()) == {"frames", "PSNR", "SSIM", "analysis"}


def test_half_of_the_patterns_under_noise_give_a_good_image_by_least_total_variation() -> None:
    """Noise of 0.05 on every pixel: the inverse transform of as many coefficients has some 10 dB less."""
    image = np.pad(_image(16), ((8, 8), (8, 8)))
    recording = simulate(plan_of("hadamard", frames=512, image_size=32), image, _rest, sigma=0.05, seed=3)

    smooth, inverse = analyse(recording), analyse(recording, method="conventional")

    assert smooth.image is not None
    assert inverse.image is not None
    assert psnr(smooth.image, image) > 30
    assert psnr(smooth.image, image) > psnr(inverse.image, image) + 3
    assert smooth.figures.misfit == pytest.approx(1.0, abs=0.1)


def test_tracking_is_refused_and_says_what_to_do() -> None:
    plan = plan_of("hadamard", frames=20, image_size=16)
    recording = simulate(plan, _image(16), _rest)

    for attempt in (lambda: track(recording), lambda: track(recording, "per-frame"), lambda: StreamingTracker(plan)):
        with pytest.raises(InputError, match="the scheme hadamard, whose patterns see no position") as caught:
            attempt()
        assert 'record with another scheme, such as "fourier-hadamard"' in caught.value.remedy
