"""The real nidaqmx client on an emulated board: the one typed place for a package without complete types."""

from collections.abc import Generator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from protocols import BenchContext
from sim_backends.bench import OpticalBench
from sim_backends.wire.ni import NiEmulatorSettings, open_emulator
from tests.sim_backends.projector import all_on, bench_with, pixel, show

nidaqmx: Any = pytest.importorskip("nidaqmx")
pytest.importorskip("grpc")
constants: Any = pytest.importorskip("nidaqmx.constants")
errors: Any = pytest.importorskip("nidaqmx.errors")
readers: Any = pytest.importorskip("nidaqmx.stream_readers")
system: Any = pytest.importorskip("nidaqmx.system")

CONTINUOUS = constants.AcquisitionType.CONTINUOUS
FINITE = constants.AcquisitionType.FINITE
PHOTONS = {"kind": "poisson", "peak_counts": 250.0, "seed": 3}

Samples = NDArray[np.uint32]


class Rig:
    """A bench, an emulated board on it, and tasks that are closed at the end."""

    def __init__(self, bench: OpticalBench, options: Any, stack: ExitStack) -> None:
        self.bench = bench
        self.options = options
        self._stack = stack

    def raw_task(self, name: str = "") -> Any:
        """An empty task."""
        task = nidaqmx.Task(name, grpc_options=self.options)
        self._stack.callback(task.close)
        return task

    def task(
        self,
        *,
        counter: str = "Dev1/ctr0",
        term: str = "/Dev1/PFI8",
        clock: str = "/Dev1/PFI9",
        mode: Any = CONTINUOUS,
        samples: int = 1000,
        initial: int = 0,
        start: bool = True,
    ) -> Any:
        """A task that counts edges on the sync, started."""
        task = self.raw_task()
        channel = task.ci_channels.add_ci_count_edges_chan(counter, initial_count=initial)
        channel.ci_count_edges_term = term
        task.timing.cfg_samp_clk_timing(20_000, source=clock, sample_mode=mode, samps_per_chan=samples)
        if start:
            task.start()
        return task

    def show(self, pictures: int, *, after_s: float = 0.001) -> None:
        """Show pictures, and the guard, some time from now."""
        planes = [all_on() if k % 2 else pixel(4, 4) for k in range(pictures)]
        show(self.bench, planes, start_s=self.bench.clock.now_s() + after_s)

    def bins(self, n: int) -> list[int]:
        """The bench's own counts."""
        counts: list[int] = self.bench.counts(0, n).tolist()
        return counts

    def calls(self) -> list[str]:
        """Names of the remote calls since this was last asked."""
        names = [name for name, _ in self.options.service.transcript]
        self.options.service.transcript.clear()
        return names


@contextmanager
def ni_rig(*, scene: dict[str, object] | None = None, **settings: object) -> Generator[Rig]:
    """Open a bench and a board."""
    bench = bench_with(**({"object": "disc", "noise": PHOTONS} | (scene or {})))
    options: Any = open_emulator(
        NiEmulatorSettings.model_validate(settings), BenchContext(clock=bench.clock, scene=bench)
    )
    with options, ExitStack() as stack:
        yield Rig(bench, options, stack)


def read(task: Any, n: int, timeout_s: float = 1.0) -> Samples:
    """Read n samples as uint32."""
    data = np.zeros(n, np.uint32)
    assert readers.CounterReader(task.in_stream).read_many_sample_uint32(data, n, timeout=timeout_s) == n
    return data


def read_failing(task: Any, n: int, timeout_s: float = 1.0) -> tuple[int, list[int]]:
    """Error code of a read that fails, and the good samples that it left in the array."""
    data = np.zeros(n, np.uint32)
    with pytest.raises(errors.DaqReadError) as raised:
        readers.CounterReader(task.in_stream).read_many_sample_uint32(data, n, timeout=timeout_s)
    return int(raised.value.error_code), data[: raised.value.samps_per_chan_read].tolist()


def code_of(action: Any, *arguments: Any, **named: Any) -> int:
    """Error code of a call that fails."""
    with pytest.raises(errors.DaqError) as raised:
        action(*arguments, **named)
    return int(raised.value.error_code)


def cumulated(bins: Sequence[int], before: int = 3) -> list[int]:
    """What the samples must be: counts since arming, at the first edge and after each bin."""
    return [int(total) for total in np.cumsum([before, *bins])]
