"""Many jobs carried out: here, on processes of this computer, or on a cluster; the same to the bit wherever it is."""

from instrument.workers.carry_out import Where, carry_out
from instrument.workers.job import Failure, Job, OnJob
from instrument.workers.missing import Progress, do_missing
from instrument.workers.path_map import PathMap

__all__ = ["Failure", "Job", "OnJob", "PathMap", "Progress", "Where", "carry_out", "do_missing"]
