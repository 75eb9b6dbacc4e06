"""How well a bench is calibrated: dead time and its kind, dark counts, leak, edge loss, orientation and wiring.

python -m benchmarks.calibrations --draws 20

Each draw has its own photons, and its own dead time, dark rate, leak, edge loss, place, angle and orientation.
"""

import argparse
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from instrument import Instrument
from instrument.calibration import (
    PictureField,
    calibrate_alignment,
    calibrate_detector,
    calibrate_mirrors,
    laid,
    target_letter,
)
from instrument.config import ORIENTATIONS, DeadTimeKind, bench_of_tables

_KINDS: tuple[DeadTimeKind, ...] = ("non-paralyzable", "paralyzable")
_WHOLE = {"object": "square", "object_height_px": 128, "start_px": [64, 64]}
"""Nothing in the light: the whole field is lit."""

_WIRINGS: dict[str, dict[str, Any]] = {
    "as planned": {},
    "H- first": {"swap": {}},
    "inverted": {"mirrors_inverted": True},
}


@contextmanager
def bench_of(scene: dict[str, Any], *, counts: float, seed: int, **noise: Any) -> Generator[tuple[Instrument, Path]]:
    """Open a simulated bench with so many photons in a white picture of 50 us, and a folder for its runs."""
    photons = {"kind": "poisson", "peak_counts": counts, "peak_in_s": 5e-5, "seed": seed, **noise}
    tables: dict[str, Any] = {role: {"driver": "simulated"} for role in ("modulator", "counter", "stage")}
    tables["scene"] = {"noise": photons, "fresh_noise": True, **scene}
    with TemporaryDirectory() as name, Instrument.from_config(bench_of_tables(tables, "benchmark")) as bench:
        yield bench, Path(name)


def detectors(draws: int) -> None:
    """Print how far dead time and dark rate are off."""
    print("photons/s kind              right  dead time: worst  rms/stated   dark rate: rms/stated  longest")
    for mcps in (5, 20):
        for kind in _KINDS:
            right, off_ns, pulls, dark, pieces = 0, [0.0], [0.0], [0.0], [0]
            for draw in range(draws):
                random = np.random.default_rng([mcps, _KINDS.index(kind), draw])
                tau_s, dark_hz = float(random.uniform(15e-9, 40e-9)), float(random.uniform(50, 2000))
                noise = {"dead_time_s": tau_s, "dead_time_kind": kind, "dark_rate_hz": dark_hz}
                scene = {**_WHOLE, "mirror_transition_s": 4e-6, "edge_loss": float(random.uniform(0, 0.05))}
                with bench_of(scene, counts=mcps * 50, seed=draw, **noise) as (bench, folder):
                    field = PictureField(folder)
                    found = calibrate_detector(bench, field, longest_s=300.0, flicker_s=0.1).section
                    pieces.append(len(list(folder.glob("detector-ladder-*"))))
                if found.dead_time_s is not None:
                    right += found.dead_time_kind == kind
                    off_ns.append((found.dead_time_s.value - tau_s) * 1e9)
                    pulls.append((found.dead_time_s.value - tau_s) / found.dead_time_s.sigma)
                dark.append((found.dark_rate_hz.value - dark_hz) / found.dark_rate_hz.sigma)
            rms = [float(np.sqrt(np.mean(np.square(values[1:])))) for values in (pulls, dark)]
            worst = float(np.abs(off_ns).max())
            print(
                f"{mcps:6d}e6  {kind:16s} {right:3d}/{draws:<3d} {worst:10.2f} ns {rms[0]:10.2f} {rms[1]:22.2f} "
                f"{10 * max(pieces):14d} s"
            )


def mirrors(draws: int) -> None:
    """Print how far leak, edge loss and delay are off."""
    off: dict[str, list[float]] = {"leak": [], "edge loss": [], "late, us": []}
    for draw in range(draws):
        random = np.random.default_rng([3, draw])
        transition_s, edge = float(random.uniform(0, 12.5e-6)), float(random.uniform(0, 0.1))
        scene = {"mirror_transition_s": transition_s, "edge_loss": edge}
        with bench_of(scene, counts=250, seed=draw, dead_time_s=2e-8, dark_rate_hz=600.0) as (bench, folder):
            found = calibrate_mirrors(bench, PictureField(folder), seconds=1.0).section
        off["leak"].append(found.leak.value - transition_s / 2 / 50e-6)
        off["edge loss"].append(found.edge_loss.value - edge)
        off["late, us"].append((found.late_s.value - transition_s / 2) * 1e6)
    for name, values in off.items():
        print(f"{name:10s} worst {np.abs(values).max():.4f}  rms {np.sqrt(np.mean(np.square(values))):.4f}")


def alignments(draws: int) -> None:
    """Print how often orientation and wiring are told, at 50 counts in a white pattern."""
    right = {"orientation": 0, "wiring": 0, "both": 0}
    least, angles = np.inf, [0.0]
    for draw in range(draws):
        random = np.random.default_rng([4, draw])
        orientation = ORIENTATIONS[draw % 8]
        wiring = list(_WIRINGS)[int(random.integers(3))]
        cells = laid(target_letter(), orientation)
        with TemporaryDirectory() as name:
            np.save(f"{name}/target.npy", cells)
            angle_deg = float(random.uniform(-180, 180))
            scene: dict[str, Any] = {
                "object": f"{name}/target.npy",
                "object_height_px": float(random.uniform(16, 24)) * len(cells) / 40,
                "start_px": random.uniform(28, 36, 2).tolist(),
                "axis_angle_deg": angle_deg,
                "px_per_mm": 3.6,
                **_WIRINGS[wiring],
            }
            with bench_of(scene, counts=50, seed=draw, dark_rate_hz=600.0) as (bench, folder):
                field = PictureField(folder, image_size=64, superpixel=4)
                found = calibrate_alignment(bench, field, step_mm=2.0).section
        right["orientation"] += found.orientation == orientation
        right["wiring"] += found.wiring == wiring
        right["both"] += (found.orientation, found.wiring) == (orientation, wiring)
        least = min(least, found.certainty)
        if found.axis_angle_deg is not None:
            off = (found.axis_angle_deg.value - angle_deg + 180) % 360 - 180
            angles.append(off / found.axis_angle_deg.sigma)
    print(", ".join(f"{name} right in {times} of {draws}" for name, times in right.items()))
    rms = float(np.sqrt(np.mean(np.square(angles[1:]))))
    print(f"least log-likelihood over the next {least:.0f}; angle of the axis rms/stated {rms:.2f}")


def main(arguments: list[str]) -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=4)
    parser.add_argument("--only", choices=["detectors", "mirrors", "alignments"])
    options = parser.parse_args(arguments)
    for name, table in (("detectors", detectors), ("mirrors", mirrors), ("alignments", alignments)):
        if options.only in {None, name}:
            print(f"# {name}, {options.draws} draws")
            table(options.draws)


if __name__ == "__main__":
    main(sys.argv[1:])
