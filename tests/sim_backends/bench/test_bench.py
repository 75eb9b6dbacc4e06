"""The bench as devices use it: light, motion, noise and faults together, with numbers that can be checked by hand."""

from pathlib import Path

import numpy as np
import pytest

from protocols import BenchContext, Floats, InputError, PixelGrid, Scene, WrongState
from sim_backends.bench import OpticalBench, Projection, SceneSettings, VirtualClock, bench_of
from sim_backends.bench.noise_settings import PhotonNoise
from sim_backends.bench.projection import Edges
from tests.sim_backends.projector import (
    GRID,
    PICTURE_S,
    SIZE,
    all_on,
    bench_with,
    dot,
    pixel,
    save,
    sequence_of,
    show,
    values,
)

RANDOM = np.random.default_rng(11)


def still_bench(folder: Path, at_px: tuple[float, float] = (0.0, 0.0), **scene: object) -> OpticalBench:
    """One bright pixel at row 4, column 5, displaced by ``at_px`` for ever."""
    (folder / "still.csv").write_text(f"t_s,x_px,y_px\n0,{at_px[0]},{at_px[1]}\n")
    return bench_with(folder, object=save(folder, dot(4, 5)), trajectory="still.csv", **scene)


# Light


def test_a_value_is_the_sum_of_transmission_times_pattern(tmp_path: Path) -> None:
    scene = RANDOM.random((SIZE, SIZE))
    bench = bench_with(tmp_path, object=save(tmp_path, scene))
    pattern = RANDOM.integers(0, 2, (SIZE, SIZE), dtype=np.uint8)
    assert values(bench, [pattern, 1 - pattern, all_on()]) == pytest.approx(
        [(scene * pattern).sum(), (scene * (1 - pattern)).sum(), scene.sum()], rel=1e-12
    )


def test_a_bright_pixel_moved_by_a_quarter_is_seen_by_two_pixels(tmp_path: Path) -> None:
    bench = still_bench(tmp_path, (0.25, 0.0))
    assert values(bench, [pixel(4, 5), pixel(4, 6), pixel(4, 4), pixel(5, 5)]) == [0.75, 0.25, 0.0, 0.0]


def test_an_object_outside_the_field_gives_no_light(tmp_path: Path) -> None:
    assert values(still_bench(tmp_path, (50.0, 0.0)), [all_on()]) == [0.0]


def test_y_grows_downwards(tmp_path: Path) -> None:
    assert values(still_bench(tmp_path, (0.0, 3.0)), [pixel(7, 5), pixel(1, 5)]) == [1.0, 0.0]


def test_patterns_finer_than_the_image_see_parts_of_a_pixel(tmp_path: Path) -> None:
    fine = np.zeros((2 * SIZE, 2 * SIZE), np.uint8)
    fine[8, 10] = fine[9, 11] = 1  # two of the four mirrors of pixel (4, 5)
    assert values(still_bench(tmp_path), [fine, all_on(2 * SIZE)]) == [0.5, 1.0]


def test_fine_and_coarse_planes_give_the_same_light(tmp_path: Path) -> None:
    bench = bench_with(tmp_path, object=save(tmp_path, RANDOM.random((SIZE, SIZE))))
    coarse = RANDOM.integers(0, 2, (SIZE, SIZE), dtype=np.uint8)
    fine = coarse.repeat(2, 0).repeat(2, 1)
    one_mirror_more = fine.copy()
    one_mirror_more[0, 0] ^= 1  # now the plane is not of whole superpixels, and the mirrors themselves are used
    whole, mirrors = values(bench, [fine])[0], values(bench, [one_mirror_more])[0]
    assert whole == pytest.approx(values(bench, [coarse])[0], rel=1e-12)
    first = np.load(tmp_path / "object.npy")[0, 0] / 4
    assert mirrors == pytest.approx(whole + (first if one_mirror_more[0, 0] else -first), rel=1e-12)


def test_a_field_that_starts_inside_a_byte_of_mirrors_is_cut_out_rightly(tmp_path: Path) -> None:
    bench = bench_with(tmp_path, object=save(tmp_path, dot(3, 2, 9)))
    grid = PixelGrid(image_size=9, superpixel=3, columns=50, rows=40)  # 27 mirrors from column 11
    bench.use_grid(grid)
    one = np.zeros((9, 9), np.uint8)
    one[3, 2] = 1
    sequence = sequence_of([one, 1 - one], grid)
    bench.show(Projection(0.0, PICTURE_S, sequence.mirror_plane, sequence.play_order))
    assert bench.counts(0, 2).tolist() == [1.0, 0.0]


def test_a_brighter_lamp_gives_more_light_and_a_drifting_one_ever_more(tmp_path: Path) -> None:
    bench = still_bench(tmp_path, light_level=2.0, led_drift_per_s=1000.0)
    assert values(bench, [all_on(), all_on()]) == pytest.approx([2.0 * 1.025, 2.0 * 1.075])  # at 25 and 75 us


def test_the_background_stands_still_and_is_lit_too(tmp_path: Path) -> None:
    save(tmp_path, dot(1, 1), "still.npy")
    bench = still_bench(tmp_path, (1.0, 0.0), background="still.npy", background_level=0.5)
    assert values(bench, [pixel(4, 6), pixel(1, 1), pixel(1, 2), all_on()]) == [1.0, 0.5, 0.0, 1.5]


def test_an_object_taken_out_of_the_light_leaves_the_background_and_the_scale_of_photons(tmp_path: Path) -> None:
    """The dot at full level would give 1e6 counts: the background, half as bright, gives half of them within 5 sigma."""
    save(tmp_path, dot(1, 1), "still.npy")
    noise = PhotonNoise(kind="poisson", peak_counts=1e6, seed=1)
    bench = still_bench(tmp_path, background="still.npy", background_level=0.5, object_level=0.0, noise=noise)
    assert values(bench, [all_on()]) == pytest.approx([5e5], abs=5 * 5e5**0.5)
    assert not bench.truth(np.zeros(1)).image.any()


def test_a_built_in_can_be_the_background(tmp_path: Path) -> None:
    bench = bench_with(tmp_path, object="square", object_height_px=4, background="letter-I", background_px=(12.5, 4.0))
    right = all_on()
    right[:, :12] = 0
    assert values(bench, [all_on(), right]) == [16.0 + 4.0, 4.0]  # an "I" of 4 px is one column of four pixels


def test_light_is_lost_at_the_edges_between_lit_and_dark_mirrors(tmp_path: Path) -> None:
    """A lit pixel of 2 x 2 mirrors among dark ones: two of the four sides of each mirror border dark mirrors."""
    bench = still_bench(tmp_path, edge_loss=0.1)
    assert values(bench, [pixel(4, 5), all_on()]) == pytest.approx([1 - 2 * 0.1, 1.0])


def test_edge_loss_is_the_same_on_mirrors_as_on_superpixels(tmp_path: Path) -> None:
    bench = still_bench(tmp_path, edge_loss=0.1)
    fine = pixel(4, 5).repeat(2, 0).repeat(2, 1)
    fine[0, 0] = 1
    assert values(bench, [fine])[0] == pytest.approx(0.8)


def test_edge_loss_stays_out_of_the_difference_of_complements_but_not_of_their_sum(tmp_path: Path) -> None:
    """On an even scene: what measured benches show (the pair sum falls with the number of edges)."""
    bench = bench_with(tmp_path, object=save(tmp_path, np.full((SIZE, SIZE), 0.5)), edge_loss=0.05)
    stripes = np.zeros((SIZE, SIZE), np.uint8)
    stripes[:, 1:15:2] = 1
    stripes[0], stripes[-1] = 0, 0
    bright, dark, whole = values(bench, [stripes, 1 - stripes, all_on()])
    assert whole - (bright + dark) > 0
    field_border = 4 * SIZE * 0.5 * 0.05 / 2  # beyond the field all mirrors are dark: the same for "whole" and "dark"
    assert (bright - dark) == pytest.approx(2 * 0.5 * stripes.sum() - 0.5 * SIZE**2 + field_border, rel=1e-9)


def test_in_the_transition_the_light_goes_linearly_from_one_picture_to_the_next(tmp_path: Path) -> None:
    bench = still_bench(tmp_path, mirror_transition_s=4e-6)
    half = 4e-6 / (2 * PICTURE_S)  # the mean over the picture of a ramp of 4 us
    assert values(bench, [all_on(), pixel(0, 0), all_on()]) == pytest.approx([1 - half, half, 1 - half])


# Motion


def test_a_trajectory_moves_the_object_between_the_pictures_of_a_frame(tmp_path: Path) -> None:
    """10,000 px/s: half a pixel a picture, a quarter of a pixel at the middle of the first."""
    (tmp_path / "path.csv").write_text("t_s,x_px,y_px\n0,0,0\n1,10000,0\n")
    bench = bench_with(tmp_path, object=save(tmp_path, dot(4, 5)), trajectory="path.csv")
    assert values(bench, [pixel(4, 5), pixel(4, 5), pixel(4, 6), pixel(4, 6)]) == pytest.approx(
        [0.75, 0.25, 0.75, 0.25]
    )


def test_a_trajectory_is_held_before_its_first_row_and_after_its_last(tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text("t_s,x_px,y_px\n0.0001,1,0\n0.0002,3,0\n")
    bench = bench_with(tmp_path, object=save(tmp_path, dot(4, 5)), trajectory="path.csv")
    show(bench, [pixel(4, 6)] * 4 + [pixel(4, 8)] * 4)
    assert bench.counts(0, 8).tolist() == pytest.approx([1, 1, 0.5, 0, 1, 1, 1, 1])
    shift_px = bench.truth(np.array([0.0, 0.00015, 1.0])).displacement_px
    assert shift_px[:, 0].tolist() == pytest.approx([0, 1, 2])


def test_the_stage_carries_the_object_along_its_axis(tmp_path: Path) -> None:
    bench = bench_with(tmp_path, object=save(tmp_path, dot(4, 5)), px_per_mm=2.0, axis_angle_deg=90.0, object_at_mm=1.0)
    bench.carry(lambda clock_s: np.full_like(clock_s, 2.5))
    assert values(bench, [pixel(7, 5), pixel(4, 5)]) == [1.0, 0.0]


def test_the_first_run_finds_the_object_where_it_was_drawn_and_later_runs_keep_that_place(tmp_path: Path) -> None:
    bench = bench_with(tmp_path, object=save(tmp_path, dot(4, 5)), px_per_mm=2.0, axis_angle_deg=0.0)
    bench.carry(lambda clock_s: np.full_like(clock_s, 100.0))
    assert values(bench, [pixel(4, 5)]) == [1.0]
    bench.carry(lambda clock_s: np.full_like(clock_s, 101.5))
    assert values(bench, [pixel(4, 8)]) == [1.0]


def test_an_angle_of_45_degrees_points_down_the_diagonal() -> None:
    bench = OpticalBench(SceneSettings())
    bench.carry(lambda clock_s: 25.0 * clock_s)
    show(bench, [all_on()] * 2)
    shift = bench.truth(np.array([0.0, 0.5])).displacement_px
    assert shift[1] == pytest.approx([12.5 * 7.2 / np.sqrt(2)] * 2)  # 63.6 px of travel in the standard run


def test_the_scale_follows_the_image_size_so_that_the_field_of_view_keeps_its_size() -> None:
    bench = OpticalBench(SceneSettings())
    bench.use_grid(PixelGrid(image_size=64, superpixel=4))
    bench.carry(lambda clock_s: 25.0 * clock_s)
    sequence = sequence_of([all_on(64)], PixelGrid(image_size=64, superpixel=4))
    bench.show(Projection(0.0, PICTURE_S, sequence.mirror_plane, sequence.play_order))
    assert bench.truth(np.array([0.0, 0.5])).displacement_px[1, 0] == pytest.approx(12.5 * 3.6 / np.sqrt(2))
    assert bench.truth(np.zeros(1)).image.any(axis=1).sum() == 18


def test_in_the_standard_run_the_letter_stays_in_the_field() -> None:
    bench = OpticalBench(SceneSettings())
    bench.carry(lambda clock_s: 25.0 * clock_s)
    show(bench, [all_on()])
    images = [bench.truth(np.array([time_s])).image for time_s in (0.0, 0.25, 0.5)]
    assert [image.sum() for image in images] == pytest.approx([827.0] * 3)
    rows = np.flatnonzero(images[-1].any(axis=1))
    assert rows[0] > 0
    assert rows[-1] < 127


def test_when_the_stage_is_stopped_pictures_already_shown_keep_their_light(tmp_path: Path) -> None:
    bench = bench_with(tmp_path, object=save(tmp_path, dot(4, 5)), px_per_mm=1.0, axis_angle_deg=0.0)
    bench.carry(lambda clock_s: clock_s / (2 * PICTURE_S))  # half a pixel a picture
    show(bench, [pixel(4, 5)] * 6)
    moving = bench.counts(0, 6).tolist()
    assert moving == pytest.approx([0.75, 0.25, 0, 0, 0, 0])
    bench.clock.advance_to(1.2 * PICTURE_S)
    bench.carry(lambda clock_s: np.full_like(clock_s, 0.6))
    assert bench.counts(0, 6).tolist() == pytest.approx([0.75, 0.4, 0.4, 0.4, 0.4, 0.4])


def test_truth_is_relative_to_the_first_time_asked_and_shows_the_object_there(tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text("t_s,x_px,y_px\n0,0,0\n1,8,-2\n")
    bench = bench_with(tmp_path, object=save(tmp_path, dot(4, 5)), trajectory="path.csv")
    show(bench, [all_on()], start_s=50.0)
    truth = bench.truth(np.array([0.25, 0.5, 1.0]))
    assert truth.displacement_px.tolist() == [[0.0, 0.0], [2.0, -0.5], [6.0, -1.5]]
    assert (truth.image[3, 7], truth.image[4, 7]) == (0.5, 0.5)


def test_the_truth_of_the_last_run_does_not_change_with_the_next_grid(tmp_path: Path) -> None:
    bench = bench_with(tmp_path, object=save(tmp_path, dot(4, 5)))
    bench.carry(lambda clock_s: clock_s)
    show(bench, [all_on()])
    before = bench.truth(np.array([0.0, 1.0]))
    bench.use_grid(PixelGrid(image_size=2 * SIZE, superpixel=1))
    after = bench.truth(np.array([0.0, 1.0]))
    assert before.image.tolist() == after.image.tolist()
    assert before.displacement_px.tolist() == after.displacement_px.tolist()


# Edges


def test_there_is_one_edge_a_picture_and_none_before_its_time() -> None:
    bench = bench_with()
    show(bench, [all_on()] * 3, start_s=1.0)
    assert edge_list(bench.edges(0, 1.0 + 1.5 * PICTURE_S)) == ([1.0, 1.0 + PICTURE_S], [0, 1], False)
    assert edge_list(bench.edges(2, 2.0)) == ([1.0 + 2 * PICTURE_S, 1.0 + 3 * PICTURE_S], [2, 3], True)
    assert edge_list(bench.edges(4, 2.0)) == ([], [], True)


def edge_list(edges: Edges) -> tuple[list[float], list[int], bool]:
    return edges.time_s.tolist(), list(range(edges.first, edges.first + len(edges))), edges.finished


def test_before_anything_is_shown_there_are_no_edges_yet() -> None:
    bench = bench_with()
    assert edge_list(bench.edges(0, 1e9)) == ([], [], False)
    assert bench.shown_until_s == 0.0


def test_after_a_halt_there_are_no_edges_and_the_run_is_over() -> None:
    bench = bench_with()
    show(bench, [all_on()] * 5)
    bench.clock.advance_to(2.5 * PICTURE_S)
    bench.dark()
    bench.clock.advance_to(1.0)
    bench.dark()
    assert edge_list(bench.edges(0, 9.0)) == ([0.0, PICTURE_S, 2 * PICTURE_S], [0, 1, 2], True)
    assert bench.shown_until_s == 2.5 * PICTURE_S


def test_a_sync_delay_shifts_the_bins_against_the_pictures(tmp_path: Path) -> None:
    """Edges a fifth of a picture early: a bin holds the end of the picture before."""
    bench = still_bench(tmp_path)
    show(bench, [all_on(), pixel(0, 0), all_on()], sync_delay_s=PICTURE_S / 5)
    assert bench.edges(0, 1.0).time_s[0] == pytest.approx(-PICTURE_S / 5)
    assert bench.counts(0, 3).tolist() == pytest.approx([0.8, 0.2, 0.8])


def test_a_missed_edge_puts_two_pictures_into_one_bin(tmp_path: Path) -> None:
    bench = still_bench(tmp_path, faults=[{"kind": "drop-edge", "picture": 1}])
    show(bench, [all_on(), all_on(), pixel(0, 0), all_on()])
    assert len(bench.edges(0, 1.0)) == 4
    assert bench.counts(0, 3).tolist() == [2.0, 0.0, 1.0]


def test_a_doubled_edge_cuts_a_short_bin_off(tmp_path: Path) -> None:
    bench = still_bench(tmp_path, faults=[{"kind": "double-edge", "picture": 1, "after_s": 5e-6}])
    show(bench, [all_on(), all_on(), pixel(0, 0)])
    assert bench.counts(0, 4).tolist() == pytest.approx([1.0, 0.1, 0.9, 0.0])


def test_surplus_edges_come_after_the_guard_and_close_dark_bins(tmp_path: Path) -> None:
    bench = still_bench(tmp_path, faults=[{"kind": "surplus-edges", "edges": 2}])
    show(bench, [all_on()])
    assert len(bench.edges(0, 1.0)) == 4
    assert bench.counts(0, 3).tolist() == [1.0, 0.0, 0.0]


def test_a_stalled_modulator_is_never_finished(tmp_path: Path) -> None:
    bench = still_bench(tmp_path, faults=[{"kind": "stall", "picture": 1}])
    show(bench, [all_on()] * 5)
    assert edge_list(bench.edges(0, 1e9)) == ([0.0, PICTURE_S], [0, 1], False)
    assert bench.shown_until_s == np.inf
    bench.dark()
    assert bench.edges(0, 1e9).finished


def test_jittered_edges_move_light_from_bin_to_bin_but_lose_none(tmp_path: Path) -> None:
    bench = still_bench(tmp_path, sync_jitter_s=1e-6)
    show(bench, [all_on()], times=2000)
    counts, edge_s = bench.counts(0, 2000), bench.edges(0, 1.0).time_s
    assert counts[1:-1] == pytest.approx(np.diff(edge_s)[1:-1] / PICTURE_S)
    assert np.std(counts[1:-1]) == pytest.approx(np.sqrt(2) * 1e-6 / PICTURE_S, rel=0.05)


# The framework's side


def test_the_bench_is_a_scene() -> None:
    bench = bench_with()
    assert isinstance(bench, Scene)
    assert isinstance(bench.clock, VirtualClock)


def test_real_time_is_a_setting(monkeypatch: pytest.MonkeyPatch) -> None:
    host = [7.0]
    monkeypatch.setattr("time.monotonic", lambda: host[0])
    bench = bench_with(realtime=True)
    host[0] += 2.0
    assert bench.clock.now_s() == 2.0


def test_truth_before_a_run_is_refused() -> None:
    with pytest.raises(WrongState, match="the truth before anything was shown"):
        bench_with().truth(np.zeros(1))


def test_a_driver_without_a_bench_is_told_what_to_add() -> None:
    with pytest.raises(InputError, match=r"no \[scene\] table"):
        bench_of(BenchContext(), "dmd")


def test_a_driver_on_another_scene_is_told_so() -> None:
    class OtherScene:
        clock = VirtualClock()

        def use_grid(self, grid: PixelGrid) -> None: ...

        def truth(self, time_s: Floats) -> object: ...

    with pytest.raises(InputError, match="a scene of type OtherScene"):
        bench_of(BenchContext(scene=OtherScene()), "dmd")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]


def test_the_standard_run_is_worked_out_in_blocks_of_bounded_work() -> None:
    """Asking for the first bins fetches only the planes that they need."""
    fetched: list[int] = []
    sequence = sequence_of([all_on()])

    def mirrors(index: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
        fetched.append(index)
        return sequence.mirror_plane(0)

    bench = bench_with(object="disc")
    bench.use_grid(GRID)
    bench.show(Projection(0.0, PICTURE_S, mirrors, np.arange(10_000)))
    bench.counts(0, 1)
    assert 0 < len(fetched) <= 514
    bench.counts(0, 512)
    assert len(fetched) <= 514
