"""bench.toml and plan.toml for tests, on simulated devices."""

from pathlib import Path

from instrument.plan import MotionPlan, Plan

SMALL = Plan(frames=40, image_size=32, superpixel=4, motion=MotionPlan(velocity_mm_s=25.0, acceleration_mm_s2=50.0))
"""240 patterns on a 32 px image: quick, and all there."""


def bench_toml(folder: Path, scene: str = "", *, stage: str = "", counter: str = "", modulator: str = "") -> Path:
    """Write a bench.toml with the simulated devices; ``scene`` and the others are lines of their tables."""
    path = folder / "bench.toml"
    path.write_text(
        f'[modulator]\ndriver = "simulated"\n{modulator}\n[counter]\ndriver = "simulated"\n{counter}\n'
        f'[stage]\ndriver = "simulated"\n{stage}\n[scene]\n{scene}\n'
    )
    return path


def plan_toml(folder: Path, plan: Plan = SMALL) -> Path:
    """Write a plan as plan.toml."""
    path = folder / "plan.toml"
    lines = [
        f"{key} = {value!r}".replace("'", '"')
        for key, value in plan.model_dump(exclude={"motion", "scheme"}, exclude_none=True).items()
    ]
    lines.append("[scheme]")
    lines += [f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value}" for key, value in _scheme(plan)]
    if plan.motion is not None:
        lines.append("[motion]")
        lines += [f"{key} = {value!r}".replace("'", '"') for key, value in plan.motion.model_dump().items()]
    path.write_text("\n".join(lines) + "\n")
    return path


def _scheme(plan: Plan) -> list[tuple[str, object]]:
    return list(plan.scheme.model_dump(exclude_none=True).items())
