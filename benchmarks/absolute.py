"""The absolute position by ramps in the first frames: ``python -m benchmarks.absolute [--draws 25] [--frames 600]``.

128 x 128 pixels, noise ``pixel`` of 0.1, the six-pattern scheme with ``moment_frames``. Every draw has its own noise, its own
object ("B" of 30 to 40 px, or a plane), its own place anywhere in the field and its own straight way of up to 24 px.

A line a case: root mean square and largest error of the centroid at frame 0, both axes, against that of the true image; the mean
of the stated uncertainty; the share of errors below 0.5 px and that within twice the uncertainty.
"""

import argparse
from typing import Any, Final

import numpy as np

from benchmarks.scenes import placed
from instrument import Plan, Recording, simulate
from instrument.analysis import analyse
from instrument.tracking import track
from protocols import Floats

CASES: Final[dict[str, tuple[int, int, float, dict[str, Any], bool]]] = {
    "32 frames": (32, 1, 0.1, {}, False),
    "64 frames": (64, 1, 0.1, {}, False),
    "128 frames": (128, 1, 0.1, {}, False),
    "128 frames, two samples a pixel": (128, 2, 0.1, {}, False),
    "128 frames, no noise": (128, 1, 0.0, {}, False),
    "128 frames, joint": (128, 1, 0.1, {}, True),
    "the same, leak 0.04": (128, 1, 0.1, {"mirror_transition_s": 4e-6}, True),
    "the same, edge loss 0.02": (128, 1, 0.1, {"edge_loss": 0.02}, True),
    "the same, background, R = 3.25": (128, 1, 0.1, {"background": "letter-I", "background_level": 1.0}, True),
}
"""Ramps, dithering samples, noise, what the scene has, and whether path and image are refined together."""


def one_error(case: str, draw: int, frames: int) -> tuple[Floats, Floats]:
    """Error of the centroid, x and y, and its stated uncertainty, in px."""
    ramps, upsampling, sigma, flaws, joint = CASES[case]
    scheme = {"name": "fourier-hadamard", "moment_frames": ramps, "upsampling": upsampling}
    plan = Plan.model_validate({"frames": frames, "scheme": scheme})
    rng = np.random.default_rng(draw)
    name, height_px = ("plane", 36.0) if draw % 4 == 3 else ("letter-B", float(rng.integers(30, 41)))
    image = placed(name, 0, 0, height_px=height_px)
    rows, columns = np.flatnonzero(image.any(axis=1)), np.flatnonzero(image.any(axis=0))
    room_px = np.array([128 - columns[-1] - 1, 128 - rows[-1] - 1], np.float64)
    start_px = rng.random(2) * room_px
    end_px = np.clip(start_px + rng.uniform(-24, 24, 2), 0, room_px)

    def path(time_s: Floats) -> Floats:
        part = (time_s / plan.run_time_s)[:, None]
        way: Floats = start_px + (end_px - start_px) * np.clip(part, 0, 1)
        return way

    noise = {"kind": "pixel", "sigma": sigma, "seed": draw} if sigma else {"kind": "none"}
    recording: Recording = simulate(plan, {"noise": noise, **flaws}, image=image, path=path)
    assert recording.truth is not None  # noqa: S101  (simulated)
    found = analyse(recording).trajectory if joint else track(recording)
    truth = recording.truth.image
    line = np.arange(128)
    centroid_px = np.array([truth.sum(axis=0) @ line, truth.sum(axis=1) @ line]) / truth.sum()
    assert found is not None  # noqa: S101  (the scheme tracks)
    assert found.start_px is not None  # noqa: S101  (it has ramps)
    assert found.start_sigma_px is not None  # noqa: S101
    return found.start_px - centroid_px, found.start_sigma_px


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=25)
    parser.add_argument("--frames", type=int, default=600)
    parser.add_argument("--only", default="", help="cases whose name has this in it")
    options = parser.parse_args()
    print(f"{'case':34}{'rms':>7}{'max':>7}{'stated':>8}{'< 0.5 px':>10}{'< 2 sigma':>11}")
    for case in (case for case in CASES if options.only in case):
        drawn = [one_error(case, draw, options.frames) for draw in range(options.draws)]
        error, sigma = (np.abs(np.array(part)) for part in zip(*drawn, strict=True))
        near, within = 100 * np.mean(error < 0.5), 100 * np.mean(error < 2 * sigma)
        rms = float(np.sqrt(np.mean(error**2)))
        print(f"{case:34}{rms:7.3f}{error.max():7.3f}{sigma.mean():8.3f}{near:8.0f} %{within:9.0f} %", flush=True)


if __name__ == "__main__":
    main()
