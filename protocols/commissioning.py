"""What is asked of a bench when a device comes to it: questions that only hardware answers, and their answers.

Each driver has a list of them, the one at the end of its how-to. A program answers those that it can: by a measurement that is
the same for every device of the kind (``measured``), or by what only this driver knows to ask (``ask``). The others
are for a person (``by_hand``).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Generic, Literal, TypeAlias, TypeVar

from pydantic import BaseModel, Field

from protocols.values import Frozen

if TYPE_CHECKING:
    from protocols.plugin import BenchContext

Measurement: TypeAlias = Literal[
    "identity", "upload", "playing", "pulses", "edges", "reads", "order", "dark", "dead time", "standing", "travel", "stop",
    "homing",
]  # fmt: skip
"""A measurement of ``kinopix probe --commission`` that fits every device of its kind:

``identity``: who the device is, what it can do, and the settings. Modulator: ``upload``, how long patterns take; ``playing``,
start, end and halt. Counter, with the modulator: ``pulses``, N pictures and their sync edges, five times in a row at the highest
rate; ``edges``, their times; ``reads``, how the counts come; ``order``, whether the bright bin is the bright picture;
``dark``, counts without light; ``dead time``, by two halves of the light. Stage: ``standing``, positions at rest;
``travel``, a move there and back; ``stop``, a stop in mid-move; ``homing``.
"""

FigureValue: TypeAlias = float | int | str | bool | tuple[float, ...] | None
"""What a figure of an answer may be."""

SettingsT = TypeVar("SettingsT", bound=BaseModel)


class Answer(Frozen):
    """What a program found out."""

    said: str
    """The finding, in a sentence."""

    figures: dict[str, FigureValue] = Field(default_factory=dict[str, FigureValue])
    """The same in numbers, by names that tell the unit."""

    doubts: tuple[str, ...] = ()
    """What differs from what Kinopix takes for granted, and what to do."""


@dataclass(frozen=True)
class BenchQuestion(Generic[SettingsT]):
    """A question that a device on a bench answers, or a person in front of it."""

    text: str
    """The question, as in the how-to."""

    measured: Measurement | None = None
    """Measurement that answers it; None: no common one does."""

    ask: "Callable[[SettingsT, BenchContext], Answer] | None" = None
    """Function that opens the device by itself and asks it what moves and shows nothing; None: there is none."""

    by_hand: str = ""
    """What a person has to look at, where no program can, or beside what a program finds."""


NO_QUESTIONS: Final[tuple[BenchQuestion[Any], ...]] = ()
"""Of a driver that has none."""
