"""H10682 on a National Instruments counter board.

Two buffered edge counts share the modulator's sync as sample clock: one counts photons, the other an onboard timebase, so
every sync edge has a hardware time. Both run continuously, so surplus edges are seen. Fact sheet h10682-daq, sections 2, 4.
"""

from drivers.h10682.counter import H10682Counter
from drivers.h10682.detector import NAME, counter_limits
from drivers.ni.errors import NiFault, typed_error
from drivers.ni.family import check_filter, dead_time_s
from drivers.ni.run import NiRun
from drivers.ni.settings import NiSettings
from drivers.ni.tasks import NiBoardFacts, NiSystem
from protocols import Clock, CounterLimits, DeviceIdentity, DeviceRefused, InputError


def ni_counter(settings: NiSettings, system: NiSystem, clock: Clock, *, simulated: bool = False) -> H10682Counter:
    """Ask the board who it is and whether it can count on an external clock, and give the counter on it.

    The board's two counters are reserved, configured and started by ``arm``, and freed by ``disarm``.

    Raises:
        DriverUnavailable: no such board.
        DeviceRefused: the board cannot do buffered edge counting.
        InputError: a counter or a sync filter that the board does not have.
    """
    try:
        board = system.board(settings.device)
        version = system.version
    except NiFault as fault:
        raise typed_error(fault, device=NAME) from fault
    _check_board(board)
    _check_counters(settings, board)
    check_filter(board.product, settings.sync_filter_s, NAME)
    identity = DeviceIdentity(
        name=NAME,
        vendor="NI",
        model=f"{board.product} with {settings.head.model}",
        serial=board.serial,
        driver=version,
        simulated=simulated or board.simulated,
    )
    return H10682Counter(identity, _limits(settings, board), lambda run: NiRun(run, settings, system, clock))


def _limits(settings: NiSettings, board: NiBoardFacts) -> CounterLimits:
    told_s = settings.counter_dead_time_s
    return counter_limits(
        settings.head,
        counter_dead_time_s=dead_time_s(board.max_timebase_hz) if told_s is None else told_s,
        max_sync_rate_hz=settings.max_sync_rate_hz,
        edge_time_resolution_s=1 / settings.timebase_hz if settings.edge_counter else None,
    )


def _check_counters(settings: NiSettings, board: NiBoardFacts) -> None:
    wanted = [settings.counter] if settings.edge_counter is None else [settings.counter, settings.edge_counter]
    missing = [name for name in wanted if name not in board.counters]
    if missing:
        raise InputError(
            device=NAME,
            saw=f"{', '.join(missing)} in bench.toml",
            expected=f"counters of a {board.product}: {', '.join(board.counters) or 'it has none'}",
            remedy="correct counter and edge_counter in bench.toml; without a second counter, edge_counter cannot be set",
        )


def _check_board(board: NiBoardFacts) -> None:
    if not board.sample_clocked_counting or board.counter_bits != 32:
        raise DeviceRefused(
            NAME,
            code="ci_samp_clk_supported, ci_max_size",
            saw=f"a {board.product} with {board.counter_bits}-bit counters, "
            + ("sampled" if board.sample_clocked_counting else "which cannot be sampled")
            + " by a clock",
            expected="32-bit counters with a sample clock",
            remedy="use a board that has them, such as one of the X series; a USB-6002 or USB-6008 counts only when it is asked",
        )
