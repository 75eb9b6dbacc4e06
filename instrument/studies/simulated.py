"""The simulated runs of the studies: the paper's simulation, and its experiment on the simulated bench."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, Literal

import numpy as np
from pydantic import NonNegativeFloat, PositiveFloat, PositiveInt

from instrument.plan import Plan
from instrument.recording import Recording
from instrument.session import simulate
from instrument.studies.motions import PathOfTime, accelerated, along_diagonal, circle, curve
from protocols import Floats, Frozen, InputError

_FRAMES: Final = 1666
_PAIRS: Final = 4998
_SIZE: Final = 128
_BACKGROUND_SEEDS: Final = 10_000
"""Added to the seed of a run for that of its background, whose noise is another."""


class Simulated(Frozen):
    """One simulated run of 128 x 128 px, 9,996 patterns at 20,000 a second: a "B" that moves."""

    scheme: str = "fourier-hadamard"
    """Scheme of the patterns; ``hadamard`` shows 4,998 pairs, every other one 1,666 frames."""

    upsampling: PositiveInt | None = None
    """Dithering samples a pixel side; None takes the scheme's usual one."""

    superpixel: PositiveInt = 2
    """Mirrors a side of one image pixel."""

    motion: Literal["I", "II", "uniform", "accelerated", "circle"] = "II"
    """I and II take the whole run, as the paper's simulation has them; the others are as fast as they are (``motions.py``)."""

    velocity_mm_s: PositiveFloat = 25.0
    """Of the motions that are not stretched to the run."""

    part: PositiveFloat = 1.0
    """Part of the frames that are recorded, from the first one on."""

    sigma: NonNegativeFloat = 0.1
    """Noise of every lit pixel, where photons are not counted."""

    peak_counts: PositiveFloat | None = None
    """Counts of an all-lit pattern by the object alone; None counts no photons."""

    background_ratio: PositiveFloat | None = None
    """Total light of the object over that of the letters "I" and "T" that stand still beside it; None for none."""

    height_px: PositiveInt = 38
    """Height of the "B". In the simulation 38 px: its light over the noise gives the paper's displacement errors."""

    corner_px: tuple[int, int] = (9, 5)
    """Column and row of its upper left corner, on whole pixels."""

    @property
    def plan(self) -> Plan:
        """What is shown."""
        frames = round(self.part * (_PAIRS if self.scheme == "hadamard" else _FRAMES))
        finer = {} if self.upsampling is None else {"upsampling": self.upsampling}
        return Plan.model_validate(
            {"frames": frames, "superpixel": self.superpixel, "scheme": {"name": self.scheme, **finer}}
        )

    @property
    def path(self) -> PathOfTime:
        """Displacement over time."""
        whole_s = self.plan.run_time_s / self.part
        match self.motion:
            case "I":
                return curve(whole_s)
            case "II":
                return accelerated(whole_s)
            case "uniform":
                return along_diagonal(self.velocity_mm_s)
            case "accelerated":
                return along_diagonal(self.velocity_mm_s, 50.0)
            case "circle":
                return circle(self.velocity_mm_s)

    def scene(self, seed: int) -> dict[str, Any]:
        """Give the object and the noise as ``[scene]`` has them."""
        columns = round(0.78 * self.height_px)
        noise: dict[str, Any] = {"kind": "none"}
        if self.peak_counts is not None:
            noise = {"kind": "poisson", "peak_counts": self.peak_counts, "seed": seed}
        elif self.sigma:
            noise = {"kind": "pixel", "sigma": self.sigma, "seed": seed}
        left, top = self.corner_px
        return {
            "object": "letter-B",
            "object_height_px": self.height_px,
            "start_px": [left + columns / 2, top + self.height_px / 2],
            "noise": noise,
        }


def record(settings: Simulated, seed: int) -> Recording:
    """Simulate a run; with a background, the run of the background alone is to be subtracted from it.

    Raises:
        InputError: a background is asked for, and no photons: noise of every pixel does not grow with its light.
    """
    if settings.background_ratio is None:
        return simulate(settings.plan, settings.scene(seed), path=settings.path)
    if settings.peak_counts is None:
        raise InputError(
            saw="a background in a run that counts no photons",
            expected="peak_counts: the noise that a background brings is that of its photons",
            remedy="give peak_counts",
        )
    with TemporaryDirectory(prefix="kinopix-") as name:
        letters = Path(name) / "letters.npy"
        np.save(letters, letters_beside())
        scene = {**settings.scene(seed), "background": str(letters)}
        first = settings.plan.model_copy(update={"frames": 1})
        truth = simulate(first, scene, path=settings.path).truth
        if truth is None or truth.background is None:
            raise InputError(
                saw="a bench that does not tell what is on it",
                expected="the simulated bench",
                remedy="install Kinopix with its simulated bench",
            )
        even = float(truth.image.sum() / truth.background.sum())
        scene["background_level"] = even / settings.background_ratio
        recording = simulate(settings.plan, scene, path=settings.path)
        other = settings.scene(seed + _BACKGROUND_SEEDS)["noise"]
        return recording.minus(simulate(settings.plan, {**scene, "object_level": 0.0, "noise": other}))


def letters_beside() -> Floats:
    """``(128, 128)``: the letters "I" and "T", 23 px high, on both sides of the diagonal along which the object goes."""
    image = np.zeros((_SIZE, _SIZE))
    image[14:37, 92:97] = 1.0
    image[92:97, 14:32] = 1.0
    image[97:115, 20:26] = 1.0
    return image
