"""One picture held on the modulator, for looking at the bench."""

from threading import Event as Flag
from typing import Final

import numpy as np

from instrument.patterns import picture as named_picture
from protocols import (
    Bytes,
    Clock,
    InputError,
    ModulatorLimits,
    ModulatorTiming,
    PatternModulator,
    PatternSequence,
    PixelGrid,
    PlanError,
)

PICTURE_TIME_S: Final = 1.0
"""Time after which the held picture is shown anew, with a sync edge, without a gap."""

PICTURES: Final = 1000
"""So often, before the order ends: then the modulator is dark for one picture time, and starts again."""

_LOOK_S: Final = 0.1


def held(
    picture: str | Bytes, limits: ModulatorLimits, *, image_size: int = 128, superpixel: int = 2
) -> PatternSequence:
    """Give the play order that holds a picture.

    Args:
        picture: its name, or ``(image_size, image_size)`` of 0 and 1, row = y (down).
        limits: of the modulator.
        image_size: image pixels a side of the field, in the middle of the mirrors.
        superpixel: mirrors a side of one image pixel.

    Raises:
        InputError: no such picture, another shape, or values other than 0 and 1.
        PlanError: the field does not fit on the mirrors.
    """
    lit = named_picture(picture, image_size) if isinstance(picture, str) else np.asarray(picture)
    if lit.shape != (image_size, image_size) or not np.isin(lit, (0, 1)).all():
        raise InputError(
            saw=f"a picture of shape {lit.shape}",
            expected=f"({image_size}, {image_size}) of 0 and 1",
            remedy="dither it first, or name one: white, black, letter",
        )
    grid = PixelGrid(image_size=image_size, superpixel=superpixel, columns=limits.columns, rows=limits.rows)
    if not grid.fits:
        raise PlanError(
            saw=f"a field of {grid.side_mirrors} mirrors a side",
            expected=f"at most {min(limits.columns, limits.rows)}",
            remedy="lower the image size or the superpixel",
        )
    planes = np.packbits(np.stack([lit, np.zeros_like(lit)]).astype(np.uint8), axis=-1)
    pictures = max(1, min(PICTURES, limits.play_order_entries - 1))
    order = np.append(np.zeros(pictures, np.int64), 1)
    return PatternSequence(planes=planes, play_order=order, grid=grid, samples=image_size)


def hold(
    modulator: PatternModulator,
    clock: Clock,
    picture: str | Bytes,
    seconds: float | None = None,
    *,
    image_size: int = 128,
    superpixel: int = 2,
) -> None:
    """Hold a picture on the modulator, and halt it on every way out.

    Args:
        modulator: open and idle.
        clock: of the bench.
        picture: as for ``held``.
        seconds: how long; None until the caller is interrupted.
        image_size: image pixels a side of the field.
        superpixel: mirrors a side of one image pixel.

    Raises:
        InputError: no such picture, or it does not fit on the mirrors; a time that is not above 0.
        DeviceError: the modulator failed.
    """
    if seconds is not None and not seconds > 0:
        raise InputError(saw=f"{seconds:g} s", expected="a time above 0", remedy="leave it out to hold until Ctrl-C")
    limits = modulator.limits
    sequence = held(picture, limits, image_size=image_size, superpixel=superpixel)
    time_us = min(max(round(PICTURE_TIME_S * 1e6), limits.shortest_picture_time_us), limits.longest_picture_time_us)
    try:
        modulator.load(sequence, ModulatorTiming(picture_time_us=time_us))
        modulator.start()
        end_s = np.inf if seconds is None else clock.now_s() + seconds
        host = (
            Flag()
        )  # nobody sets it: without an end, the host's own time paces the looks, as a virtual clock stands still
        while (left_s := end_s - clock.now_s()) > 0:
            if np.isinf(left_s):
                host.wait(_LOOK_S)
            else:
                clock.sleep_s(min(left_s, _LOOK_S))
            if not modulator.running:
                modulator.start()
    finally:
        modulator.halt()
