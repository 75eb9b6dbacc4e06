"""The image that gets better while frames come."""

import numpy as np
import pytest

from instrument.live import ProgressiveImager
from instrument.plan import Plan
from instrument.reconstruction import Region, reconstruct
from instrument.schemes import FourierHadamardSettings
from instrument.tracking import StreamingTracker
from protocols import Floats, InputError
from tests.instrument.live.streams import FRAMES, PLAN, SIZE, drift, letter, psnr, run
from tests.support.simulation import simulate


def _fed(imager: ProgressiveImager, values: Floats, step: int = 60) -> list[Floats | None]:
    """Frames as a live run brings them; the image after each ``step`` frames."""
    tracker, images = StreamingTracker(PLAN), list[Floats | None]()
    for first in range(0, len(values), step):
        new = values[first : first + step]
        imager.add(new, tracker.push(new))
        images.append(imager.improve())
    return images


def test_the_image_grows_with_the_run_and_the_polished_one_is_as_good_as_an_analysis() -> None:
    recording = run(0.1)
    assert recording.truth is not None
    imager = ProgressiveImager(PLAN)
    quality = [psnr(image, recording.truth.image) for image in _fed(imager, recording.values) if image is not None]
    assert len(quality) == 10
    assert quality[-1] > quality[4] > quality[0]
    assert quality[4] > 24
    polished = imager.polish()
    assert polished is not None
    same_motion = StreamingTracker(PLAN).push(recording.values)
    assert psnr(polished, recording.truth.image) > quality[-1]
    assert (
        psnr(polished, recording.truth.image)
        > psnr(reconstruct(recording, same_motion).image, recording.truth.image) - 1
    )
    assert imager.misfit == pytest.approx(1.0, abs=0.15)


def test_the_standard_run_has_26_5_db_after_a_fifth_of_a_second() -> None:
    """128 px, noise of 0.1 on every pixel, 67 px of path in 1,666 frames; ten images in the first 666 frames."""
    image = np.zeros((128, 128))
    image[12:48, 14:40] = 1.0
    image[19:27, 22:32] = 0.0
    image[33:41, 22:32] = 0.0
    plan = Plan(frames=1666)
    recording = simulate(
        plan,
        image,
        lambda t: np.stack([67 * (t + t * t) / 0.75, 63 * (t + t * t) / 0.75], axis=1),
        sigma=0.1,
        seed=1,
    )
    assert recording.truth is not None
    imager, tracker = ProgressiveImager(plan), StreamingTracker(plan)
    shown: Floats | None = None
    for first in range(0, 666, 67):
        values = recording.values[first : min(first + 67, 666)]
        imager.add(values, tracker.push(values))
        shown = imager.improve()
    assert shown is not None
    assert psnr(shown, recording.truth.image) > 26.5


def test_the_region_shrinks_as_the_path_becomes_known() -> None:
    """21.6 px to the right and 32.4 px down leave 42.4 x 31.6 px, give or take the tracker's last error."""
    imager = ProgressiveImager(PLAN, max_rows=FRAMES)
    _fed(imager, run().values)
    assert imager.region.left == imager.region.top == 0
    assert abs(imager.region.width - 43) <= 2
    assert abs(imager.region.height - 32) <= 2


def test_a_run_of_many_cycles_keeps_the_newest_frame_of_each_pattern_in_memory_that_does_not_grow() -> None:
    """16 px: 256 patterns, room for 100. Of cycles 0 and 1 nothing must be left, or the object that is gone would show."""
    plan = Plan(frames=256 * 3, image_size=16, scheme=FourierHadamardSettings(fourier_cycles=1))
    gone, here = np.zeros((16, 16)), np.zeros((16, 16))
    gone[2:6, 2:6], here[9:14, 8:12] = 1.0, 1.0
    imager = ProgressiveImager(plan, max_rows=100)
    sizes: list[int] = []
    for first, image in ((0, gone), (256, gone), (512, here)):
        values = simulate(plan, image, lambda t: np.zeros((len(t), 2))).values[first : first + 256]
        imager.add(values, np.zeros((256, 2)))
        imager.improve()
        sizes.append(imager.nbytes)
    assert (imager.frames, imager.rows) == (768, 100)
    shown = [imager.improve(40) for _ in range(5)][-1]
    assert shown is not None
    assert psnr(shown, here) > 30
    assert sizes[0] == sizes[1] == sizes[2]


def test_an_object_at_rest_is_imaged_from_its_coarsest_patterns_however_long_the_run() -> None:
    plan = Plan(frames=2000, image_size=32, scheme=FourierHadamardSettings(fourier_cycles=1))
    image = np.zeros((32, 32))
    image[8:18, 6:14] = 1.0
    recording = simulate(plan, image, lambda t: np.zeros((len(t), 2)), sigma=0.02, seed=1)
    imager = ProgressiveImager(plan)
    imager.add(recording.values, np.zeros((2000, 2)))
    assert imager.rows == 128
    shown = imager.polish()
    assert shown is not None
    assert psnr(shown, image) > 22


def test_one_large_block_is_as_many_small_ones() -> None:
    recording = run()
    assert recording.truth is not None
    at_once, bit_by_bit = ProgressiveImager(PLAN, max_rows=250), ProgressiveImager(PLAN, max_rows=250)
    at_once.add(recording.values, recording.truth.displacement_px)
    for first in range(0, FRAMES, 7):
        there = slice(first, first + 7)
        bit_by_bit.add(recording.values[there], recording.truth.displacement_px[there])
    one, other = at_once.improve(), bit_by_bit.improve()
    assert one is not None
    assert other is not None
    assert np.array_equal(one, other)


def test_frames_without_values_only_count() -> None:
    recording = run()
    assert recording.truth is not None
    holed = recording.values.copy()
    holed[100:400, 2] = np.nan
    imager = ProgressiveImager(PLAN, max_rows=FRAMES)
    imager.add(holed, recording.truth.displacement_px)
    assert (imager.frames, imager.rows) == (FRAMES, 300)
    image = imager.improve(100)
    assert image is not None
    assert psnr(image, recording.truth.image) > 20


def test_there_is_no_image_of_too_few_frames_or_of_the_dark() -> None:
    imager = ProgressiveImager(PLAN)
    assert imager.improve() is None
    imager.add(run().values[:15], np.zeros((15, 2)))
    assert imager.improve() is None
    assert np.isnan(imager.misfit)
    dark = ProgressiveImager(PLAN)
    dark.add(np.zeros((100, 6)), np.zeros((100, 2)))
    assert dark.improve() is None
    assert dark.polish() is None


def test_an_object_that_leaves_the_field_is_imaged_on_the_whole_of_it() -> None:
    away = simulate(PLAN, letter(), lambda t: t[:, None] * [-350.0, 0.0], sigma=0.02, seed=1)
    assert away.truth is not None
    imager = ProgressiveImager(PLAN, max_rows=FRAMES)
    imager.add(away.values, away.truth.displacement_px)
    assert imager.improve() is not None
    assert imager.region == Region.whole(SIZE)


def test_a_jump_after_a_gap_is_no_velocity() -> None:
    """Over the missing frames 1 to 349 the object goes 17 px: taken for a step, it would put H+ and H- 3 px apart."""
    plan = PLAN.model_copy(update={"scheme": FourierHadamardSettings(shuffle_seed=0)})
    recording = simulate(plan, letter(), drift, sigma=0.05, seed=1)
    assert recording.truth is not None
    imager = ProgressiveImager(plan, max_rows=FRAMES)
    imager.add(recording.values[:1], recording.truth.displacement_px[:1])
    imager.add(np.full((349, 6), np.nan), np.zeros((349, 2)))
    imager.add(recording.values[350:], recording.truth.displacement_px[350:])
    imager.polish()
    assert imager.misfit == pytest.approx(1.0, abs=0.15)


def test_frames_without_displacements_are_refused() -> None:
    with pytest.raises(InputError, match=r"displacements of shape \(3, 2\)"):
        ProgressiveImager(PLAN).add(np.ones((4, 6)), np.ones((3, 2)))


def test_room_for_too_few_rows_is_refused() -> None:
    with pytest.raises(InputError, match="max_rows = 15; expected 16 or more"):
        ProgressiveImager(PLAN, max_rows=15)
