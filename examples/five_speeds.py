# pyright: reportUnknownMemberType=false
# matplotlib leaves the type of its **kwargs open.
"""A lab script: run at five speeds, and plot measured against commanded speed with 95 % intervals.

python examples/five_speeds.py bench.toml plan.toml folder/

The bench must be calibrated (kinopix calibrate displacement), so that speeds are in mm/s.
"""

import csv
import sys
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from instrument import Instrument, Plan, analyse

SHARES = (0.2, 0.4, 0.6, 0.8, 1.0)
"""Speeds, as shares of the plan's."""


def main(bench_toml: Path, plan_toml: Path, folder: Path) -> None:
    """Record, analyse, write a table and a plot."""
    plan = Plan.from_toml(plan_toml)
    if plan.motion is None:
        raise SystemExit("the plan has no [motion]: nothing to vary")
    folder.mkdir(parents=True, exist_ok=True)
    rows: list[tuple[float, float, float]] = []
    with Instrument.from_toml(bench_toml) as bench:
        for share in SHARES:
            commanded = share * plan.motion.velocity_mm_s
            motion = plan.motion.model_copy(update={"velocity_mm_s": commanded})
            recording = bench.run(plan.model_copy(update={"motion": motion}), folder / f"{commanded:g}-mm-s.h5")
            fit = analyse(recording).figures.motion_mm
            if fit is None:
                raise SystemExit("not calibrated: kinopix calibrate displacement, and name its file in bench.toml")
            half_width = (fit.speed.high - fit.speed.low) / 2
            rows.append((commanded, fit.speed.value, half_width))
            print(f"{commanded:g} mm/s commanded: {fit.speed.value:.3f} +- {half_width:.3f} mm/s (95 %)")
    with (folder / "speeds.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(["commanded_mm_s", "measured_mm_s", "half_width_95_mm_s"])
        table.writerows(rows)
    plot(rows, folder / "speeds.png")


def plot(rows: list[tuple[float, float, float]], path: Path) -> None:
    """Draw measured minus commanded speed, so that the intervals can be seen."""
    figure = Figure(figsize=(6, 4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    commanded = [row[0] for row in rows]
    axes.errorbar(commanded, [row[1] - row[0] for row in rows], [row[2] for row in rows], fmt="o", capsize=4)
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    axes.set_xlabel("commanded speed, mm/s")
    axes.set_ylabel("measured minus commanded, mm/s (95 %)")
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        raise SystemExit(__doc__)
    main(*(Path(argument) for argument in sys.argv[1:4]))
