"""What a bench with an analogue detector has to answer."""

from typing import Final

from drivers.h10682.detector import NAME
from drivers.ni.analog.settings import NiAnalogSettings
from drivers.ni.analog.tasks import AnalogSystem
from drivers.ni.errors import NiFault, typed_error
from protocols import Answer, BenchContext, BenchQuestion


def board_facts(settings: NiAnalogSettings, context: BenchContext) -> Answer:
    """What the board tells of its analogue inputs."""
    try:
        board = AnalogSystem(context.transport).board(settings.device)
    except NiFault as fault:
        raise typed_error(fault, device=NAME) from fault
    return Answer(
        said=f"{board.product}, at most {board.highest_rate_hz:g} samples a second for each of two inputs",
        figures={"product": board.product, "highest_rate_hz": board.highest_rate_hz},
    )


QUESTIONS: Final[tuple[BenchQuestion[NiAnalogSettings], ...]] = (
    BenchQuestion(
        "Board, its highest rate with two inputs, sampled at once or one after another?",
        ask=board_facts,
        by_hand="at once or one after another: the board's manual",
    ),
    BenchQuestion("Noise of a sample in darkness; is it white?", measured="dark"),
    BenchQuestion(
        "Settling of the preamplifier: what does step 3 give?", measured="order", by_hand="step 3 of the how-to"
    ),
    BenchQuestion("Is the sync seen on every picture, and how many samples is it high?", measured="pulses"),
    BenchQuestion(
        "Linearity: are two half-lit pictures that complement each other together the all-lit one?",
        measured="dead time",
    ),
)
"""In the order of the how-to."""
