"""A hand-driven modulator for tests of the bench: shows pictures given as small arrays."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from protocols import Bytes, Floats, PatternSequence, PixelGrid
from sim_backends.bench import OpticalBench, Projection, SceneSettings

SIZE = 16
"""Image pixels a side: small, so that numbers can be checked by hand."""

GRID = PixelGrid(image_size=SIZE, superpixel=2, columns=64, rows=48)

PICTURE_S = 50e-6


def pixel(row: int, column: int) -> Bytes:
    """A pattern with one lit pixel."""
    plane = np.zeros((SIZE, SIZE), np.uint8)
    plane[row, column] = 1
    return plane


def all_on(samples: int = SIZE) -> Bytes:
    """The all-lit pattern."""
    return np.ones((samples, samples), np.uint8)


def sequence_of(planes: Sequence[Bytes], grid: PixelGrid = GRID) -> PatternSequence:
    """Play ``planes`` once, in order, and the dark guard picture."""
    stack = np.stack([*planes, np.zeros_like(planes[0])])
    return PatternSequence(np.packbits(stack, axis=-1), np.arange(len(stack)), grid, len(planes[0]))


def show(
    bench: OpticalBench, planes: Sequence[Bytes], *, times: int = 1, sync_delay_s: float = 0.0, start_s: float = 0.0
) -> None:
    """Show ``planes`` so many times and the guard picture, ``PICTURE_S`` each."""
    sequence = sequence_of(planes)
    order = np.append(np.tile(sequence.play_order[:-1], times), sequence.play_order[-1])
    bench.show(Projection(start_s, PICTURE_S, sequence.mirror_plane, order, sync_delay_s))


def values(bench: OpticalBench, planes: Sequence[Bytes]) -> list[float]:
    """Show ``planes`` from time 0 and give what is counted."""
    show(bench, planes)
    return [float(value) for value in bench.counts(0, len(planes))]


def bench_with(folder: Path = Path(), /, **scene: object) -> OpticalBench:
    """Build a bench on the small grid from the keys of a ``[scene]`` table."""
    bench = OpticalBench(SceneSettings.model_validate(scene), folder)
    bench.use_grid(GRID)
    return bench


def save(folder: Path, cells: Floats, name: str = "object.npy") -> str:
    """Write an object file and give its name."""
    np.save(folder / name, cells)
    return name


def dot(row: int, column: int, samples: int = SIZE) -> Floats:
    """An object of which one cell is transparent."""
    cells = np.zeros((samples, samples))
    cells[row, column] = 1.0
    return cells
