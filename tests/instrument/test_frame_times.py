"""When frames are."""

from instrument.frame_times import frame_middle_s


def test_the_middle_of_a_frame_is_half_a_frame_after_its_start() -> None:
    assert frame_middle_s(3, 0.25).tolist() == [0.125, 0.375, 0.625]
    assert len(frame_middle_s(0, 0.3)) == 0
