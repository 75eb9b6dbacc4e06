"""What a bench with this stage has to answer."""

from typing import Final

from drivers.grbl.codec import SETTINGS, Setting
from drivers.grbl.driver import open_link
from drivers.grbl.settings import GrblSettings
from protocols import Answer, BenchContext, BenchQuestion, FigureValue


def controller_facts(settings: GrblSettings, context: BenchContext) -> Answer:
    """Version and all ``$`` settings. Nothing moves or is changed."""
    link, version = open_link(settings, context)
    try:
        stored = [event for event in link.command(SETTINGS) if isinstance(event, Setting)]
    finally:
        link.wire.close()
    figures: dict[str, FigureValue] = {"version": version, **{f"${event.number}": event.value for event in stored}}
    return Answer(said=f"{version}, {len(stored)} settings", figures=figures)


def start(settings: GrblSettings, context: BenchContext) -> Answer:
    """How long it takes from opening the port to the first answer, and whether it started anew."""
    began_s = context.clock.now_s()
    link, _ = open_link(settings, context)
    took_s = context.clock.now_s() - began_s
    try:
        greeted = link.greeted
    finally:
        link.wire.close()
    return Answer(
        said=f"first answer {took_s:.3g} s after the port was opened; it {'started anew' if greeted else 'did not start anew'}",
        figures={"first_answer_s": took_s, "reset_by_opening": greeted},
    )


QUESTIONS: Final[tuple[BenchQuestion[GrblSettings], ...]] = (
    BenchQuestion("`$$` and `$I`; GRBL 1.1 or a descendant (grblHAL, FluidNC)?", ask=controller_facts),
    BenchQuestion("Does opening the port reset it, and how long does it take?", ask=start),
    BenchQuestion(
        "Limit switches fitted? Position after homing?", measured="homing", by_hand="press each switch by hand"
    ),
    BenchQuestion("Is the jog cancel obeyed within v / a?", measured="stop"),
    BenchQuestion(
        "Are status lines answered 10 times a second while it jogs, and after how many milliseconds?", measured="travel"
    ),
    BenchQuestion(
        "Highest velocity and acceleration without lost steps.",
        by_hand="a mark on the carriage; raise both until it is not met again after ten moves there and back",
    ),
    BenchQuestion("Does `$120` take a new value at once?", measured="travel"),
)
"""In the order of the how-to."""
