"""A lab script: repeat a run until the mean of its images is good enough.

python examples/until_good.py bench.toml plan.toml folder/ 35

The stage begins each run at the same place, so that the images lie upon one another. How good their mean is follows from how they
differ: no truth is needed.
"""

import sys
from pathlib import Path

import numpy as np

from instrument import Instrument, Plan, analyse
from protocols import Floats

MOST_RUNS = 20


def main(bench_toml: Path, plan_toml: Path, folder: Path, wanted_db: float) -> None:
    """Record and analyse until the mean image is as good as wanted, and keep it."""
    folder.mkdir(parents=True, exist_ok=True)
    plan = Plan.from_toml(plan_toml)
    images: list[Floats] = []
    with Instrument.from_toml(bench_toml) as bench:
        while len(images) < MOST_RUNS:
            recording = bench.run(plan, folder / f"run-{len(images):03d}.h5")
            image = analyse(recording, grid="1").image
            if image is None:
                raise SystemExit(f"the scheme {plan.scheme.name} makes no image")
            images.append(image)
            reached_db = signal_to_noise_db(images)
            print(f"{len(images)} runs: {reached_db:.1f} dB")
            if reached_db >= wanted_db:
                break
        else:
            print(f"{wanted_db:g} dB were not reached in {MOST_RUNS} runs: more light helps, or more frames")
    np.save(folder / "image.npy", np.mean(images, axis=0))


def signal_to_noise_db(images: list[Floats]) -> float:
    """Peak of the mean image over its standard error, from how the images differ; minus infinity for one image."""
    if len(images) < 2:
        return float("-inf")
    stack = np.stack(images)
    error = (float(stack.var(axis=0, ddof=1).mean()) / len(stack)) ** 0.5
    return float(20 * np.log10(float(stack.mean(axis=0).max()) / max(error, 1e-12)))


if __name__ == "__main__":
    if len(sys.argv) != 5:
        raise SystemExit(__doc__)
    main(*(Path(argument) for argument in sys.argv[1:4]), wanted_db=float(sys.argv[4]))
