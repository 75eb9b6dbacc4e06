"""Where simulated devices stand."""

from protocols import BenchContext, InputError
from sim_backends.bench import OpticalBench, bench_of


def place(context: BenchContext, device: str) -> OpticalBench:
    """Give the optical bench that a simulated device is opened on.

    Raises:
        InputError: there is none, or bench.toml names a transport, which a simulated device has no use for.
    """
    if context.transport is not None:
        raise InputError(
            device=device,
            saw="a transport for a simulated device",
            expected="none: it stands on the optical bench itself",
            remedy="take out transport, or name the driver that talks through it",
        )
    return bench_of(context, device)
