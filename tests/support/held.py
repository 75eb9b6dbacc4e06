"""A run that stands still in its midst until the test lets it go."""

from threading import Event as Flag

import pytest

from instrument.session import Instrument
from protocols import CountBlock


class HeldCounter:
    """A counter that is held at one of its reads, and tells when it is there."""

    def __init__(self, bench: Instrument, patch: pytest.MonkeyPatch, *, at: int = 1) -> None:
        """Hold the counter of a bench at its read number ``at``, counted from 0."""
        self.there, self.go = Flag(), Flag()
        read, reads = bench.counter.read, iter(range(10**6))

        def reading(timeout_s: float) -> CountBlock:
            if next(reads) == at:
                self.there.set()
                assert self.go.wait(30)
            return read(timeout_s)

        patch.setattr(bench.counter, "read", reading)
