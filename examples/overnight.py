"""A lab script: a series of runs that nobody watches, with a log. Started again, it goes on where it was.

python examples/overnight.py bench.toml plan.toml folder/ 200

Each run opens the bench anew, so that a device that hung up in one is asked again in the next. A run that fails is tried
twice; what it recorded is kept beside the others, and the series goes on. Three runs in a row that fail end it: somebody
must look.
"""

import csv
import sys
from datetime import UTC, datetime
from pathlib import Path

from instrument import Instrument, Plan, open_recording
from protocols import InputError, KinopixError

TRIES = 2
IN_A_ROW = 3


def main(bench_toml: Path, plan_toml: Path, folder: Path, runs: int) -> None:
    """Record what is missing of the series.

    Raises:
        InputError: a mistake in a file: no run would be any better.
        SystemExit: ``IN_A_ROW`` runs failed.
    """
    folder.mkdir(parents=True, exist_ok=True)
    plan = Plan.from_toml(plan_toml)
    failed = 0
    for number in range(runs):
        path = folder / f"run-{number:03d}.h5"
        if path.exists() and is_good(path):
            continue
        failed = 0 if recorded(bench_toml, plan, path) else failed + 1
        if failed == IN_A_ROW:
            raise SystemExit(f"{IN_A_ROW} runs in a row failed: see {folder / 'log.csv'}")
    print(f"{sum(is_good(path) for path in folder.glob('run-???.h5'))} of {runs} runs are good")


def recorded(bench_toml: Path, plan: Plan, path: Path) -> bool:
    """Record one run, and tell whether it is good."""
    for attempt in range(1, TRIES + 1):
        if path.exists():
            path.rename(free_name(path))
        try:
            with Instrument.from_toml(bench_toml) as bench:
                recording = bench.run(plan, path)
        except InputError:
            raise
        except KinopixError as error:
            log(path, f"attempt {attempt} failed", str(error))
            continue
        verdict = recording.timing.verdict if recording.timing is not None else "no audit"
        log(path, verdict, f"{int(recording.frame_valid.sum())} of {plan.frames} frames are good")
        if verdict in {"good", "flagged"}:
            return True
    return False


def is_good(path: Path) -> bool:
    """Whether a recording is whole and its timing can be trusted."""
    try:
        recording = open_recording(path)
    except KinopixError:
        return False
    return recording.timing is not None and recording.timing.verdict in {"good", "flagged"}


def free_name(path: Path) -> Path:
    """A name for a recording that is not good: nothing that was recorded is lost."""
    number = 1
    while (kept := path.with_name(f"{path.stem}-bad-{number}.h5")).exists():
        number += 1
    return kept


def log(path: Path, what: str, why: str) -> None:
    """Add a line to the log, and print it."""
    line = [datetime.now(UTC).isoformat(timespec="seconds"), path.name, what, why]
    with (path.parent / "log.csv").open("a", newline="", encoding="utf-8") as file:
        csv.writer(file).writerow(line)
    print(*line[1:], sep=": ")


if __name__ == "__main__":
    if len(sys.argv) != 5:
        raise SystemExit(__doc__)
    main(*(Path(argument) for argument in sys.argv[1:4]), runs=int(sys.argv[4]))
