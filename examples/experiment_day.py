"""A day at the paper's bench, simulated: static references, the stage's real steps, moving runs, backgrounds.

python examples/experiment_day.py results/ [--short]

The bench is the realistic one of docs/reference/scene.md, with photons counted. In order:

1. the static reference: 9,996 Hadamard patterns and their complements (19,992 patterns, 61.01 % sampling), 100 a second;
2. the same image at 20,000 patterns a second;
3. the real displacement: such images at three places of the stage, registered by phase correlation (pip install scikit-image);
4. the moving runs along the diagonal, one at 25 mm/s and one from rest with 50 mm/s^2, judged by the static reference;
5. a background, the letter "T", with R = 8.60, 3.25, 1.60, 1.04: recorded alone, and then with the object at 25 mm/s.

``--short`` does the same on 32 x 32 px with fewer frames, in seconds: to see that all of it works.
"""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
from skimage.registration import phase_cross_correlation  # pyright: ignore[reportUnknownVariableType]  (it carries no types)

from instrument import Analysis, Instrument, Plan, Recording, analyse, reconstruct
from instrument.numerics import psnr
from protocols import Floats

HERE_MM = 10.0
"""Where the stage stands when the object is in its place of the references."""

RUN_UP_MM = 8.75
"""25 mm/s from rest at 50 mm/s^2, and a tenth of a second of cruise."""

PLACES_MM = (10.0, 12.0, 14.0)
RATIOS = (8.60, 3.25, 1.60, 1.04)

register = cast("Callable[..., tuple[Floats, float, float]]", phase_cross_correlation)


class Day:
    """The plans and the benches of the day, and a folder for what is recorded."""

    def __init__(self, folder: Path, *, short: bool) -> None:
        """Prepare."""
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self.size: dict[str, Any] = {"image_size": 32 if short else 128}
        self.frames = 250 if short else 1666
        self.pairs = 625 if short else 9996

    def bench(self, *, noise: dict[str, Any] | None = None, **scene: Any) -> Instrument:
        """Open the bench with what stands on it now."""
        table = {"realism": "realistic", "object_at_mm": HERE_MM, **scene}
        noise = {"kind": "poisson", "peak_counts": 250.0, **(noise or {})}
        lines = [f"{key} = {json.dumps(value)}" for key, value in table.items()]
        lines.append("noise = { " + ", ".join(f"{key} = {json.dumps(value)}" for key, value in noise.items()) + " }")
        path = self.folder / "bench.toml"
        devices = "".join(f'[{role}]\ndriver = "simulated"\n' for role in ("modulator", "counter", "stage"))
        path.write_text(f"{devices}[scene]\n" + "\n".join(lines) + "\n", encoding="utf-8")
        return Instrument.from_toml(path)

    def moving(self, *, from_rest: bool = False, frames: int | None = None) -> Plan:
        """Give the plan of a moving run, whose first pattern is shown when the stage is at ``HERE_MM``."""
        motion = {
            "start_mm": HERE_MM if from_rest else HERE_MM - RUN_UP_MM,
            "velocity_mm_s": 25.0,
            "acceleration_mm_s2": 50.0,
            "acquire": "from-rest" if from_rest else "cruise",
        }
        return Plan.model_validate({**self.size, "frames": frames or self.frames, "motion": motion})

    def still(self, *, rate_hz: float) -> Plan:
        """Give the plan of a static image."""
        return Plan.model_validate(
            {**self.size, "frames": self.pairs, "pattern_rate_hz": rate_hz, "scheme": "hadamard"}
        )

    def image_at(self, place_mm: float, plan: Plan, name: str, **scene: Any) -> Floats:
        """Record a static image with the stage at a place."""
        with self.bench(**scene) as bench:
            profile = self.moving().motion
            if profile is not None:
                bench.stage.move_to(place_mm, profile.profile).wait()
            return reconstruct(bench.run(plan, self.folder / f"{name}.h5", overwrite=True), None).image

    def run(self, plan: Plan, name: str, **scene: Any) -> Recording:
        """Record a run."""
        with self.bench(**scene) as bench:
            return bench.run(plan, self.folder / f"{name}.h5", overwrite=True)


def against(reference: Floats, image: Floats) -> float:
    """PSNR against the static reference, with the gain that fits best, as photon counts have no scale."""
    return psnr(np.clip(image, 0, 1), np.clip(reference, 0, 1), fit_gain=True)


def report(name: str, analysis: Analysis, reference: Floats) -> None:
    """Print what a moving run gave."""
    if analysis.reconstruction is None or analysis.trajectory is None:
        return
    end_px = analysis.trajectory.displacement_px[-1]
    print(
        f"{name}: moved {end_px[0]:.2f}, {end_px[1]:.2f} px, error {analysis.figures.displacement_mse_px2:.3f} px^2; "
        f"against the reference {against(reference, analysis.reconstruction.at_patterns):.1f} dB, "
        f"against the truth {analysis.figures.psnr_db:.1f} dB"
    )


def main(folder: Path, *, short: bool) -> None:
    """Do the day's measurements, and print a line for each."""
    day = Day(folder, short=short)

    # A picture of 10 ms has 200 times the light of one of 50 us. The lamp is warm: a drift of 1 % a second would darken it.
    slow: dict[str, Any] = {"noise": {"peak_counts": 50_000.0, "seed": 1}, "led_drift_per_s": 0.0}
    reference = day.image_at(HERE_MM, day.still(rate_hz=100.0), "reference", **slow)
    sampling = 100 * day.pairs / reference.size
    print(f"static reference: {2 * day.pairs} patterns at 100 a second, {sampling:.2f} % sampling")

    still = day.still(rate_hz=20_000.0)
    fast = [
        day.image_at(place_mm, still, f"static-{place_mm:g}-mm", noise={"seed": 2 + k})
        for k, place_mm in enumerate(PLACES_MM)
    ]
    print(f"the same at 20,000 a second: {against(reference, fast[0]):.1f} dB against the reference")
    for place_mm, image in zip(PLACES_MM[1:], fast[1:], strict=True):
        down_px, across_px = (-register(fast[0], image, upsample_factor=50)[0]).tolist()
        steps = f"{place_mm - PLACES_MM[0]:g} mm of stage are {across_px:.2f}, {down_px:.2f} px"
        print(f"{steps}: {np.hypot(across_px, down_px) / (place_mm - PLACES_MM[0]):.3f} px/mm")

    for name, from_rest in (("25 mm/s", False), ("from rest, 50 mm/s^2", True)):
        stem = "from-rest" if from_rest else "cruise"
        recording = day.run(day.moving(from_rest=from_rest), stem, noise={"seed": 5 + from_rest})
        report(name, analyse(recording), reference)

    for number, ratio in enumerate(RATIOS):
        level = background_level(day, ratio)
        beside: dict[str, Any] = {"background": "letter-T", "background_level": level}
        plan = day.moving()
        alone = day.run(plan, f"background-{ratio:.2f}", **beside, object_level=0.0, noise={"seed": 20 + number})
        both = day.run(plan, f"with-background-{ratio:.2f}", **beside, noise={"seed": 10 + number})
        report(f"R = {ratio:.2f}, background subtracted", analyse(both.minus(alone)), reference)
        report(f"R = {ratio:.2f}, from the run alone", analyse(both), reference)


def background_level(day: Day, ratio: float) -> float:
    """Find how bright the background is to be, for this ratio of the object's light to its own."""
    truth = day.run(day.moving(frames=1), "level", background="letter-T").truth
    if truth is None or truth.background is None:
        raise SystemExit("this bench does not tell what stands on it")
    return float(truth.image.sum() / truth.background.sum()) / ratio


if __name__ == "__main__":
    if len(sys.argv) not in {2, 3} or sys.argv[2:] not in ([], ["--short"]):
        raise SystemExit(__doc__)
    main(Path(sys.argv[1]), short="--short" in sys.argv)
