"""Plug-in ``ni``: an H10682 on a NI counter board.

The transport it takes instead of a local NI-DAQmx is a ``nidaqmx.GrpcSessionOptions`` with an empty session name.
"""

from drivers.h10682.counter import H10682Counter
from drivers.h10682.detector import NAME
from drivers.ni.driver import ni_counter
from drivers.ni.errors import NiFault, typed_error
from drivers.ni.questions import QUESTIONS
from drivers.ni.settings import NiSettings
from drivers.ni.tasks import open_system
from protocols import Availability, BenchContext, DriverPlugin


def open_counter(settings: NiSettings, context: BenchContext) -> H10682Counter:
    """Open the board that the settings name.

    Raises:
        DriverUnavailable: package, runtime or board missing.
        InputError: a transport that is not made for NI-DAQmx.
    """
    try:
        system = open_system(context.transport)
    except NiFault as fault:
        raise typed_error(fault, device=NAME) from fault
    return ni_counter(settings, system, context.clock, simulated=context.transport is not None)


def availability() -> Availability:
    """Look for the package and the NI-DAQmx runtime."""
    try:
        system = open_system()
        system.boards()
        version = system.version
    except NiFault as fault:
        error = typed_error(fault, device=NAME)
        return Availability(ready=False, missing=f"{error.saw}. To do: {error.remedy}")
    return Availability(ready=True, version=version)


def probe() -> tuple[str, ...]:
    """Give one line for each board that NI-DAQmx knows; none where it is not installed."""
    try:
        system = open_system()
        return tuple(f"{name}: {system.board(name).product}" for name in system.boards())
    except NiFault:
        return ()


plugin: DriverPlugin[NiSettings, H10682Counter] = DriverPlugin(
    summary="H10682 photon counter on a National Instruments board (nidaqmx)",
    settings=NiSettings,
    open=open_counter,
    availability=availability,
    probe=probe,
    questions=QUESTIONS,
)
