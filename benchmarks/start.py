"""How long the start takes, as ratios of processor time of whole processes: ``python -m benchmarks.start [--repeats 11]``.

``import kinopix`` against ``import numpy, pydantic, h5py`` (at most 2), and ``kinopix --help`` against ``import typer, rich``, of
which it is made (at most 3). The two of a pair run in turn, so that a machine that slows down slows both.
"""

import argparse
import os
import subprocess
import sys
from statistics import median

PAIRS: tuple[tuple[str, list[str], str, list[str]], ...] = (
    ("import kinopix", ["-c", "import kinopix"], "numpy, pydantic, h5py", ["-c", "import numpy, pydantic, h5py"]),
    (
        "from kinopix import Plan",
        ["-c", "from kinopix import Plan"],
        "numpy, pydantic",
        ["-c", "import numpy, pydantic"],
    ),
    ("kinopix --help", ["-m", "kinopix", "--help"], "typer, rich", ["-c", "import typer, rich"]),
)


def processor_s(arguments: list[str]) -> float:
    """Give the processor time of one Python process, in seconds."""
    before = os.times()
    subprocess.run([sys.executable, *arguments], capture_output=True, check=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def main() -> None:
    """Print one line a pair."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=11, help="runs of each process, after one that does not count")
    repeats = parser.parse_args().repeats
    for name, ours, against, theirs in PAIRS:
        pairs = [(processor_s(ours), processor_s(theirs)) for _ in range(repeats + 1)][1:]
        own_s, other_s = (median(times) for times in zip(*pairs, strict=True))
        ratio = median(own / max(other, 1e-3) for own, other in pairs)
        print(f"{name:26} {own_s:.3f} s, {against}: {other_s:.3f} s, ratio {ratio:.2f}")


if __name__ == "__main__":
    main()
