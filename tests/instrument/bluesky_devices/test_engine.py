"""A bench in a real RunEngine: documents, files through them, pauses and aborts at known moments, and other devices beside it."""

import asyncio
import subprocess
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest

pytest.importorskip("bluesky", reason="bluesky is not installed: no RunEngine")

from bluesky import plan_stubs, plans, preprocessors, simulators
from bluesky import protocols as of_bluesky
from bluesky.utils import FailedStatus, RunEngineInterrupted

from instrument import Instrument, MotionPlan, Plan, open_recording
from instrument.bluesky_devices import KinopixDetector, KinopixStage, record, recording_of
from instrument.session import BlockEvent, Run
from protocols import PlanError, TravelExceeded, WrongState
from tests.instrument.bluesky_devices.conftest import Documents
from tests.support.plain_hdf5 import array

bps: Any = plan_stubs  # typed in parts: the types end here
bp: Any = plans
bpp: Any = preprocessors
of_plans: Any = simulators

BENCHES = Path(__file__).parents[3] / "examples" / "benches"
LONG = Plan(frames=1500, image_size=32, superpixel=4, motion=MotionPlan(velocity_mm_s=5.0))
"""9,000 patterns: 0.45 s in real time."""


def plan_at(velocity_mm_s: float, frames: int = 30) -> Plan:
    return Plan(frames=frames, image_size=32, superpixel=4, motion=MotionPlan(velocity_mm_s=velocity_mm_s))


def named(documents: Documents, name: str) -> list[dict[str, Any]]:
    return [document for kind, document in documents if kind == name]


def assert_safe(bench: Instrument) -> None:
    """The stage stands, nothing is shown, nothing is counted."""
    before = bench.stage.position().reported_mm
    bench.devices.clock.sleep_s(0.01)
    assert bench.stage.position().reported_mm == before
    assert not bench.modulator.running
    with pytest.raises(WrongState):
        bench.counter.read(0.01)


def test_devices_are_what_bluesky_asks_for(bench: Instrument, tmp_path: Path) -> None:
    stage, detector = KinopixStage(bench), KinopixDetector(bench, tmp_path)
    for kind in ("Movable", "Locatable", "Readable", "Stoppable", "Checkable", "HasHints"):
        assert isinstance(stage, getattr(of_bluesky, kind)), kind
    for kind in ("Flyable", "Preparable", "WritesStreamAssets", "Collectable", "Stageable", "Pausable", "Stoppable"):
        assert isinstance(detector, getattr(of_bluesky, kind)), kind


def test_a_scan_over_five_speeds_is_told_in_valid_documents_that_lead_to_the_files(
    engine: Any, documents: Documents, bench: Instrument, tmp_path: Path
) -> None:
    detector = KinopixDetector(bench, tmp_path / "runs")
    speeds = [5.0, 10.0, 15.0, 20.0, 25.0]

    def scan() -> Any:
        for speed in speeds:
            yield from record(detector, plan_at(speed), md={"sample": "B"})

    uids = engine(scan())

    starts = named(documents, "start")
    assert [start["uid"] for start in starts] == list(uids)
    assert [start["kinopix_plan"]["motion"]["velocity_mm_s"] for start in starts] == speeds
    assert [stop["num_events"] for stop in named(documents, "stop")] == [{"primary": 30, "audit": 30}] * 5
    primary = [document for document in named(documents, "descriptor") if document["name"] == "primary"]
    configured = [document["configuration"]["kinopix"]["data"]["kinopix-velocity"] for document in primary]
    assert configured == speeds
    resources = {resource["uid"]: resource for resource in named(documents, "stream_resource")}
    assert len(resources) == 10
    for datum in named(documents, "stream_datum"):
        resource = resources[datum["stream_resource"]]
        assert datum["indices"] == {"start": 0, "stop": 30}
        assert resource["parameters"]["chunk_shape"] == (
            [1024, 6] if resource["data_key"] == "kinopix-values" else [1024]
        )
        assert datum["seq_nums"] == {"start": 1, "stop": 31}
        recording = recording_of(resource)  # type: ignore[arg-type]
        start = next(start for start in starts if start["uid"] == resource["run_start"])
        assert recording.plan == Plan.model_validate(start["kinopix_plan"])
        assert recording.path is not None
        rows = array(recording.path, resource["parameters"]["dataset"])[:30]
        keys = {name: key for d in named(documents, "descriptor") for name, key in d["data_keys"].items()}
        key = keys[resource["data_key"]]["dtype_numpy"]
        assert rows.dtype == np.dtype(key)
        expected = recording.values if resource["data_key"] == "kinopix-values" else recording.frame_valid
        np.testing.assert_array_equal(rows, expected)
    assert sorted(path.name for path in (tmp_path / "runs").iterdir()) == [f"kinopix-000{k}.h5" for k in range(1, 6)]


def test_real_drivers_on_emulators_fly_too(engine: Any, documents: Documents, tmp_path: Path) -> None:
    with Instrument.from_toml(BENCHES / "alp-ni-mc600.toml") as bench:
        engine(record(KinopixDetector(bench, lambda: tmp_path / "a run.h5", name="spi"), plan_at(10.0)))
        (stop,) = named(documents, "stop")
        assert (stop["exit_status"], stop["num_events"]) == ("success", {"primary": 30, "audit": 30})
        values, _ = named(documents, "stream_resource")
        assert values["data_key"] == "spi-values"
        recording = recording_of(values)  # type: ignore[arg-type]
        assert recording.timing is not None
        assert recording.timing.verdict == "good"
        assert_safe(bench)


READER = """
import sys, h5py
print("ready", flush=True)
for line in sys.stdin:
    path, frames = line.rsplit(" ", 1)
    with h5py.File(path, "r", swmr=True) as file:
        rows = file["/entry/data/values"][: int(frames)]
    print(len(rows), (rows == rows).all(), flush=True)
"""
"""A program of somebody else: is each frame that was told of in the file, without a gap?"""


def test_frames_are_told_of_while_the_run_goes_on_and_others_find_them_in_the_file(
    engine: Any, documents: Documents, real_time_bench: Instrument, tmp_path: Path
) -> None:
    """0.45 s of patterns, told of every 0.05 s."""
    detector = KinopixDetector(real_time_bench, tmp_path)
    found: list[tuple[str, int]] = []
    with subprocess.Popen(
        [sys.executable, "-c", READER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
    ) as reader:
        assert reader.stdin is not None
        assert reader.stdout is not None
        assert reader.stdout.readline() == "ready\n"

        def look(name: str, document: dict[str, Any]) -> None:
            assert reader.stdin is not None
            assert reader.stdout is not None
            if name == "stream_datum" and detector.run is not None and not detector.run.done:
                reader.stdin.write(f"{tmp_path / 'kinopix-0001.h5'} {document['indices']['stop']}\n")
                found.append((reader.stdout.readline().strip(), document["indices"]["stop"]))

        engine(record(detector, LONG, flush_s=0.05), look)
    assert len(found) >= 2
    assert [answer for answer, _ in found] == [f"{frames} True" for _, frames in found]

    values, valid = named(documents, "stream_resource")
    assert values["parameters"]["swmr"]
    ranges = [d["indices"] for d in named(documents, "stream_datum") if d["stream_resource"] == values["uid"]]
    assert ranges[0]["start"] == 0
    assert [one["stop"] for one in ranges[:-1]] == [one["start"] for one in ranges[1:]]
    assert ranges[-1]["stop"] == 1500
    numbers = [d["seq_nums"] for d in named(documents, "stream_datum") if d["stream_resource"] == values["uid"]]
    assert [number["stop"] - 1 for number in numbers] == [one["stop"] for one in ranges]
    (audit,) = [d["indices"] for d in named(documents, "stream_datum") if d["stream_resource"] == valid["uid"]]
    assert audit == {"start": 0, "stop": 1500}
    assert len({d["uid"] for d in named(documents, "stream_datum")}) == len(ranges) + 1


@contextmanager
def interrupted_after_a_block(engine: Any, detector: KinopixDetector, what: Callable[[], object]) -> Generator[None]:
    """Call something when the first run that is begun in the block has counted its first block."""
    threads: list[Thread] = []

    def follow(run: Run) -> None:
        for event in run.events():
            if isinstance(event, BlockEvent):
                what()
                return

    def hear(message: Any) -> None:
        if message.command == "complete" and not threads:
            assert detector.run is not None
            threads.append(Thread(target=follow, args=(detector.run,)))
            threads[0].start()

    engine.msg_hook = hear
    try:
        yield
    finally:
        engine.msg_hook = None
        threads[0].join()


@pytest.mark.parametrize("way", ["abort", "stop"])
def test_an_abort_in_the_midst_leaves_the_bench_safe_and_tells_of_a_valid_file(
    engine: Any, documents: Documents, real_time_bench: Instrument, tmp_path: Path, way: str
) -> None:
    detector = KinopixDetector(real_time_bench, tmp_path)
    with interrupted_after_a_block(engine, detector, engine.request_pause), pytest.raises(RunEngineInterrupted):
        engine(record(detector, LONG))
    getattr(engine, way)()

    assert engine.state == "idle"
    assert_safe(real_time_bench)
    (stop,) = named(documents, "stop")
    assert stop["exit_status"] == ("abort" if way == "abort" else "success")
    recording = recording_of(named(documents, "stream_resource")[0])  # type: ignore[arg-type]
    assert 0 < len(recording) < 1500
    assert stop["num_events"] == {"primary": len(recording), "audit": len(recording)}
    assert recording.timing is not None
    assert recording.timing.verdict == "partial"


def test_after_a_pause_the_run_is_repeated_whole_in_a_new_file(
    engine: Any, documents: Documents, real_time_bench: Instrument, tmp_path: Path
) -> None:
    detector = KinopixDetector(real_time_bench, tmp_path / "runs")
    with interrupted_after_a_block(engine, detector, engine.request_pause), pytest.raises(RunEngineInterrupted):
        engine(record(detector, LONG))
    assert_safe(real_time_bench)
    assert documents[-1][0] == "descriptor"  # less than a second: nothing was told

    engine.resume()

    assert [stop["exit_status"] for stop in named(documents, "stop")] == ["success"]
    recording = recording_of(named(documents, "stream_resource")[0])  # type: ignore[arg-type]
    assert recording.path == tmp_path / "runs" / "kinopix-0002.h5"
    assert len(recording) == 1500
    assert len(open_recording(tmp_path / "runs" / "kinopix-0001.h5")) < 1500


def test_frames_that_were_told_of_before_a_pause_are_told_of_anew_with_the_same_numbers(
    engine: Any, documents: Documents, real_time_bench: Instrument, tmp_path: Path
) -> None:
    detector = KinopixDetector(real_time_bench, tmp_path)
    asking = Thread(target=engine.request_pause)  # the engine waits for whoever takes its documents

    def pause(name: str, _document: dict[str, Any]) -> None:
        if name == "stream_datum" and asking.ident is None:
            asking.start()

    with pytest.raises(RunEngineInterrupted):
        engine(record(detector, LONG, flush_s=0.05), pause)
    asking.join()
    assert_safe(real_time_bench)
    assert named(documents, "stream_datum")[0]["indices"]["stop"] < 1500
    engine.resume()

    first, second, _ = named(documents, "stream_resource")
    assert [Path(resource["uri"]).name for resource in (first, second)] == ["kinopix-0001.h5", "kinopix-0002.h5"]
    again = [d["seq_nums"] for d in named(documents, "stream_datum") if d["stream_resource"] == second["uid"]]
    assert (again[0]["start"], again[-1]["stop"]) == (1, 1501)
    (stop,) = named(documents, "stop")
    assert stop["num_events"] == {"primary": 1500, "audit": 1500}


def test_a_run_that_fails_fails_its_plan_and_tells_of_what_is_kept(
    engine: Any, documents: Documents, real_time_bench: Instrument, tmp_path: Path
) -> None:
    """Somebody else aborts it, from any thread."""
    detector = KinopixDetector(real_time_bench, tmp_path)

    def abort() -> None:
        assert detector.run is not None
        detector.run.abort("the sample has moved")

    with interrupted_after_a_block(engine, detector, abort), pytest.raises(FailedStatus) as failed:
        engine(record(detector, LONG))
    assert "the sample has moved" in str(failed.value.__cause__)
    (stop,) = named(documents, "stop")
    assert stop["exit_status"] == "fail"
    assert stop["num_events"]["primary"] > 0
    assert_safe(real_time_bench)


@pytest.mark.parametrize(("options", "well"), [({}, True), ({"success": False}, False)])
def test_a_run_that_is_stopped_says_whether_that_was_well(
    real_time_bench: Instrument, tmp_path: Path, *, options: dict[str, bool], well: bool
) -> None:
    detector = KinopixDetector(real_time_bench, tmp_path)
    detector.prepare(LONG).wait()
    detector.kickoff().wait()
    complete = detector.complete()
    asyncio.run(detector.stop(**options))
    assert_safe(real_time_bench)
    assert (complete.exception(5.0) is None) == well


def test_a_plan_that_the_bench_cannot_carry_out_is_refused_before_anything_moves(
    engine: Any, documents: Documents, bench: Instrument, tmp_path: Path
) -> None:
    detector = KinopixDetector(bench, tmp_path)
    with pytest.raises(FailedStatus) as failed:
        engine(record(detector, plan_at(1e6)))
    assert isinstance(failed.value.__cause__, PlanError)
    assert detector.run is None
    assert named(documents, "stream_resource") == []


def test_the_order_of_the_steps_is_told_to_whoever_breaks_it(bench: Instrument, tmp_path: Path) -> None:
    detector = KinopixDetector(bench, tmp_path)
    for step in (detector.kickoff, detector.complete, detector.describe_collect, detector.read_configuration):
        with pytest.raises(WrongState, match="prepare with a plan, then kickoff, then complete"):
            step()
    for device in (detector, detector.audit):
        assert (device.get_index(), list(device.collect_asset_docs())) == (0, [])
    detector.prepare(plan_at(10.0).model_dump(mode="json")).wait()  # as a queue server sends it
    detector.kickoff().wait()
    detector.complete().wait()
    for device in (detector, detector.audit):
        assert device.get_index() == 30
        told = [kind for kind, _ in device.collect_asset_docs(20)]
        assert told == ["stream_resource", "stream_datum"]
        (rest,) = device.collect_asset_docs()
        assert rest[1]["indices"] == {"start": 20, "stop": 30}  # type: ignore[typeddict-item]
        assert list(device.collect_asset_docs()) == []  # told once


def test_limits_are_checked_without_moving(engine: Any, bench: Instrument) -> None:
    stage = KinopixStage(bench)
    low, high = bench.stage.limits.travel_mm
    before = bench.stage.position().reported_mm
    of_plans.check_limits(bp.scan([], stage, low, high, 5))
    with pytest.raises(TravelExceeded, match="a target of 1e"):
        of_plans.check_limits(bps.mv(stage, 1e6))
    assert bench.stage.position().reported_mm == before
    assert stage.describe()["stage"].get("limits") == {"control": {"low": low, "high": high}}


def test_a_scan_of_the_stage_reads_where_it_is(engine: Any, documents: Documents, bench: Instrument) -> None:
    stage = KinopixStage(bench, name="x")
    engine(bp.scan([stage], stage, 0.0, 2.0, 3))
    assert [event["data"]["x"] for event in named(documents, "event")] == pytest.approx([0.0, 1.0, 2.0], abs=1e-3)
    assert stage.locate() == {"setpoint": 2.0, "readback": pytest.approx(2.0, abs=1e-3)}


def test_a_stage_that_is_stopped_says_whether_that_was_well(engine: Any, real_time_bench: Instrument) -> None:
    stage = KinopixStage(real_time_bench)
    for well in (True, False):
        status = stage.set(stage.locate()["readback"] + 5.0)
        assert not status.done
        with pytest.raises(TimeoutError):
            status.exception(0.0)
        stage.stop(success=well)
        assert (status.exception(5.0) is None) == well
        assert status.success == well
        assert stage.locate()["readback"] < 2.0


def test_devices_of_ophyd_async_stand_beside_it_in_one_plan(
    engine: Any, documents: Documents, bench: Instrument, tmp_path: Path
) -> None:
    sim = pytest.importorskip("ophyd_async.sim", reason="ophyd-async is not installed")
    core = pytest.importorskip("ophyd_async.core")
    with core.init_devices(mock=False):
        motor = sim.SimMotor(name="theta", instant=True)
    detector, stage = KinopixDetector(bench, tmp_path), KinopixStage(bench)

    def both() -> Any:
        for angle in (1.0, 2.0):
            yield from bps.mv(motor, angle, stage, angle / 10)
            yield from bps.create("angles")
            yield from bps.read(motor)
            yield from bps.read(stage)
            yield from bps.save()
        yield from bps.prepare(detector, plan_at(10.0), wait=True)
        yield from bps.declare_stream(detector, name="primary", collect=True)
        yield from bps.kickoff(detector, wait=True)
        yield from bps.complete(detector, wait=True)
        yield from bps.collect(detector, name="primary")

    engine(bpp.run_wrapper(both()))
    assert [event["data"]["theta"] for event in named(documents, "event")] == [1.0, 2.0]
    (stop,) = named(documents, "stop")
    assert stop["num_events"] == {"angles": 2, "primary": 30}
