"""Entry point ``kinopix.counters``: ``ni-analog``.

The transport it takes instead of a local NI-DAQmx is a ``nidaqmx.GrpcSessionOptions`` with an empty session name.
"""

from drivers.h10682.counter import H10682Counter
from drivers.h10682.detector import NAME
from drivers.ni.analog.questions import QUESTIONS
from drivers.ni.analog.run import AnalogRun
from drivers.ni.analog.settings import NiAnalogSettings
from drivers.ni.analog.tasks import AnalogSystem
from drivers.ni.errors import NiFault, typed_error
from drivers.ni.plugin import availability, probe
from protocols import BenchContext, CounterLimits, DeviceIdentity, DriverPlugin, InputError

_NO_LIMIT_HZ = 1e15
"""Light that is not counted has no highest count rate; what limits it is the range, and an overload is told for each bin."""


def open_analog(settings: NiAnalogSettings, context: BenchContext) -> H10682Counter:
    """Open the board that the settings name. The inputs are reserved by ``arm`` and freed by ``disarm``.

    Raises:
        DriverUnavailable: package, runtime or board missing.
        InputError: a transport that is not made for NI-DAQmx, or more samples a second than the board takes.
    """
    try:
        system = AnalogSystem(context.transport)
        board = system.board(settings.device)
    except NiFault as fault:
        raise typed_error(fault, device=NAME) from fault
    if settings.sample_rate_hz > board.highest_rate_hz:
        raise InputError(
            device=NAME,
            saw=f"sample_rate_hz = {settings.sample_rate_hz:g}",
            expected=f"at most {board.highest_rate_hz:g} for each of two inputs of a {board.product}",
            remedy="lower sample_rate_hz in the [counter] table of bench.toml",
        )
    identity = DeviceIdentity(
        name=NAME,
        vendor="NI",
        model=f"{settings.detector} on {board.product}",
        driver="ni-analog (nidaqmx)",
        simulated=board.simulated or context.transport is not None,
    )
    limits = CounterLimits(
        max_sync_rate_hz=settings.sample_rate_hz / (settings.settle_samples + settings.least_samples),
        max_count_rate_hz=_NO_LIMIT_HZ,
        dead_time_s=0.0,
        edge_time_resolution_s=1 / settings.sample_rate_hz,
    )
    return H10682Counter(identity, limits, lambda run: AnalogRun(run, settings, system, context.clock))


plugin: DriverPlugin[NiAnalogSettings, H10682Counter] = DriverPlugin(
    summary="analogue detector on National Instruments analogue input, integrated between sync edges (nidaqmx)",
    settings=NiAnalogSettings,
    open=open_analog,
    availability=availability,
    probe=probe,
    questions=QUESTIONS,
)
