"""Every scheme on the paper's simulation: ``python -m benchmarks.schemes [--seeds 5] [--only NAME]``.

128 x 128 pixels, a "B" 36 px high, noise ``pixel`` of 0.1, motions I and II, 1,666 frames of whatever patterns the scheme has
(the motion is stretched to the run). Every seed has its own noise and its own place of the object, between pixels.

A line a scheme and motion: displacement MSE of each frame by itself, smoothed, and refined together with the image (px^2), each
with the share of frames in the stated 95 % interval (%); then the image's PSNR with the motion frame by frame, by TVAL3's model
with mu 16 and mu 256, and with the refined motion by our solver (dB). ``hadamard`` follows no motion: 4,998 pairs of conventional
imaging are reconstructed as if the object stood still, and then with the object really at rest.
"""

import argparse
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from benchmarks.scenes import FRAMES, MOTIONS, RUN_S, Path2D, letter_b, recorded
from instrument.joint import refine
from instrument.measurement import Measurement
from instrument.numerics import displacement_mse, psnr, tv_augmented_lagrangian
from instrument.plan import Plan
from instrument.reconstruction import Problem, reconstruct
from instrument.recording import Recording
from instrument.schemes import scheme_of
from instrument.tracking import Trajectory, track
from protocols import Floats, Truth

SCHEMES = ("fourier-hadamard", "moment-hadamard", "fourier-3step", "fourier-4step", "moment", "moment-complementary")
PUBLISHED = ("fourier-3step", "moment", "moment-complementary")
PAIRS = 4998
COLUMNS = ((10, 4), (6, 1), (9, 4), (6, 1), (9, 4), (6, 1), (8, 2), (8, 2), (7, 2))
"""Width and digits of each figure of ``followed``."""
PLACES_PX = 10.0
"""Places are drawn from a square this wide."""


def stretched(path: Path2D, run_s: float, place_px: Floats) -> Path2D:
    """Give a motion at another place and in another time."""

    def elsewhere(time_s: Floats) -> Floats:
        moved: Floats = path(time_s * (RUN_S / run_s)) + place_px
        return moved

    return elsewhere


def one_run(
    scheme: dict[str, Any], motion: str | None, seed: int, sigma: float, frames: int = FRAMES
) -> tuple[Recording, Truth]:
    """Simulate one run; without a motion, at rest."""
    plan = Plan.model_validate({"frames": frames, "scheme": scheme})
    place_px = np.random.default_rng(seed).random(2) * PLACES_PX
    path: Path2D = MOTIONS[motion] if motion is not None else lambda time_s: np.zeros((len(time_s), 2))
    recording = recorded(plan, letter_b(5, 5), stretched(path, plan.run_time_s, place_px), sigma=sigma, seed=seed)
    assert recording.truth is not None  # noqa: S101  (simulated)
    return recording, recording.truth


def tval3_psnr(recording: Recording, motion: Trajectory, truth: Truth, mu: float) -> float:
    """PSNR of the image by TVAL3's model, on the whole field as its authors use it."""
    measurement = Measurement.of(recording)
    problem = Problem.of(measurement, measurement.image_values(steady_object=False), motion, region="field")
    return psnr(tv_augmented_lagrangian(*problem.hadamard(), mu=mu).image.astype(np.float64), truth.image)


def followed(scheme: dict[str, Any], motion: str, seed: int, *, sigma: float) -> list[float]:
    """Figures of one run of a scheme that tracks; NaN for what a scheme does not have."""
    recording, truth = one_run(scheme, motion, seed, sigma)
    alone, smooth = track(recording, "per-frame"), track(recording)
    nothing = [float("nan")] * 2
    figures = [*_of_path(alone, truth), *_of_path(smooth, truth)]
    if scheme_of(recording.plan).image_rows is None:
        return [*figures, *nothing, float("nan"), *nothing]
    refined = refine(recording, smooth)
    paper = [tval3_psnr(recording, alone, truth, mu) for mu in (16.0, 256.0)]
    return [*figures, *_of_path(refined.trajectory, truth), *paper, psnr(refined.image.image, truth.image)]


def unfollowed(motion: str | None, seed: int, *, sigma: float) -> list[float]:
    """PSNR of conventional imaging, by the inverse transform and by least total variation, as if the object stood still."""
    recording, truth = one_run({"name": "hadamard"}, motion, seed, sigma, frames=PAIRS)
    return [
        psnr(reconstruct(recording, None, "conventional").image, truth.image),
        psnr(reconstruct(recording, None, "tv").image, truth.image),
    ]


def published(name: str, seed: int, *, sigma: float) -> list[float]:
    """Root mean square of the absolute position's error, each frame by itself, x and y; of the displacement, for phases."""
    recording, truth = one_run({"name": name}, "I", seed, sigma)
    found = track(recording, "per-frame")
    error = found.displacement_px - truth.displacement_px
    if found.start_px is not None:
        measured = Measurement.of(recording).observe(steady=False, as_measured=True)
        light = truth.image.sum()
        line = np.arange(len(truth.image))
        start_px = np.array([truth.image.sum(axis=0) @ line, truth.image.sum(axis=1) @ line]) / light
        error = measured.signal.real - start_px - truth.displacement_px
    return np.sqrt(np.mean(error**2, axis=0)).tolist()


def print_published(seeds: int, sigma: float, kilohertz: float = 22.2) -> None:
    """Print what the schemes' own papers print: frames a second and root mean square error."""
    print(f"{'scheme':22}{'frames/s at ' + format(kilohertz, 'g') + ' kHz':>22}{'RMSE x':>9}{'y, px':>8}")
    for name in PUBLISHED:
        patterns = Plan.model_validate({"frames": 1, "scheme": name}).patterns_per_frame
        x, y = _mean(partial(published, name, sigma=sigma), seeds)
        print(f"{name:22}{1e3 * kilohertz / patterns:22.0f}{x:9.3f}{y:8.3f}", flush=True)


def _of_path(found: Trajectory, truth: Truth) -> list[float]:
    error = np.abs(found.displacement_px - truth.displacement_px)[1:]
    covered = 100 * float(np.mean(error <= 1.96 * found.sigma_px[1:]))
    return [displacement_mse(found.displacement_px, truth.displacement_px), covered]


def _mean(figures: Callable[[int], list[float]], seeds: int) -> list[float]:
    mean: list[float] = np.mean([figures(seed) for seed in range(seeds)], axis=0).tolist()
    return mean


def _cell(figure: float, width: int, digits: int) -> str:
    return f"{'-':>{width}}" if np.isnan(figure) else f"{figure:{width}.{digits}f}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--sigma", type=float, default=0.1, help="noise on every pixel")
    parser.add_argument(
        "--upsampling", type=int, default=None, help="dithering samples a pixel side; the scheme's own if not given"
    )
    parser.add_argument("--only", default="", help="schemes whose name has this in it")
    parser.add_argument(
        "--published", action="store_true", help="rates and errors as the schemes' own papers print them"
    )
    options = parser.parse_args()
    if options.published:
        print_published(options.seeds, options.sigma)
        return
    finer = {} if options.upsampling is None else {"upsampling": options.upsampling}
    print(f"{'scheme':17}{'motion':7}{'per-frame':>10}{'%':>6}{'smooth':>9}{'%':>6}{'joint':>9}{'%':>6}", end="")
    print(f"{'mu 16':>8}{'mu 256':>8}{'ours':>7}")
    for name in (name for name in SCHEMES if options.only in name):
        for motion in ("I", "II"):
            run = partial(followed, {"name": name, **finer}, motion, sigma=options.sigma)
            mean = _mean(run, options.seeds)
            cells = "".join(_cell(figure, *form) for figure, form in zip(mean, COLUMNS, strict=True))
            print(f"{name:17}{motion:7}{cells}", flush=True)
    if options.only in "hadamard":
        for motion in ("I", "II", None):
            inverse, ours = _mean(partial(unfollowed, motion, sigma=options.sigma), options.seeds)
            print(
                f"{'hadamard':17}{motion or 'rest':7}inverse transform {inverse:.2f} dB, tv {ours:.2f} dB", flush=True
            )


if __name__ == "__main__":
    main()
