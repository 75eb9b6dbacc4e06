"""What the counts of a run say of it that nobody asked: one frozen sentence for each thing found."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

FindingKind: TypeAlias = Literal[
    "impossible counts",
    "stuck counts",
    "no light",
    "shifted patterns",
    "wild counts",
    "wiring",
    "contradiction",
    "lamp",
    "comes into the field",
    "leaves the field",
    "passes by",
    "changes shape",
]


@dataclass(frozen=True)
class Finding:
    """One thing that the counts show."""

    kind: FindingKind
    """What it is about."""

    frames: tuple[int, ...]
    """Frames that it concerns, in ascending order; for wiring, those that show it."""

    text: str
    """A few words for a table."""

    sentence: str
    """What was seen, what was done about it, and what to look at."""
