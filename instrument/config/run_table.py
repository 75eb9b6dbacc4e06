"""The ``[run]`` table of plan.toml: what people want to know of a run, and no device does."""

import unicodedata
from typing import Annotated, Final, TypeAlias

from pydantic import AfterValidator, Field

from protocols import Frozen

_LAYOUT: Final = "\n\t"


def _readable(text: str, allowed: str = "") -> str:
    """Refuse characters that no line of text has: control characters, and halves of others."""
    strange = {c for c in text if unicodedata.category(c) in {"Cc", "Cs"} and c not in allowed}
    if strange:
        message = f"expected text that can be read, saw the characters {', '.join(sorted(map(ascii, strange)))}"
        raise ValueError(message)
    return text


def _readable_lines(text: str) -> str:
    return _readable(text, _LAYOUT)


Line: TypeAlias = Annotated[str, Field(max_length=200), AfterValidator(_readable)]
"""One line of text."""

Lines: TypeAlias = Annotated[str, Field(max_length=10_000), AfterValidator(_readable_lines)]
"""Some lines of text."""


class RunTable(Frozen):
    """What a run is about. It is kept in the recording, and changes nothing of what is shown, moved or computed."""

    title: Line = ""
    """One line for people; the recording's file name where it is empty. NeXus: `title` of the entry."""

    user: Line = ""
    """Who records. NeXus: `name` of an `NXuser`."""

    sample: Line = ""
    """What is looked at. NeXus: `name` of an `NXsample`."""

    notes: Lines = ""
    """Whatever else is worth knowing, in as many lines as it takes. NeXus: `data` of an `NXnote`."""

    @property
    def in_words(self) -> str:
        """Give title, sample and user in one line; empty where there is none of them."""
        named = (self.title, self.sample and f"sample {self.sample}", self.user and f"by {self.user}")
        return ", ".join(words for words in named if words)
