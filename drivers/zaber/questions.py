"""What a bench with this stage has to answer."""

from typing import Final

from drivers.zaber.driver import open_axis
from drivers.zaber.settings import ZaberSettings
from protocols import Answer, BenchContext, BenchQuestion, DeviceRefused, FigureValue

_ASKED: Final = (
    "version", "deviceid", "system.serial", "system.axiscount", "resolution", "limit.min", "limit.max", "limit.home.pos",
    "maxspeed", "limit.approach.maxspeed", "accel", "comm.alert", "comm.checksum", "pos",
)  # fmt: skip


def controller_facts(settings: ZaberSettings, context: BenchContext) -> Answer:
    """The controller's own settings, and whether its replies carry a checksum. Nothing moves or is changed."""
    axis, _ = open_axis(settings, context)
    told: dict[str, FigureValue] = {}
    try:
        for name in _ASKED:
            try:
                reply = axis.query(f"get {name}").value
            except DeviceRefused as refused:
                told[name] = f"refused ({refused.code})"
            else:
                told |= {name: reply.data, "flag": reply.warning or "--", "replies_carry_checksum": reply.checked}
    finally:
        axis.close()
    return Answer(
        said=f"device {told['deviceid']}, firmware {told['version']}, limit.max {told['limit.max']}, flag {told['flag']}, "
        f"replies {'with' if told['replies_carry_checksum'] else 'without'} checksum",
        figures=told,
    )


def stop_at_rest(settings: ZaberSettings, context: BenchContext) -> Answer:
    """The flag in the reply to ``stop`` of an axis that stands, and in the next one."""
    axis, _ = open_axis(settings, context)
    try:
        flags = [axis.query(words).value.warning or "--" for words in ("get pos", "stop", "get pos")]
    finally:
        axis.close()
    return Answer(said=f"flags before, in the reply, after: {', '.join(flags)}", figures={"flags": " ".join(flags)})


QUESTIONS: Final[tuple[BenchQuestion[ZaberSettings], ...]] = (
    BenchQuestion("Model, firmware, microstep size, `get limit.max`.", ask=controller_facts),
    BenchQuestion(
        "`maxspeed` for 1 mm/s and `accel` for 1 mm/s²: are the factors 1.6384 and 1.6384 / 10000 true for this firmware?",
        measured="travel",
        by_hand="hold 2 mm against a ruler: microsteps_per_mm",
    ),
    BenchQuestion(
        "Do replies carry a checksum when commands do? (Taken: yes; both are understood.)", ask=controller_facts
    ),
    BenchQuestion("Are alerts enabled, and is there more than one device on the line?", ask=controller_facts),
    BenchQuestion("What rules the velocity of homing, and what does `get pos` say afterwards?", measured="homing"),
    BenchQuestion(
        "WR or WH after power-up? Is the position kept?",
        measured="standing",
        by_hand="note the position, switch off and on, and run this again",
    ),
    BenchQuestion(
        "Does the reply to `stop` carry NI, and when does that flag go?",
        ask=stop_at_rest,
        by_hand="the same while it moves",
    ),
    BenchQuestion(
        "Is a move of length 0 answered IDLE at once?", by_hand="type `/1 1 move rel 0` in a terminal at 115200 baud"
    ),
)
"""In the order of the how-to."""
