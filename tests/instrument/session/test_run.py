"""The handle of a run: started, watched, waited for, aborted, on simulated devices."""

import os
import signal
from pathlib import Path
from threading import Event as Flag
from threading import Thread, get_ident

import numpy as np
import pytest

from instrument.acquisition import CheckReport
from instrument.schemes.fourier_hadamard import FourierHadamard
from instrument.session import (
    BlockEvent,
    Event,
    FindingEvent,
    FinishedEvent,
    Instrument,
    PhaseEvent,
    RunAborted,
    RunNotOver,
    Snapshot,
    UploadEvent,
)
from instrument.storage import RecordingWriter, StorageFailed, open_recording, recover
from instrument.storage.spill import read_spill
from protocols import CountBlock, InputError, PatternSequence, TravelExceeded, TriggerMissed, WrongState
from tests.support import plain_hdf5 as plain
from tests.support.benches import SMALL, bench_toml

LONG = SMALL.model_copy(update={"frames": 1000})
"""6,000 patterns: six blocks of 50 ms."""


class Held:
    """A counter that is held at its second read until it is let go, and tells when it is there."""

    def __init__(self, bench: Instrument, patch: pytest.MonkeyPatch) -> None:
        self.there, self.go = Flag(), Flag()
        read = bench.counter.read
        reads = iter(range(10**6))

        def reading(timeout_s: float) -> CountBlock:
            if next(reads) == 1:
                self.there.set()
                assert self.go.wait(20)
            return read(timeout_s)

        patch.setattr(bench.counter, "read", reading)


def test_a_run_goes_on_by_itself_and_a_snapshot_says_where_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first block of 20 kHz and 50 ms is 1,000 patterns; the plan has 2 x 1,000 + 4 unique planes and the dark guard."""
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        held = Held(bench, monkeypatch)
        run = bench.start(LONG, tmp_path / "run.h5")
        assert held.there.wait(10)
        now = run.snapshot
        assert (now.state, now.phase, run.state) == ("running", "counting", "running")
        assert (now.patterns_done, now.patterns_total) == (1000, 6000)
        assert now.upload_done == now.upload_total > 2000
        assert Snapshot.model_validate_json(now.model_dump_json()) == now
        early = run.recording
        with pytest.raises(RunNotOver, match=r"running after 0\.01 s, 1000 of 6000 patterns counted") as caught:
            run.wait(0.01)
        assert isinstance(caught.value, TimeoutError)
        held.go.set()
        recording = run.wait(20)
        assert (run.state, run.done, run.snapshot.patterns_done) == ("done", True, 6000)
        assert early is None
        assert run.recording is recording
        assert len(recording) == 1000


def test_the_events_of_a_run_tell_its_story_and_end_with_finished(tmp_path: Path) -> None:
    heard: list[Event] = []
    with Instrument.from_toml(bench_toml(tmp_path, 'faults = [{ kind = "drop-edge", picture = 100 }]')) as bench:
        bench.run(SMALL, tmp_path / "run.h5", listeners=[heard.append])
    assert [event.phase for event in heard if isinstance(event, PhaseEvent)] == [
        *("uploading", "positioning", "arming", "running up", "counting", "coming to rest", "storing"),
    ]
    uploads = [event for event in heard if isinstance(event, UploadEvent)]
    assert (uploads[-1].stored, uploads[-1].total) == (84, 84)
    assert sum(event.patterns for event in heard if isinstance(event, BlockEvent)) == 240
    assert [event.message for event in heard if isinstance(event, FindingEvent)] == [
        "pattern 100: its sync edge is missing"
    ]
    assert heard[-1] == FinishedEvent(
        outcome="done",
        path=str(tmp_path / "run.h5"),
        verdict="flagged",
        notes=(f"240 of 240 patterns are kept in {tmp_path / 'run.h5'}",),
    )


def test_whoever_iterates_gets_every_event_until_the_end_and_whoever_is_late_the_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        held = Held(bench, monkeypatch)
        run = bench.start(LONG, tmp_path / "run.h5")
        assert held.there.wait(10)
        feed = run.events()
        held.go.set()
        assert sum(event.patterns for event in feed if isinstance(event, BlockEvent)) == 5000
        run.wait(20)
        assert [event.kind for event in run.events()] == ["finished"]


def test_start_raises_what_the_checks_find_and_nothing_has_moved(tmp_path: Path) -> None:
    far = SMALL.model_copy(update={"motion": SMALL.motion and SMALL.motion.model_copy(update={"start_mm": 399.0})})
    (tmp_path / "mine.h5").write_text("mine")
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        with pytest.raises(TravelExceeded):
            bench.start(far, tmp_path / "run.h5")
        with pytest.raises(InputError, match="exists"):
            bench.start(SMALL, tmp_path / "mine.h5")
        assert bench.stage.position().reported_mm == 0
        assert bench.devices.clock.now_s() == 0


def test_one_run_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        held = Held(bench, monkeypatch)
        run = bench.start(LONG, tmp_path / "run.h5")
        assert held.there.wait(10)
        with pytest.raises(WrongState, match="a second run while one is running"):
            bench.start(SMALL, tmp_path / "second.h5")
        held.go.set()
        run.wait(20)
        assert len(bench.run(SMALL, tmp_path / "second.h5")) == 40


def test_an_abort_keeps_a_partial_recording_that_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "run.h5"
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        held = Held(bench, monkeypatch)
        run = bench.start(LONG, out)
        assert held.there.wait(10)
        for _ in range(3):
            run.abort("the lamp smokes")
        assert not bench.modulator.running  # before the run itself has noticed
        held.go.set()
        with pytest.raises(RunAborted, match="the lamp smokes") as caught:
            run.wait(20)
        run.abort("too late")
    assert any("of 6000 patterns are kept in" in note for note in caught.value.__notes__)
    assert run.state == "aborted"
    assert run.recording is not None
    assert 1000 <= run.recording.values.size < 6000
    finished = run.snapshot.finished
    assert finished is not None
    assert (finished.outcome, finished.verdict, finished.path) == ("aborted", "partial", str(out))


def test_leaving_the_bench_aborts_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        held = Held(bench, monkeypatch)
        run = bench.start(LONG, tmp_path / "run.h5")
        assert held.there.wait(10)
        held.go.set()
    assert run.done
    assert run.state in ("aborted", "done")
    assert len(open_recording(tmp_path / "run.h5")) > 0


def test_a_second_interrupt_does_not_keep_the_bench_from_becoming_safe(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It comes while the stage is being stopped for the first one."""
    interrupts: list[int] = []
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        held = Held(bench, monkeypatch)
        halt = bench.modulator.halt

        def interrupted_halt() -> None:
            if not interrupts:
                interrupts.append(get_ident())
                os.kill(os.getpid(), signal.SIGINT)
            halt()
            held.go.set()

        monkeypatch.setattr(bench.modulator, "halt", interrupted_halt)

        def press() -> None:
            assert held.there.wait(10)
            os.kill(os.getpid(), signal.SIGINT)

        pressing = Thread(target=press)
        pressing.start()
        with pytest.raises(KeyboardInterrupt) as caught:
            bench.run(LONG, tmp_path / "run.h5")
        pressing.join()
        assert len(interrupts) == 1
        assert not bench.modulator.running
        assert bench.counter.disarm().bins_closed == 0  # it was disarmed already
    assert any("patterns are kept in" in note for note in caught.value.__notes__)


def test_devices_are_safe_before_the_file_is_closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[tuple[bool, bool]] = []
    toml = bench_toml(tmp_path, 'faults = [{ kind = "stall", picture = 100 }]')
    with Instrument.from_toml(toml) as bench:
        finish, move_to = RecordingWriter.finish, bench.stage.move_to
        moves = [bench.stage.move_to(1.0, SMALL.motion.profile)] if SMALL.motion else []
        moves[0].wait()

        def moving(target_mm: float, profile: object) -> object:
            moves.append(move_to(target_mm, profile))  # type: ignore[arg-type]
            return moves[-1]

        def finishing(writer: RecordingWriter, **what: object) -> None:
            seen.append((bench.modulator.running, moves[-1].done))
            finish(writer, **what)  # type: ignore[arg-type]

        monkeypatch.setattr(bench.stage, "move_to", moving)
        monkeypatch.setattr(RecordingWriter, "finish", finishing)
        with pytest.raises(TriggerMissed):
            bench.run(SMALL, tmp_path / "run.h5")
    assert seen == [(False, True)]


def test_an_error_of_any_kind_tells_how_much_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A disk that is full at the third block: what it did not take is spilled, and joined again."""
    append, calls, path = RecordingWriter.append, iter(range(10)), tmp_path / "run.h5"

    def appending(writer: RecordingWriter, *what: object) -> None:
        if next(calls) == 2:
            raise OSError(28, "No space left on device")
        append(writer, *what)  # type: ignore[arg-type]

    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        undisturbed = bench.run(LONG, tmp_path / "undisturbed.h5")
        monkeypatch.setattr(RecordingWriter, "append", appending)
        with pytest.raises(
            StorageFailed, match=r"run.h5, which could not be written: \[Errno 28\] No space left"
        ) as caught:
            bench.run(LONG, path)
    assert caught.value.exit_code == 3
    journal, spill = sorted(tmp_path.glob("run.h5.*.spill"), key=lambda file: not read_spill(file).empty_recording)
    (note,) = caught.value.__notes__
    assert "of 6000 patterns were counted; those before " in note
    assert note.endswith(f"the others are in {spill}; join them with `kinopix recover {path}`")
    recovered = recover(path)
    assert recovered is not None
    values = open_recording(path).values.ravel()[: recovered.patterns]
    assert note.startswith(f"{recovered.patterns} of 6000")
    assert recovered.patterns >= 3000
    assert not spill.exists()
    assert not journal.exists()
    np.testing.assert_array_equal(values, undisturbed.values.ravel()[: recovered.patterns])
    assert "No space left" in plain.text(path, "entry/interrupted")


def test_a_listener_that_raises_changes_nothing_and_is_told(tmp_path: Path) -> None:
    def broken(event: Event) -> None:
        if isinstance(event, BlockEvent):
            raise ZeroDivisionError("no page left")

    heard: list[Event] = []
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        run = bench.start(LONG, tmp_path / "run.h5", listeners=[broken, heard.append])
        assert len(run.wait(20)) == 1000
        assert run.wait_for_listeners(10)
    (failure,) = run.snapshot.listener_failures
    assert failure.error == "no page left"
    assert "broken" in failure.listener
    assert sum(event.patterns for event in heard if isinstance(event, BlockEvent)) == 6000


def test_a_listener_that_never_comes_back_delays_nothing(tmp_path: Path) -> None:
    stuck, let_go = Flag(), Flag()

    def hanging(_event: Event) -> None:
        stuck.set()
        let_go.wait(30)

    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        run = bench.start(LONG, tmp_path / "run.h5")
        listening = run.subscribe(hanging, max_patterns=1000)
        assert len(run.wait(20)) == 1000
        assert run.state == "done"
        assert not run.wait_for_listeners(0.01)
    let_go.set()
    assert listening.join(10)


def test_the_patterns_are_built_once_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    built: list[PatternSequence] = []
    sequence = FourierHadamard.sequence

    def counted(scheme: FourierHadamard, columns: int, rows: int) -> PatternSequence:
        built.append(sequence(scheme, columns, rows))
        return built[-1]

    monkeypatch.setattr(FourierHadamard, "sequence", counted)
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        bench.run(SMALL, tmp_path / "run.h5")
    assert len(built) == 1


def test_a_plan_that_fails_gives_no_patterns(tmp_path: Path) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        report: CheckReport = bench.check(SMALL.model_copy(update={"superpixel": 64}))
    assert report.sequence is None
    with pytest.raises(InputError):
        report.passed()
