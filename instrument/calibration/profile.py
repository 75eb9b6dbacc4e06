"""Where the light is: block by block over the field, and what comes of a black picture."""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

import numpy as np

from instrument.calibration.pictures import PictureField, counts_of
from instrument.config import DeadTimeKind, Measured, ProfileSection
from instrument.measurement import Detector
from instrument.session import Instrument
from protocols import Floats, InputError

BLOCKS: Final = 8
"""Blocks along each side of the field."""

_EACH: Final = 5
_SETTLE: Final = 2
_DARK_BLOCK: Final = 0.2
_CERTAIN: Final = 5.0


@dataclass(frozen=True, eq=False)
class ProfileResult:
    """What was found."""

    section: ProfileSection
    """For the calibration file."""

    doubts: tuple[str, ...] = ()
    """What a person should know before trusting it."""


def calibrate_light(
    bench: Instrument,
    field: PictureField,
    *,
    pattern_rate_hz: float = 20_000.0,
    seconds: float = 6.0,
    dead_time_s: float | None = None,
    dead_time_kind: DeadTimeKind = "non-paralyzable",
) -> ProfileResult:
    """Measure the light of each block of the field. The object should be out of the light: what it stops counts as uneven light.

    Args:
        bench: open, with modulator and counter.
        field: of the pictures, and where the run is kept.
        pattern_rate_hz: of the runs to come.
        seconds: how long.
        dead_time_s: of the detector, as calibrated; None takes what the counter states.
        dead_time_kind: of which kind.

    Raises:
        InputError: there is no light.
        KinopixError: as ``Instrument.run``.
    """
    edges = np.linspace(0, field.image_size, BLOCKS + 1).round().astype(int)
    sides = np.diff(edges)
    show = [
        f"block:{edges[row]},{edges[column]},{sides[row]},{sides[column]}"
        for row in range(BLOCKS)
        for column in range(BLOCKS)
    ]
    half = ["white", *show, "black"]
    recording = field.record(
        bench,
        "light-profile",
        [*half, *reversed(half)],  # there and back, so that a lamp that drifts changes all by the same
        seconds=seconds,
        pattern_rate_hz=pattern_rate_hz,
        each=_EACH,
    )
    counts = counts_of(recording, _EACH, _SETTLE)
    tau_s = recording.dead_time_s if dead_time_s is None else dead_time_s
    light, variance = Detector(recording.picture_time_s, tau_s, 0.0, dead_time_kind).light(counts.mean)
    noise = variance / counts.number
    light, noise = (light + light[::-1])[: len(half)] / 2, (noise + noise[::-1])[: len(half)] / 4
    area = np.outer(sides, sides) / (sides.mean() ** 2)
    lit = (light[1:-1] - light[-1]).reshape(BLOCKS, BLOCKS) / area
    sigma = np.sqrt(noise[1:-1] + noise[-1]).reshape(BLOCKS, BLOCKS) / area
    if not lit.sum() > _CERTAIN * float(np.sqrt((sigma**2).sum())):
        raise InputError(
            device="counter",
            saw="no more light in lit blocks than in a black picture",
            expected="light",
            remedy="switch the lamp on, open the shutter, and look with kinopix count",
        )
    profile, relative = lit / lit.mean(), sigma / lit.mean()
    period_s = recording.picture_time_s
    section = ProfileSection(
        date=datetime.now(UTC),
        field_mirrors=field.image_size * field.superpixel,
        profile=_rows(profile),
        profile_sigma=_rows(relative),
        falloff=falloff_of(profile, relative),
        white_hz=max(0.0, float(light[0] - light[-1]) / period_s),
        background_hz=Measured(value=float(light[-1]) / period_s, sigma=float(noise[-1]) ** 0.5 / period_s),
    )
    return ProfileResult(section, tuple(_doubts(section, profile)))


def falloff_of(profile: Floats, sigma: Floats) -> Measured:
    """Fit c (1 - a (r / corner)^2) to the light of blocks, each at its mean of r^2, and give a.

    Args:
        profile: ``(blocks, blocks)`` light.
        sigma: its standard deviation.
    """
    blocks = len(profile)
    place = (np.arange(blocks) + 0.5) * 2 / blocks - 1
    squares = place**2 + 1 / (3 * blocks**2)  # mean of the square over a block
    radius = (squares[:, None] + squares) / 2  # 1 in the corners
    weight = 1 / np.maximum(sigma, 1e-12)
    design = np.column_stack([weight.ravel(), (-radius * weight).ravel()])
    covariance = np.linalg.inv(design.T @ design)
    level, slope = (float(part) for part in covariance @ design.T @ (profile * weight).ravel())
    gradient = np.array([-slope / level**2, 1 / level])
    scatter = (profile - level + slope * radius) * weight
    wider = max(1.0, float(np.mean(scatter**2)) * scatter.size / max(scatter.size - 2, 1)) ** 0.5
    return Measured(value=slope / level, sigma=float(gradient @ covariance @ gradient) ** 0.5 * wider)


def _rows(values: Floats) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(round(float(value), 5) for value in row) for row in values)


def _doubts(section: ProfileSection, profile: Floats) -> list[str]:
    doubts: list[str] = []
    dark = int(np.count_nonzero(profile < _DARK_BLOCK))
    if dark:
        doubts.append(
            f"{dark} of {profile.size} blocks have less than a fifth of the mean light: take the object out of the light, or "
            "light the whole field"
        )
    if section.background_hz.value > _DARK_BLOCK * section.white_hz:
        doubts.append(
            f"a black picture has {100 * section.background_hz.value / max(section.white_hz, 1e-9):.0f} % of the light of a "
            "white one: look for stray light"
        )
    return doubts
