"""When each pattern of a frame is shown, and what fringes and pairs a scheme is made of."""

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.schemes import Column, FourierHadamardSettings, in_play_order, pair_light, scheme_of
from tests.support.plans import plan_of


def test_patterns_of_a_frame_follow_each_other_without_a_gap() -> None:
    columns = in_play_order(*(Column(role="hadamard") for _ in range(4)))
    assert [(column.start, column.end) for column in columns] == [(0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, 1)]
    assert [column.after_middle_frames for column in columns] == [-0.375, -0.125, 0.125, 0.375]


def test_a_pattern_that_lasts_the_whole_frame_is_in_its_middle() -> None:
    assert Column(role="moment", axis="x").after_middle_frames == 0.0


def test_only_a_pair_adds_to_the_total_light() -> None:
    columns = (Column(role="hadamard", sign=-1), Column(role="moment", axis="y"), Column(role="hadamard"))
    assert pair_light(columns).tolist() == [1.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("scheme", "columns"),
    [
        (
            "fourier-hadamard",
            ["fourier x 0", "fourier x 90", "fourier y 0", "fourier y 90", "hadamard +", "hadamard -"],
        ),
        ("fourier-3step", [f"fourier {axis} {phase}" for axis in "xy" for phase in (0, 120, 240)]),
        ("moment-hadamard", ["moment x 0", "moment y 0", "hadamard +", "hadamard -"]),
        ("hadamard", ["hadamard +", "hadamard -"]),
    ],
)
def test_what_each_scheme_shows_in_one_frame(scheme: str, columns: list[str]) -> None:
    def named(column: Column) -> str:
        if column.role == "hadamard":
            return f"hadamard {'+' if column.sign > 0 else '-'}"
        return f"{column.role} {column.axis} {np.degrees(column.phase_rad):.0f}"

    made = scheme_of(plan_of(scheme, 4, 16))
    assert [named(column) for column in made.columns] == columns
    assert len(made.fixed_patterns) == sum(not name.startswith("hadamard") for name in columns)


def test_frames_beyond_the_last_pattern_begin_again_and_share_its_planes() -> None:
    """64 pairs of an 8 x 8 image, shown by 70 frames: the last six are the first six again; 4 fringes and 128 planes."""
    plan = Plan(frames=70, image_size=8)
    made = scheme_of(plan)
    assert made.image_rows is not None
    np.testing.assert_array_equal(made.image_rows.pairs[64:], made.image_rows.pairs[:6])
    sequence = made.sequence()
    assert len(sequence.planes) == 4 + 128
    order = sequence.play_order[:-1].reshape(70, 6)
    assert order[0].tolist() == [0, 1, 2, 3, 4, 5]
    assert order[63].tolist() == [0, 1, 2, 3, 130, 131]
    assert order[64].tolist() == order[0].tolist()
    assert sequence.play_order[-1] == 5, "the complement of the all-one pattern is the guard"


def test_a_run_without_a_dark_pattern_gets_one_as_guard() -> None:
    sequence = scheme_of(plan_of("fourier-3step", 2, 16)).sequence()
    assert len(sequence.planes) == 7
    assert sequence.play_order.tolist() == [0, 1, 2, 3, 4, 5] * 2 + [6]
    assert not sequence.planes[6].any()


def test_shuffled_patterns_are_the_same_in_another_order() -> None:
    def pairs(seed: int | None) -> list[tuple[int, int]]:
        plan = Plan(frames=40, image_size=16, scheme=FourierHadamardSettings(shuffle_seed=seed))
        rows = scheme_of(plan).image_rows
        assert rows is not None
        return [(down, across) for down, across in rows.pairs.tolist()]

    assert pairs(3) == pairs(3)
    assert pairs(3) != pairs(None)
    assert sorted(pairs(3)) == sorted(pairs(None))


@pytest.mark.parametrize(("cycles", "fits"), [(7, True), (8, False)])
def test_fringes_need_more_than_two_pixels_a_period(cycles: int, *, fits: bool) -> None:
    if fits:
        assert Plan(frames=1, image_size=16, scheme=FourierHadamardSettings(fourier_cycles=cycles)).image_size == 16
    else:
        with pytest.raises(ValueError, match=r"scheme\.fourier_cycles is 8: it must be below image_size / 2"):
            Plan(frames=1, image_size=16, scheme=FourierHadamardSettings(fourier_cycles=cycles))


@pytest.mark.parametrize("scheme", ["fourier-hadamard", "fourier-3step", "moment-hadamard", "hadamard"])
def test_patterns_are_made_for_the_mirrors_of_a_dlp7000_unless_others_are_named(scheme: str) -> None:
    made = scheme_of(plan_of(scheme, 4, 16))
    usual, other = made.sequence().grid, made.sequence(columns=1920, rows=1080).grid
    assert (usual.columns, usual.rows) == (1024, 768)
    assert (other.columns, other.rows) == (1920, 1080)
