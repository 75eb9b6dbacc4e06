"""A lab script: move the stage to three places and record a run from each.

python examples/move_and_acquire.py bench.toml plan.toml recordings/
"""

import sys
from pathlib import Path

from instrument import Instrument, Plan, reconstruct, track


def main(bench_toml: Path, plan_toml: Path, folder: Path) -> None:
    """Record and analyse a run at each starting point."""
    folder.mkdir(parents=True, exist_ok=True)
    plan = Plan.from_toml(plan_toml)
    if plan.motion is None:
        raise SystemExit("the plan has no [motion]: nothing to move")
    with Instrument.from_toml(bench_toml) as bench:
        for start_mm in (0.0, 0.5, 1.0):
            bench.stage.move_to(start_mm, plan.motion.profile).wait()
            here = plan.model_copy(update={"motion": plan.motion.model_copy(update={"start_mm": start_mm})})
            recording = bench.run(here, folder / f"from-{start_mm:g}-mm.h5")
            motion = track(recording)
            image = reconstruct(recording, motion).image
            way_px = motion.displacement_px[-1]
            print(f"from {start_mm:g} mm: moved {way_px[0]:.2f}, {way_px[1]:.2f} px; brightest pixel {image.max():.2f}")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        raise SystemExit(__doc__)
    main(*(Path(argument) for argument in sys.argv[1:4]))
