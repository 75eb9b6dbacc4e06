"""What a bench with a counter board has to answer."""

from typing import Final

from drivers.h10682.detector import NAME
from drivers.h10682.questions import HEAD_QUESTIONS
from drivers.ni.errors import NiFault, typed_error
from drivers.ni.family import dead_time_s, family_of
from drivers.ni.settings import NiSettings
from drivers.ni.tasks import open_system
from protocols import Answer, BenchContext, BenchQuestion


def board_facts(settings: NiSettings, context: BenchContext) -> Answer:
    """What the board tells of itself, and what follows from its family."""
    try:
        system = open_system(context.transport)
        board, version = system.board(settings.device), system.version
    except NiFault as fault:
        raise typed_error(fault, device=NAME) from fault
    family = family_of(board.product)
    dead_s = dead_time_s(board.max_timebase_hz)
    return Answer(
        said=f"{board.product}, {'family not known' if family is None else family.name}, {version}; fastest timebase "
        f"{board.max_timebase_hz / 1e6:g} MHz, so pulses within {dead_s * 1e9:.3g} ns merge",
        figures={
            "product": board.product,
            "family": "not known" if family is None else family.name,
            "version": version,
            "counters": " ".join(board.counters),
            "counter_bits": board.counter_bits,
            "sample_clocked_counting": board.sample_clocked_counting,
            "max_timebase_hz": board.max_timebase_hz,
            "counter_dead_time_s": dead_s,
            "sync_filters_s": () if family is None else family.filters_s,
        },
        doubts=()
        if family
        else ("a board of neither X nor M series: hold its filters and its dead time against its manual",),
    )


QUESTIONS: Final[tuple[BenchQuestion[NiSettings], ...]] = (
    BenchQuestion(
        "Does the NI board count pulses of 10 ns and 2.2 V? (Check 6.)",
        measured="dark",
        by_hand="a known lamp, or a pulse generator: check 6",
    ),
    BenchQuestion(
        "Which pulse pairs does the counter merge? (`counter_dead_time_s`: four periods of the board's fastest timebase.)",
        measured="dead time",
    ),
    BenchQuestion(
        "Do X-series boards need duplicate-count prevention? (`prevent_duplicates = true`.)", measured="pulses"
    ),
    BenchQuestion(
        'Name and rate of the timebase? (`timebase = "100MHzTimebase"`, `timebase_hz = 100e6`.)', measured="edges"
    ),
    BenchQuestion("Family of the board, and filter widths of the sync line? (`sync_filter_s`, off.)", ask=board_facts),
    *HEAD_QUESTIONS,
)
"""In the order of the how-to."""
