"""What the page shows is what the run tells."""

import struct
from pathlib import Path

import numpy as np
import pytest

from instrument.acquisition import AlignedBlock
from instrument.live import LiveAnalysis
from instrument.session import BlockEvent, ImageEvent, Instrument, TrackingEvent
from instrument.web import Board, PageState
from protocols import Floats
from tests.support.benches import SMALL, bench_toml
from tests.support.calibrations import calibrated_bench_toml, displacement
from tests.support.held import HeldCounter

_NONE = np.zeros(0, np.int64)


def block(values: list[float], valid: list[bool] | None = None) -> BlockEvent:
    ok = np.ones(len(values), np.bool_) if valid is None else np.array(valid)
    return BlockEvent.of(AlignedBlock(0, np.array(values), ok, None, _NONE, _NONE, _NONE))


def tracked(frame: int, places_px: Floats) -> TrackingEvent:
    return TrackingEvent(frame=frame, displacement_px=places_px, images=2, images_skipped=1, frames_dropped=3)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("board")
    section = displacement(10.0, 90.0, image_size=32, superpixel=4)
    return calibrated_bench_toml(folder, section, 'object = "letter-B"')


@pytest.fixture
def board(bench: Path) -> Board:
    """A board of a calibrated bench, 10 px/mm down, and the plan of 240 patterns at 20 kHz."""
    board = Board("a bench", now_s=lambda: 1000.0)
    with Instrument.from_toml(bench) as instrument:
        board.show_bench(instrument)
        board.show_plan(SMALL, instrument.check(SMALL))
    return board


def test_bench_and_plan_are_shown_before_any_run(board: Board) -> None:
    state = board.state
    assert [(line.role, line.identity.model) for line in state.devices] == [
        ("modulator", "simulated DLP7000"),
        ("counter", "simulated H10682 and counter"),
        ("stage", "simulated KA400Z"),
    ]
    assert state.plan is not None
    assert state.plan.frames == 40
    assert state.plan.frame_time_s == pytest.approx(3e-4)
    assert {check.outcome for check in state.checks} <= {"good", "warning"}
    assert (state.run, state.light, state.px_per_mm, state.time_s) == (None, None, 10.0, 1000.0)
    assert PageState.model_validate_json(state.model_dump_json()) == state


def test_counts_are_held_against_what_the_counter_counts_linearly(board: Board) -> None:
    """250 counts in 50 us are 5 M/s, the limit; the brightest stays when darker blocks come, and masked ones are left out."""
    board(block([0, 100, 250, 9999], [True, True, True, False]))
    board(block([10, 20]))
    light = board.state.light
    assert light is not None
    assert light.limit_hz == 5e6
    assert light.run_brightest_hz == pytest.approx(5e6)
    assert light.brightest_hz == pytest.approx(4e5)
    assert light.mean_hz == pytest.approx(3e5)


@pytest.mark.parametrize("values", [[0.5, 1.0], [-1.0, 2.0], []])
def test_a_detector_that_does_not_count_is_held_against_no_limit(board: Board, values: list[float]) -> None:
    board(block(values))
    assert board.state.light is None


def test_without_a_plan_or_a_counter_counts_have_no_rate(bench: Path) -> None:
    empty, counterless = Board("a folder"), Board("no counter")
    with Instrument.from_toml(bench) as instrument:
        counterless.show_plan(SMALL, instrument.check(SMALL))
        planless = Board("no plan")
        planless.show_bench(instrument)
    for board in (empty, counterless, planless):
        board(block([1, 2]))
        board(BlockEvent(first_pattern=0, patterns=2))  # from another process, without its counts
        assert board.state.light is None


def test_the_path_is_in_seconds_and_px_and_along_the_stage_in_mm(board: Board) -> None:
    event = tracked(2, np.array([[0.0, 0.0], [3.0, 5.0]]))
    board(event.model_copy(update={"sigma_px": np.array([[np.nan, np.nan], [0.25, 0.5]])}))
    assert board.path.points[:, :3].tolist() == [[pytest.approx(1.5e-4), 0, 0], [pytest.approx(4.5e-4), 3, 5]]
    np.testing.assert_array_equal(board.path.points[:, 3:], [[np.nan, np.nan], [0.25, 0.5]])
    live = board.state.live
    assert (live.x_px, live.y_px, live.sigma_x_px, live.sigma_y_px) == (3.0, 5.0, 0.25, 0.5)
    board(tracked(3, np.array([[4.0, 6.0]])))
    assert (board.state.live.x_px, board.state.live.sigma_x_px) == (4.0, None), "nobody states any"
    board(event)
    live = board.state.live
    assert live.along_mm == pytest.approx(0.5)
    assert (live.frames, live.images, live.images_skipped, live.frames_dropped) == (2, 2, 1, 3)


def test_a_frame_that_was_not_followed_has_no_place(board: Board) -> None:
    board(tracked(1, np.array([[np.nan, np.nan]])))
    assert (board.state.live.x_px, board.state.live.along_mm) == (None, None)


def test_a_long_path_is_thinned_out_and_begins_anew(board: Board) -> None:
    places = np.stack([np.arange(5000.0), np.zeros(5000)], axis=1)
    before = board.path.generation
    board(tracked(5000, places))
    path = board.path
    assert path.generation > before
    assert path.points[:, 1].tolist() == list(range(0, 5000, 4))
    assert path.points[1, 0] == pytest.approx(4.5 * 3e-4)


def test_the_newest_image_is_kept_and_says_when_its_counts_came(board: Board) -> None:
    before = board.image
    board(ImageEvent(frame=0, image=np.eye(2)))
    assert board.image is not None
    assert board.image.made_s == 0.0, "no count has come"
    board(block([1, 2]))
    for frames in (1, 2):
        board(ImageEvent(frame=frames, image=np.eye(2)))
    image = board.image
    assert before is None
    assert image is not None
    assert (image.sequence, image.made_s) == (3, 1000.0)
    assert struct.unpack_from("<HHI", image.body) == (2, 2, 2)


def test_before_the_next_run_image_path_and_counts_are_taken_away(board: Board) -> None:
    board(block([1, 2]))
    board(tracked(1, np.array([[1.0, 1.0]])))
    board(ImageEvent(frame=1, image=np.eye(2)))
    generation = board.path.generation
    board.prepare()
    assert (board.image, board.state.light, board.state.live.frames) == (None, None, 0)
    assert (len(board.path.points), board.path.generation) == (0, generation + 1)


def test_only_a_page_that_may_steer_is_offered_anything() -> None:
    for control in (False, True):
        board = Board("a bench", control=control)
        board.say("at rest", offers=("check", "home"), notice="well")
        state = board.state
        assert state.offers == (("check", "home") if control else ())
        assert (state.doing, state.notice, state.control) == ("at rest", "well", control)


def test_each_change_wakes_who_listens(board: Board) -> None:
    woken = list[int]()
    board.listen(lambda: woken.append(board.version))
    board.say("resting")
    board(block([1, 2]))
    board.listen(None)
    board.say("alone")
    assert woken == [board.version - 2, board.version - 1]


def test_who_comes_in_mid_run_is_shown_all_of_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first block of 50 ms at 20 kHz is 1,000 patterns: 166 frames."""
    plan = SMALL.model_copy(update={"frames": 400})
    board = Board("a bench")
    with Instrument.from_toml(bench_toml(tmp_path, 'object = "letter-B"')) as instrument:
        board.show_plan(plan, instrument.check(plan))
        held = HeldCounter(instrument, monkeypatch)
        followed = LiveAnalysis(plan)
        with instrument.start(plan, tmp_path / "run.h5", listeners=[followed, board]) as run:
            board.show_run(run)
            assert held.there.wait(20)
            snapshot = board.state.run
            assert snapshot is not None
            assert (snapshot.phase, snapshot.patterns_done, snapshot.patterns_total) == ("counting", 1000, 2400)
            over_in_the_midst = board.over
            held.go.set()
            run.wait()
            run.wait_for_listeners(20)
    state = board.state
    assert (over_in_the_midst, board.over) == (False, True)
    assert state.run is not None
    assert state.run.finished is not None
    assert (state.run.state, state.live.frames, len(board.path.points), state.runs) == ("done", 400, 400, 1)
    assert board.image is not None
