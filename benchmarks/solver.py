"""One TV iteration against two products with the dense float64 matrix, timed in the same run.

``OPENBLAS_NUM_THREADS=2 python -m benchmarks.solver``, from the repository's root. The dense matrix takes 218 MB.
"""

import time
from collections.abc import Callable
from functools import partial

import numpy as np

from benchmarks.comparison import cut
from benchmarks.scenes import FRAMES, SIZE, diagonal, scene
from instrument.numerics import Weighted, total_variation
from instrument.patterns import hadamard_order
from instrument.reconstruction import Field, Region, ShiftedHadamard
from protocols import Singles


def seconds(work: Callable[[], object], repeats: int) -> float:
    """Shortest of three times of one call."""

    def once() -> float:
        started = time.perf_counter()
        for _ in range(repeats):
            work()
        return (time.perf_counter() - started) / repeats

    return min(once() for _ in range(3))


def main() -> None:
    """Print the ratios."""
    rng = np.random.default_rng(0)
    matrix = rng.standard_normal((FRAMES, SIZE * SIZE))
    image, values = rng.random(SIZE * SIZE), rng.random(FRAMES)
    dense = seconds(lambda: (matrix @ image, matrix.T @ values), 3)
    print(f"dense float64, forward and back: {dense * 1e3:.2f} ms, {matrix.nbytes / 1e6:.0f} MB")
    places = diagonal((np.arange(FRAMES, dtype=np.float64) + 0.5) * 300e-6)
    pairs = hadamard_order(SIZE, "tv", FRAMES)
    weight = np.full(FRAMES, 1 / (0.1 * np.sqrt(SIZE * SIZE)), np.float32)  # noise of I_H+ - I_H-: both half lit
    for name, region in (("full field", Region.whole(SIZE)), ("region", Region.inside(places, SIZE))):
        rows = ShiftedHadamard.single(pairs, places, Field(SIZE), region)
        whitened = Weighted(rows, weight)
        part = cut(scene("letter-B"), region).astype(np.float32).ravel()
        seen = whitened.matvec(part) + rng.standard_normal(FRAMES).astype(np.float32)

        def products(rows: ShiftedHadamard = rows, part: Singles = part, seen: Singles = seen) -> None:
            rows.matvec(part)
            rows.rmatvec(seen)

        def solve(count: int, whitened: Weighted = whitened, seen: Singles = seen) -> None:
            total_variation(whitened, seen, tolerance=0, reweightings=0, iterations=count)

        pair = seconds(products, 20)
        iteration = (seconds(partial(solve, 110), 1) - seconds(partial(solve, 10), 1)) / 100
        print(f"{name} {region.height} x {region.width}: operator {rows.nbytes / 1e6:.1f} MB")
        print(f"  forward and back {pair * 1e3:.2f} ms: {dense / pair:.0f} times faster than dense")
        print(f"  TV iteration {iteration * 1e3:.2f} ms: {dense / iteration:.0f} times faster than both dense products")


if __name__ == "__main__":
    main()
