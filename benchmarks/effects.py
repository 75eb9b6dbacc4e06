"""What each flaw of a real bench costs, with the light model off and with all of it found from the run itself.

``python -m benchmarks.effects [--seeds 5] [--only TITLE]``, from the repository's root. 128 x 128 pixels, 1,666 frames. Each seed
puts the object at another place, drawn at random between pixels. MSE in px^2, PSNR in dB at the patterns' resolution, object and
background. "off" takes the light as it arrived, on the patterns' grid, as on an ideal bench; the rest is ``analyse`` with its
defaults. Errors of the path are over the frames in which at least half of the object is inside the field. "fine" is against the
truth at twice the patterns' resolution. "covered" is the share of 95 % intervals of the path that hold the truth, "err/sig" the
rms of its error over the uncertainty that is stated. Times are those of this machine, now.
"""

import argparse
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
from scipy.ndimage import shift

from benchmarks.scenes import FRAMES, RUN_S, SIZE, Path2D, arc
from instrument import Plan, Recording, analyse, simulate
from instrument.analysis.leaving import share_inside
from instrument.config import NOTHING_KNOWN, Grid, LightTable
from instrument.frame_times import frame_middle_s
from instrument.joint import refine
from instrument.measurement import Measurement
from instrument.numerics import displacement_mse, psnr
from instrument.tracking import Trajectory, track
from protocols import Floats, KinopixError, Mask
from sim_backends.bench.objects import BUILT_INS

_FALLOFF: Final = 0.35
"""Share of the light that is missing in the corners of a field that is not evenly lit."""

_FINER: Final = 8
"""Cells that a pixel has along each axis where an object is drawn between pixels."""

_PIXEL: Final[Mapping[str, Any]] = {"kind": "pixel", "sigma": 0.1}
_PHOTONS: Final[Mapping[str, Any]] = {"kind": "poisson", "peak_counts": 500.0}


def drawn(name: str, height_px: float, top_px: float, left_px: float) -> Floats:
    """Draw a built-in object anywhere between pixels, ``(8 m, 8 m)`` cells of an eighth of a pixel."""
    drawing = BUILT_INS[name](height_px if name == "bars" else height_px * _FINER)
    cells = drawing.cells.repeat(round(drawing.cell_px * _FINER), 0).repeat(round(drawing.cell_px * _FINER), 1)
    if name != "bars":
        cells = drawing.cells
    canvas = np.zeros((SIZE * _FINER, SIZE * _FINER))
    top, left = round(top_px * _FINER), round(left_px * _FINER)
    canvas[top : top + cells.shape[0], left : left + cells.shape[1]] = cells
    return canvas


def at(fine: Floats, pixels: int) -> Floats:
    """Give a drawing at ``pixels`` a side."""
    cells = len(fine) // pixels
    return np.asarray(fine.reshape(pixels, cells, pixels, cells).mean(axis=(1, 3)), np.float64)


def straight(travel_px: float) -> Path2D:
    """Go so far along a line, a little faster at the end."""

    def path(time_s: Floats) -> Floats:
        part = time_s / RUN_S
        way = travel_px * (0.77 * part + 0.23 * part**2)
        return np.stack([0.8 * way, 0.6 * way], axis=1)

    return path


def coming(travel_px: float) -> Path2D:
    """Come back along the same line to where the object is drawn."""

    def path(time_s: Floats) -> Floats:
        return straight(travel_px)(RUN_S - time_s)

    return path


def passing(before_px: float, travel_px: float) -> Path2D:
    """Go along the same line from a distance before where the object is drawn."""

    def path(time_s: Floats) -> Floats:
        return straight(travel_px)(time_s) - np.array([0.8, 0.6]) * before_px

    return path


def displaced(fine: Floats, px: Floats) -> Floats:
    """Move a drawing by ``(2,)`` px along x and y; what leaves the field is cut off."""
    return np.asarray(shift(fine, px[::-1] * _FINER, order=1), np.float64)


def falling(share: float) -> Grid:
    """Give the brightness of a field that is darker by a share in its corners, at 5 x 5 points."""
    squared = np.linspace(-1, 1, 5) ** 2
    rows: list[list[float]] = (1 - share * (squared[:, None] + squared) / 2).tolist()
    return tuple(tuple(row) for row in rows)


def intervals(found: Trajectory, truth_px: Floats, seen: Mask) -> tuple[float, float]:
    """Share of stated 95 % intervals that hold the truth, and rms of error over stated sigma, where the object was seen.

    The errors of a run hang together, so that of a few runs the share scatters far: ``benchmarks.coverage`` has more of them.
    """
    known = seen[:, None] & np.isfinite(found.sigma_px) & (found.sigma_px > 0)
    ratio = (found.displacement_px - truth_px)[known] / found.sigma_px[known]
    return float(np.mean(np.abs(ratio) < 1.96)), float(np.sqrt(np.mean(ratio**2)))


@dataclass(frozen=True)
class Effect:
    """One line of the table."""

    title: str
    scene: Mapping[str, Any] = field(default_factory=dict[str, Any])
    noise: Mapping[str, Any] | None = field(default_factory=lambda: _PIXEL)
    """Noise; None leaves it to the scene."""
    background: float = 0.0
    """Light of the object over that of the letters I and T beside it; 0 for no background."""
    path: Path2D = arc
    name: str = "letter-B"
    light: LightTable = NOTHING_KNOWN
    """What the analysis is told."""

    def run(self, seed: int, folder: Path) -> tuple[Recording, Floats, Floats | None]:
        """Record it: recording, drawing of the object, and background at the patterns' resolution."""
        top_px, left_px = np.random.default_rng([7, seed]).uniform(12, 20, 2).tolist()
        fine = drawn(self.name, 36.0, top_px, left_px)
        np.save(folder / "object.npy", fine)
        scene: dict[str, Any] = {
            "object": str(folder / "object.npy"),
            "object_height_px": float(SIZE),
            "start_px": [SIZE / 2, SIZE / 2],
            **self.scene,
        }
        if self.noise is not None:
            scene["noise"] = {**self.noise, "seed": seed}
        still: Floats | None = None
        if self.background:
            letters = drawn("letter-I", 36.0, 70.0, 20.0) + drawn("letter-T", 36.0, 20.0, 80.0)
            level = float(fine.sum() / letters.sum()) / self.background
            np.save(folder / "background.npy", letters * min(level, 1.0))
            scene |= {"background": str(folder / "background.npy"), "background_level": max(level, 1.0)}
            still = at(letters, SIZE) * level
        recording = simulate(Plan(frames=FRAMES, image_size=SIZE), scene, path=self.path)
        return replace(recording, light=self.light), fine, still

    def figures(self, seed: int) -> list[float]:
        """Figures of one seed."""
        with TemporaryDirectory() as name:
            recording, fine, still = self.run(seed, Path(name))
        assert recording.truth is not None  # noqa: S101  (a simulated run has one)
        truth_px, image, gain = recording.truth.displacement_px, at(fine, SIZE), recording.photon_counts
        place_px = self.path(frame_middle_s(FRAMES, recording.frame_time_s))
        seen = share_inside(image, place_px) >= 0.5
        off_mse, off_db, off_s = float("nan"), float("nan"), float("nan")
        found = analyse(recording)
        first = found.reference_frame
        if np.abs(place_px[first]).max() > 1:  # the object was not drawn where displacements count from
            fine = displaced(fine, place_px[first])
            truth_px, image = truth_px - truth_px[first], at(fine, SIZE)
        try:
            if first:
                raise ValueError("displacements and image at frame 0 are not those of a whole object")
            started = time.perf_counter()
            as_arrived = replace(Measurement.of(recording), light_found=True)
            plain = refine(as_arrived, track(as_arrived), background="none", fitted=False)
            off_s = time.perf_counter() - started
            off_mse = displacement_mse(plain.trajectory.displacement_px[seen], truth_px[seen])
            off_db = psnr(plain.image.at_patterns, image, fit_gain=gain)
        except (ValueError, KinopixError) as error:  # the light as it arrived leads nowhere
            print(f"  {self.title}, model off: {error}")
        assert found.trajectory is not None  # noqa: S101
        assert found.reconstruction is not None  # noqa: S101
        of_still = float("nan")
        if still is not None and found.reconstruction.still is not None:
            squared = np.mean((found.reconstruction.still - still) ** 2)
            of_still = 10 * np.log10(max(float(still.max()), 1.0) ** 2 / squared)
        fine_db = psnr(
            found.reconstruction.image.repeat(2 // found.reconstruction.grid, 0).repeat(
                2 // found.reconstruction.grid, 1
            ),
            at(fine, 2 * SIZE),
            fit_gain=gain,
        )
        covered, ratio = intervals(found.trajectory, truth_px, seen)
        return [
            off_mse,
            off_db,
            displacement_mse(found.trajectory.displacement_px[seen], truth_px[seen]),
            psnr(found.reconstruction.at_patterns, image, fit_gain=gain),
            fine_db,
            of_still,
            found.light.leak.value,
            found.light.edge_loss.value,
            found.figures.misfit or float("nan"),
            covered,
            ratio,
            float(found.reconstruction.grid),
            off_s,
            found.figures.analysis_s,
        ]


_ALL: Final[Mapping[str, Any]] = {
    "mirror_transition_s": 4e-6,
    "edge_loss": 0.03,
    "ambient_level": 0.2,
    "led_flicker": 0.10,
    "led_drift_per_s": -0.2,
}
EFFECTS: Final = (
    Effect("ideal"),
    *(Effect(f"ideal, {name}", name=name) for name in ("plane", "disc", "ring", "bars")),
    *(Effect(f"leak {c:g}", {"mirror_transition_s": c * 1e-4}) for c in (0.04, 0.125)),
    *(Effect(f"edge loss {loss:g}", {"edge_loss": loss}) for loss in (0.02, 0.05, 0.10)),
    *(Effect(f"background, R {ratio:g}", background=ratio, path=straight(62)) for ratio in (8.6, 3.25, 1.6, 1.04, 0.5)),
    *(Effect(f"background, {way} px", background=1.6, path=straight(way)) for way in (40, 20, 12)),
    *(Effect(f"ideal, {way} px", path=straight(way)) for way in (62, 40, 20, 12)),
    *(Effect(f"leaves, {way} px", path=straight(way)) for way in (92, 110, 128, 150)),
    *(Effect(f"comes, {way} px", path=coming(way)) for way in (92, 110, 128, 150)),
    Effect("passes, 200 px", path=passing(75, 200)),
    Effect("turns by 3 degrees", {"object_turn_deg": 3.0}),
    Effect("grows by 3 %", {"object_growth": 0.03}),
    Effect("light falls by 35 %", {"illumination_falloff": _FALLOFF}),
    Effect("the same, profile given", {"illumination_falloff": _FALLOFF}, light=LightTable(profile=falling(_FALLOFF))),
    Effect("photons", noise=_PHOTONS),
    Effect("photons, leak 0.04", {"mirror_transition_s": 4e-6}, _PHOTONS),
    Effect("photons, ambient 0.2", {"ambient_level": 0.2}, _PHOTONS),
    Effect("photons, 100 Hz ambient", {"ambient_level": 0.2, "ambient_ripple": 0.5}, _PHOTONS),
    Effect("photons, 100 Hz flicker", {"led_flicker": 0.1}, _PHOTONS),
    Effect("photons, all of it", _ALL, {**_PHOTONS, "dead_time_s": 20e-9, "dark_rate_hz": 600.0}),
    Effect("realistic", {"realism": "realistic"}, None),
    Effect("realistic, 125 half-lit", noise={"kind": "poisson", "peak_counts": 250.0}),
)
"""The lines; "realistic" counts 250 photons of an all-on pattern, and the line below it is the ideal bench at that light."""

_HEADS: Final = (
    "off MSE",
    "off dB",
    "MSE",
    "dB",
    "fine dB",
    "still dB",
    "leak",
    "edge",
    "misfit",
    "covered",
    "err/sig",
    "grid",
    "off s",
    "s",
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--only", default="", help="effects whose title contains this")
    arguments = parser.parse_args()
    seeds: int = arguments.seeds
    only: str = arguments.only
    print(" " * 24 + " ".join(f"{head:>8s}" for head in _HEADS))
    for effect in EFFECTS:
        if only in effect.title:
            figures = np.array([effect.figures(seed) for seed in range(seeds)])
            means, spread = figures.mean(axis=0), figures[:, 3].std()
            print(
                f"{effect.title:24s}" + " ".join(f"{mean:8.4f}" for mean in means) + f"  +- {spread:.1f} dB", flush=True
            )


if __name__ == "__main__":
    main()
