"""A bench in a real RunEngine: documents, files through them, pauses and aborts at known moments, and other devices beside it."""

import asyncio
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
    assert [stop["num_events"] for stop in named(documents, "stop")] == [{"primary": 30}] * 5
    configured = [d["configuration"]["kinopix"]["data"]["kinopix-velocity"] for d in named(documents, "descriptor")]
    assert configured == speeds
    resources = {resource["uid"]: resource for resource in named(documents, "stream_resource")}
    assert len(resources) == 10
    for datum in named(documents, "stream_datum"):
        resource = resources[datum["stream_resource"]]
        assert datum["indices"] == {"start": 0, "stop": 30}
        assert resource["parameters"]["chunk_shape"] == ([30, 6] if resource["data_key"] == "kinopix-values" else [30])
        assert datum["seq_nums"] == {"start": 1, "stop": 31}
        recording = recording_of(resource)  # type: ignore[arg-type]
        start = next(start for start in starts if start["uid"] == resource["run_start"])
        assert recording.plan == Plan.model_validate(start["kinopix_plan"])
        assert recording.path is not None
        rows = array(recording.path, resource["parameters"]["dataset"])[:30]
        (key,) = {d["data_keys"][resource["data_key"]]["dtype_numpy"] for d in named(documents, "descriptor")}
        assert rows.dtype == np.dtype(key)
        expected = recording.values if resource["data_key"] == "kinopix-values" else recording.frame_valid
        np.testing.assert_array_equal(rows, expected)
    assert sorted(path.name for path in (tmp_path / "runs").iterdir()) == [f"kinopix-000{k}.h5" for k in range(1, 6)]


def test_real_drivers_on_emulators_fly_too(engine: Any, documents: Documents, tmp_path: Path) -> None:
    with Instrument.from_toml(BENCHES / "alp-ni-mc600.toml") as bench:
        engine(record(KinopixDetector(bench, lambda: tmp_path / "a run.h5", name="spi"), plan_at(10.0)))
        (stop,) = named(documents, "stop")
        assert (stop["exit_status"], stop["num_events"]) == ("success", {"primary": 30})
        values, _ = named(documents, "stream_resource")
        assert values["data_key"] == "spi-values"
        recording = recording_of(values)  # type: ignore[arg-type]
        assert recording.timing is not None
        assert recording.timing.verdict == "good"
        assert_safe(bench)


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
    assert stop["num_events"] == {"primary": len(recording)}
    assert recording.timing is not None
    assert recording.timing.verdict == "partial"


def test_after_a_pause_the_run_is_repeated_whole_in_a_new_file(
    engine: Any, documents: Documents, real_time_bench: Instrument, tmp_path: Path
) -> None:
    detector = KinopixDetector(real_time_bench, tmp_path / "runs")
    with interrupted_after_a_block(engine, detector, engine.request_pause), pytest.raises(RunEngineInterrupted):
        engine(record(detector, LONG))
    assert_safe(real_time_bench)
    assert documents[-1][0] == "descriptor"

    engine.resume()

    assert [stop["exit_status"] for stop in named(documents, "stop")] == ["success"]
    recording = recording_of(named(documents, "stream_resource")[0])  # type: ignore[arg-type]
    assert recording.path == tmp_path / "runs" / "kinopix-0002.h5"
    assert len(recording) == 1500
    assert len(open_recording(tmp_path / "runs" / "kinopix-0001.h5")) < 1500


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
    assert (detector.get_index(), list(detector.collect_asset_docs())) == (0, [])
    detector.prepare(plan_at(10.0).model_dump(mode="json")).wait()  # as a queue server sends it
    detector.kickoff().wait()
    detector.complete().wait()
    assert detector.get_index() == 30
    assert [kind for kind, _ in detector.collect_asset_docs()] == ["stream_resource", "stream_datum"] * 2
    assert list(detector.collect_asset_docs()) == []  # told once


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
