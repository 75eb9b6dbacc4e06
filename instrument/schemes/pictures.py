"""Pictures by name, one after the other and from the start again: for measuring the bench itself.

A frame is one picture, and its value is the light that the picture lets through. Nothing is decoded: no position, no image.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from instrument.config import SchemePlugin, SchemeSettings
from instrument.patterns import picture
from instrument.plan import Plan
from instrument.schemes.columns import Column, in_play_order
from protocols import Bytes, Floats, InputError, PatternSequence


class PicturesSettings(SchemeSettings):
    """``[scheme]`` of pictures by name."""

    patterns_per_frame: ClassVar[int] = 1

    name: str = "pictures"
    """The scheme."""

    show: Annotated[tuple[str, ...], Field(min_length=1, max_length=10_000, strict=False)] = ("white", "black")
    """Names of the pictures, in the order in which they are shown."""

    each: Annotated[int, Field(ge=1, le=10_000)] = 1
    """How often each is shown before the next."""

    @property
    def cycle(self) -> int:
        """Pictures until the first one is shown again."""
        return len(self.show) * self.each

    def check(self, image_size: int, superpixel: int) -> None:
        """Refuse names of no picture, and pictures that are larger than the field."""
        super().check(image_size, superpixel)
        for name in dict.fromkeys(self.show):
            try:
                picture(name, image_size)
            except InputError as error:
                raise ValueError(
                    f"scheme.show has {error.saw.removeprefix('the picture ')}: {error.expected}"
                ) from None


@dataclass(frozen=True)
class Pictures:
    """Pictures and their order for one plan."""

    plan: Plan
    """The run that this scheme serves."""

    settings: PicturesSettings
    """The plan's ``[scheme]`` table."""

    name: ClassVar[str] = "pictures"

    position: ClassVar[None] = None
    """No picture measures position."""

    image_rows: ClassVar[None] = None
    """Nothing is said of the image."""

    columns: ClassVar[tuple[Column, ...]] = in_play_order(Column(role="picture"))
    """One picture a frame."""

    @property
    def light_weights(self) -> Floats:
        """The total light is that of the picture."""
        return np.ones(1)

    @property
    def fixed_patterns(self) -> Bytes:
        """``(0, m, m)``: no pattern is the same in every frame."""
        return np.zeros((0, self.plan.image_size, self.plan.image_size), np.uint8)

    @cached_property
    def _unique(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*self.settings.show, "black")))

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """Each different picture once, and the play order.

        Raises:
            PlanError: the field does not fit on the mirrors.
        """
        size = self.plan.image_size
        planes = np.stack([np.packbits(picture(name, size), axis=-1) for name in self._unique])
        place = np.array([self._unique.index(name) for name in self.settings.show])
        shown = place[np.arange(self.plan.frames) // self.settings.each % len(place)]
        guard = self._unique.index("black")
        return PatternSequence(
            planes=planes,
            play_order=np.append(shown, guard).astype(np.int64),
            grid=self.plan.grid(columns, rows),
            samples=size,
        )


plugin = SchemePlugin(
    summary="pictures by name, for measuring the bench itself", settings=PicturesSettings, make=Pictures
)
