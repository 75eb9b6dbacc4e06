"""One counter's samples as they come from NI-DAQmx: cumulative since arming, modulo 2^32."""

import numpy as np
from numpy.typing import NDArray

from drivers.ni.errors import NiFault
from drivers.ni.tasks import NiTask

LARGEST_READ = 500_000
"""Samples of one read: a gRPC message holds about 0.8 million."""

_CHUNK = 100_000


class SampledCounter:
    """A running task, the samples taken from it, and the fault that ended it."""

    def __init__(self, task: NiTask) -> None:
        """Take over a task that is configured and not started."""
        self.task = task
        self.samples_read = 0
        self.worst_backlog = 0
        self.fault: NiFault | None = None
        self._readable = True
        self._last: NDArray[np.uint32] = np.empty(0, np.uint32)

    def waiting(self) -> int:
        """Samples in the buffer now; 0 where the board answers with an error, which is kept."""
        try:
            n = self.task.available()
        except NiFault as fault:
            self.fault = fault
            return 0
        self.worst_backlog = max(self.worst_backlog, n)
        return n

    def differences(self, n: int) -> NDArray[np.uint32]:
        """Read up to ``n`` samples and give what was counted between each and the one before.

        The first sample, "arming to first edge", is only the ground that the second is measured from. Subtraction in uint32
        is right across the counter's wrap; after a cast to a signed type it would not be.
        """
        if not self._readable:
            return np.empty(0, np.uint32)
        got = self.task.read(min(n, LARGEST_READ))
        # After a failed read the next one could succeed beyond a gap, and its samples would pass for neighbours.
        self._readable = got.fault is None
        self.fault = self.fault or got.fault
        self.samples_read += len(got.samples)
        samples = np.concatenate([self._last, got.samples])
        self._last = samples[-1:]
        return np.diff(samples)

    def rest(self) -> NDArray[np.uint32]:
        """Differences of all samples that are still there: what can be saved after a fault."""
        saved = [self.differences(_CHUNK)]
        while len(saved[-1]) >= _CHUNK - 1:
            saved.append(self.differences(_CHUNK))
        return np.concatenate(saved)

    @property
    def first_sample_seen(self) -> bool:
        """Whether the sample of the first edge is in."""
        return self.samples_read > 0
