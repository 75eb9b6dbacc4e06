"""What memory a run takes, step by step, and how much of it for each pattern: ``python -m benchmarks.memory``.

Two runs of the simulated bench in virtual time, one longer than the other, each in a process of its own; Linux only. The
difference of their resident memory over that of their patterns is what each step keeps for a pattern. It holds the simulated
bench too, which works out what it will show, and in virtual time up to 64 MB that wait for the disk.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

_STEPS: Final = {
    "planned": "the plan is checked, its patterns are made",
    "counting": "the first block has come",
    "counted": "the last block has come",
    "stored": "the file is closed",
    "read": "the recording is read back",
}

_RUN: Final = """
import json, sys
from pathlib import Path
from instrument.config import bench_of_tables
from instrument.plan import Plan
from instrument.session import Instrument

resident = {}

def note(step):
    resident[step] = 4096 * int(Path("/proc/self/statm").read_text().split()[1])

frames = int(sys.argv[1])
plan = Plan(frames=frames, image_size=16, superpixel=4)
tables = {name: {"driver": "simulated"} for name in ("modulator", "counter", "stage")}
tables["modulator"]["play_order_entries"] = 20_000_000
scene = {"noise": {"kind": "poisson", "peak_counts": 300.0}}
with Instrument.from_config(bench_of_tables({**tables, "scene": scene}, "memory")) as bench:
    read = bench.counter.read

    def reading(timeout_s):
        block = read(timeout_s)
        if "counting" not in resident:
            note("counting")
        note("counted")
        return block

    bench.counter.read = reading
    run = bench.start(plan, sys.argv[2])
    note("planned")
    while not run.done:
        run._over.wait(1)
    note("stored")
    recording = run.recording
    note("read")
print(json.dumps(resident))
"""


def resident_bytes(frames: int) -> dict[str, int]:
    """Give the resident memory of a run at each step."""
    with tempfile.TemporaryDirectory(prefix="kinopix-memory-") as name:
        command = [sys.executable, "-c", _RUN, str(frames), str(Path(name) / "run.h5")]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
    found: dict[str, int] = json.loads(done.stdout)
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patterns", type=int, default=3_000_000, help="of the longer run; the other has a quarter")
    patterns = int(parser.parse_args().patterns)
    few, many = (resident_bytes(count // 6) for count in (patterns // 4, patterns))
    print(f"| when | MB, {patterns // 4} patterns | MB, {patterns} patterns | bytes a pattern |")
    print("|---|---|---|---|")
    for step, what in _STEPS.items():
        each = (many[step] - few[step]) / (patterns - patterns // 4)
        print(f"| {what} | {few[step] / 1e6:.0f} | {many[step] / 1e6:.0f} | {each:.1f} |")


if __name__ == "__main__":
    main()
