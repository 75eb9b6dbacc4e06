# pyright: reportUnknownMemberType=false
# matplotlib leaves the type of its **kwargs open.
"""The pictures of ``method.md``, from one simulated run: ``python docs/explanation/pictures.py``."""

from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np

from kinopix import Analysis, Plan, Recording, analyse, scheme_of, simulate
from protocols import Floats

mpl.use("agg")

from matplotlib.figure import Figure

HERE: Final = Path(__file__).parent
PLAN: Final = Plan(frames=1666, image_size=64, superpixel=4)
SCENE: Final[dict[str, Any]] = {
    "object": "letter-B",
    "start_px": [16.3, 18.4],
    "noise": {"kind": "poisson", "peak_counts": 500, "seed": 1},
}
SPEED_PX_S: Final = (64.0, 52.0)
FRAME: Final = 40
BLUE, ORANGE, GREEN = "#0072b2", "#d55e00", "#009e73"  # the Okabe-Ito palette, as in all pictures


def diagonal(time_s: Floats) -> Floats:
    """Give x and y of the object in px, ``(n, 2)``."""
    return np.stack([speed * time_s for speed in SPEED_PX_S], axis=-1)


def patterns() -> Figure:
    """Draw the six patterns of one frame, as the mirrors show them."""
    sequence = scheme_of(PLAN).sequence()
    figure = Figure(figsize=(9, 1.9), layout="constrained")
    names = ("x, 0°", "x, 90°", "y, 0°", "y, 90°", "H+", "H-")
    for k, axis in enumerate(figure.subplots(1, 6)):
        packed = sequence.planes[sequence.play_order[PLAN.patterns_per_frame * FRAME + k]]
        axis.imshow(np.unpackbits(packed, axis=-1), cmap="gray", interpolation="nearest")
        axis.set_title(names[k])
        axis.set_axis_off()
    return figure


def values(recording: Recording) -> Figure:
    """Draw what the detector counts, and the circle that the values along x go round."""
    light = recording.values
    total = light[:, 4] + light[:, 5]
    figure = Figure(figsize=(9, 3), layout="constrained")
    curves, circle = figure.subplots(1, 2, width_ratios=[2.2, 1])
    time_s = np.arange(len(light)) * 6 / PLAN.pattern_rate_hz
    curves.plot(time_s, light[:, 0], color=BLUE, label="x, 0°")
    curves.plot(time_s, light[:, 1], color=ORANGE, label="x, 90°")
    curves.plot(time_s, total, color=GREEN, label="H+ and H- together: the total light")
    curves.set(xlabel="time, s", ylabel="counts", ylim=(0, None))
    curves.legend(loc="lower left", fontsize=8)
    coefficient = (2 * light[:, 0] - total) + 1j * (2 * light[:, 1] - total)
    circle.scatter(coefficient.real, coefficient.imag, c=time_s, s=2, cmap="cividis")
    circle.axhline(0, color="0.8", linewidth=0.8, zorder=0)
    circle.axvline(0, color="0.8", linewidth=0.8, zorder=0)
    circle.set_aspect("equal")
    circle.set(xlabel="2 (x, 0°) - total", ylabel="2 (x, 90°) - total")
    return figure


def images(analysis: Analysis, recording: Recording) -> Figure:
    """Draw the image with the motion ignored, with it taken back, and the truth."""
    truth = None if recording.truth is None else recording.truth.image
    shown = {
        "motion ignored": analysis.ignored,
        "motion taken back": analysis.image,
        "the object": truth,
    }
    figure = Figure(figsize=(9, 3), layout="constrained")
    for axis, (title, image) in zip(figure.subplots(1, 3), shown.items(), strict=True):
        axis.imshow(image, cmap="gray", vmin=0, interpolation="nearest")
        axis.set_title(title)
        axis.set_axis_off()
    return figure


def main() -> None:
    """Make the pictures, and say what the run came to."""
    recording = simulate(PLAN, SCENE, path=diagonal)
    analysis = analyse(recording)
    drawn = {
        "method-patterns": patterns(),
        "method-values": values(recording),
        "method-images": images(analysis, recording),
    }
    for name, figure in drawn.items():
        figure.savefig(HERE / f"{name}.png", dpi=90, pil_kwargs={"optimize": True})
    for name, text in analysis.figures.rows().items():
        print(f"{name:20s} {text}")


if __name__ == "__main__":
    main()
