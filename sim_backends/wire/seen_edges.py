"""The sync edges that an armed counter sees, one after another, and the photons between them."""

import numpy as np

from protocols import BenchContext, Floats, InputError, Integers
from sim_backends.bench import OpticalBench, bench_of


def photon_bench_of(context: BenchContext, device: str) -> OpticalBench:
    """Give the optical bench of a context, where it counts photons.

    Raises:
        InputError: no bench, or one whose light comes as real numbers, which no counter board can tell.
    """
    bench = bench_of(context, device)
    kind = bench.settings.noise.kind
    if kind != "poisson":
        raise InputError(
            device=device,
            saw=f"an emulated counter board on a scene with noise of kind '{kind}'",
            expected="photons: a board counts pulses, in whole numbers",
            remedy='choose noise = { kind = "poisson" } in [scene], or the simulated counter',
        )
    return bench


class SeenEdges:
    """Walks along the bench's sync edges from the moment of arming on, and never sees one twice.

    The modulator may show one projection after another; what lies between two of them is dark.
    """

    def __init__(self, bench: OpticalBench, since_s: float) -> None:
        """Start at ``since_s`` on the bench's clock; an edge at that very moment is seen."""
        self._bench = bench
        self._after_s = float(np.nextafter(since_s, -np.inf))
        self._next = 0

    def _coming(self, until_s: float) -> tuple[Floats, int, bool]:
        """Times of the edges not seen yet, index of the first, and whether it follows the last one seen."""
        if self._next:
            edges = self._bench.edges(self._next - 1, until_s)
            if len(edges) and edges.time_s[0] == self._after_s:
                return edges.time_s[1:], self._next, True
        edges = self._bench.edges(0, until_s)
        first = int(np.searchsorted(edges.time_s, self._after_s, side="right"))
        return edges.time_s[first:], first, False

    def time_of(self, n: int, until_s: float) -> float | None:
        """Time of the ``n``-th coming edge, from 1; None if it does not come until ``until_s``, as things stand."""
        time_s, _, _ = self._coming(until_s)
        return float(time_s[n - 1]) if n <= len(time_s) else None

    def take(self, until_s: float, most: int | None = None) -> tuple[Floats, Integers]:
        """See the edges up to ``until_s``, ``most`` at a time.

        Args:
            until_s: not later than the clock shows, as what lies ahead may still change.
            most: how many at most; None: all.

        Returns:
            ``(n,)`` times on the bench's clock and ``(n,)`` photons in the bin that each edge closes; the first edge of
            a projection closes none and has 0.
        """
        time_s, first, follows = self._coming(until_s)
        time_s = time_s[:most]
        n = len(time_s)
        if n == 0:
            return time_s, np.zeros(0, np.int64)
        light = self._bench.counts(first - 1, n) if follows else self._bench.counts(first, n - 1)
        photons = np.zeros(n, np.int64)
        photons[n - len(light) :] = light
        self._after_s, self._next = float(time_s[-1]), first + n
        return time_s, photons
