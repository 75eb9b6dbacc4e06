"""Files of a simulated bench and of a plan, and the command that runs them, for what attacks or watches a run."""

import sys
from pathlib import Path
from typing import Final

_DEVICES: Final = """
[modulator]
driver = "simulated"
[counter]
driver = "simulated"
[stage]
driver = "simulated"
[scene]
object = "letter-B"
"""


def bench_text(*scene: str, realtime: bool = False, calibration: str = "") -> str:
    """Give a ``bench.toml`` of simulated devices that look at a letter.

    Args:
        scene: more lines of the ``[scene]`` table.
        realtime: whether time passes as ours does.
        calibration: name of its file; empty for none.
    """
    first = f'calibration = "{calibration}"' if calibration else ""
    return first + _DEVICES + "\n".join([*scene, f"realtime = {str(realtime).lower()}", ""])


def plan_text(frames: int, *, image_size: int, velocity_mm_s: float) -> str:
    """Give a ``plan.toml`` at 20 kHz whose object moves from the stage's zero on."""
    return f"""
scheme = "fourier-hadamard"
frames = {frames}
pattern_rate_hz = 20000
image_size = {image_size}
superpixel = 4
[motion]
start_mm = 0.0
velocity_mm_s = {velocity_mm_s}
acceleration_mm_s2 = 50.0
"""


def run_command(folder: Path, out: Path) -> list[str]:
    """Give the command line that runs ``bench.toml`` and ``plan.toml`` of a folder."""
    files = {"--bench": folder / "bench.toml", "--plan": folder / "plan.toml", "--out": out}
    return [sys.executable, "-m", "kinopix", "run", *(str(word) for pair in files.items() for word in pair)]
