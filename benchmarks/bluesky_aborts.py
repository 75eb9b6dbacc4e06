"""Aborts of a RunEngine at random moments: is the bench safe, and the file valid? ``python -m benchmarks.bluesky_aborts``.

Each run is one of the simulated bench in real time, of 1.2 s with what comes before and after. The moment is drawn between
the start of the plan and a little after its end. *Safe*: the stage stands, the modulator is dark, the counter is disarmed.
*Valid*: the file that the documents name can be opened, and has as many frames as they say; a run without a count names none.
"""

import argparse
import contextlib
import io
import logging
import tempfile
from collections import Counter
from pathlib import Path
from random import Random
from threading import Timer
from typing import Any

import event_model
from bluesky import RunEngine
from bluesky.utils import RunEngineInterrupted

from instrument import Instrument, MotionPlan, Plan
from instrument.bluesky_devices import KinopixDetector, record, recording_of
from instrument.config import bench_of_tables
from protocols import WrongState

_PLAN = Plan(frames=2400, image_size=32, superpixel=4, motion=MotionPlan(velocity_mm_s=5.0))
_LONGEST_S = 1.6


def opened() -> Instrument:
    """Open a simulated bench in real time."""
    tables: dict[str, Any] = {name: {"driver": "simulated"} for name in ("modulator", "counter", "stage")}
    tables["scene"] = {"realtime": True, "noise": {"kind": "poisson", "peak_counts": 200.0, "seed": 1}}
    return Instrument.from_config(bench_of_tables(tables, "aborts"))


def unsafe(bench: Instrument) -> str:
    """Say what is not at rest; nothing where all is."""
    before = bench.stage.position().reported_mm
    bench.devices.clock.sleep_s(0.01)
    found = [
        *(["the stage moves"] if bench.stage.position().reported_mm != before else []),
        *(["the modulator plays"] if bench.modulator.running else []),
    ]
    try:
        bench.counter.read(0.01)
    except WrongState:
        return ", ".join(found)
    return ", ".join([*found, "the counter is armed"])


def invalid(documents: list[tuple[str, dict[str, Any]]]) -> str:
    """Say what is wrong with documents and file; nothing where all is right."""
    stops = [document for name, document in documents if name == "stop"]
    resources: list[Any] = [document for name, document in documents if name == "stream_resource"]
    if not stops:
        return "" if not documents else "a run without its stop document"
    told = stops[0]["num_events"].get("primary", 0)
    if not resources:
        return "" if told == 0 else "frames without a file"
    recording = recording_of(resources[0])
    return "" if len(recording) == told else f"{told} frames told, {len(recording)} in the file"


def main() -> None:
    """Abort, look, and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0, help="of the moments")
    arguments = parser.parse_args()
    logging.getLogger("bluesky").setLevel(logging.CRITICAL)
    model: Any = event_model  # typed in parts
    engine: Any = RunEngine({}, context_managers=[])
    documents: list[tuple[str, dict[str, Any]]] = []
    draws = Random(arguments.seed)
    moments_s = [draws.uniform(0, _LONGEST_S) for _ in range(arguments.count)]

    def take(name: str, document: dict[str, Any]) -> None:
        model.schema_validators[model.DocumentNames[name]].validate(document)
        documents.append((name, document))

    engine.subscribe(take)
    found: Counter[str] = Counter()
    bad: list[str] = []
    with tempfile.TemporaryDirectory(prefix="kinopix-aborts-") as folder, opened() as bench:
        detector = KinopixDetector(bench, Path(folder))
        for moment_s in moments_s:
            documents.clear()

            def pause() -> None:
                with contextlib.suppress(Exception):  # the plan is over already
                    engine.request_pause()

            timer = Timer(moment_s, pause)
            timer.start()
            what = "over before its moment"
            with contextlib.redirect_stdout(io.StringIO()):  # the engine tells a person at the terminal
                try:
                    engine(record(detector, _PLAN))
                except RunEngineInterrupted:
                    engine.abort()
                    told = any(name == "stream_resource" for name, _ in documents)
                    what = f"aborted {'with frames' if told else 'before the first frame'}"
            found[what] += 1
            timer.cancel()
            timer.join()
            wrong = [text for text in (unsafe(bench), invalid(documents)) if text]
            if wrong:
                bad.append(f"at {moment_s:.3f} s ({what}): {'; '.join(wrong)}")
    print(f"{arguments.count} plans: {', '.join(f'{count} {what}' for what, count in sorted(found.items()))}")
    print(f"{len(bad)} with a bench that is not safe, or a file that is not valid", *bad, sep="\n")


if __name__ == "__main__":
    main()
