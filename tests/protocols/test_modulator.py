"""Limits of a modulator refuse by their figures."""

import numpy as np
import pytest

from protocols import (
    ModulatorLimits,
    ModulatorTiming,
    PatternMemoryFull,
    PatternSequence,
    PictureTimeTooShort,
    PixelGrid,
    PlanError,
)

LIMITS = ModulatorLimits(
    columns=1024,
    rows=768,
    shortest_picture_time_us=44,
    longest_picture_time_us=10_000_000,
    unique_patterns=2,
    play_order_entries=3,
)


def sequence(unique: int = 2, pictures: int = 3, columns: int = 1024) -> PatternSequence:
    grid = PixelGrid(image_size=8, superpixel=1, columns=columns)
    return PatternSequence(np.zeros((unique, 8, 1), np.uint8), np.zeros(pictures, np.int64), grid, samples=8)


def test_a_sequence_that_just_fits_is_taken() -> None:
    LIMITS.check_sequence(sequence(), "dmd")


@pytest.mark.parametrize(
    ("bad", "error", "words"),
    [
        (sequence(unique=3), PatternMemoryFull, r"dmd: saw 3 unique patterns; expected at most 2\."),
        (sequence(pictures=4), PatternMemoryFull, r"dmd: saw 4 pictures in the play order; expected at most 3\."),
        (sequence(columns=1920), PlanError, r"patterns for 1920 x 768 mirrors; expected 1024 x 768\."),
    ],
)
def test_a_sequence_that_does_not_fit_is_refused(bad: PatternSequence, error: type[PlanError], words: str) -> None:
    with pytest.raises(error, match=words):
        LIMITS.check_sequence(bad, "dmd")


@pytest.mark.parametrize("picture_time_us", [44, 10_000_000])
def test_the_limits_themselves_can_be_played(picture_time_us: int) -> None:
    LIMITS.check_timing(ModulatorTiming(picture_time_us=picture_time_us, sync_width_us=43), "dmd")


@pytest.mark.parametrize(
    ("timing", "error", "words"),
    [
        (ModulatorTiming(picture_time_us=43), PictureTimeTooShort, "43 us; expected at least 44 us.*to 22727 or less"),
        (ModulatorTiming(picture_time_us=10_000_001), PlanError, r"at most 10000000 us.*to 0\.1 or more"),
        (
            ModulatorTiming(picture_time_us=50, sync_width_us=50),
            PlanError,
            "a sync width of 50 us in a picture time of 50 us; expected at most 49 us",
        ),
    ],
)
def test_times_that_it_does_not_have_are_refused(timing: ModulatorTiming, error: type[PlanError], words: str) -> None:
    with pytest.raises(error, match=words):
        LIMITS.check_timing(timing, "dmd")
