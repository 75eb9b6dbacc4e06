"""``kinopix calibrate detector``, ``mirrors`` and ``light``: what pictures of known parts tell of the bench itself."""

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias, TypedDict

import typer

from instrument.cli.calibrate import CalibrationOption, say_written, target
from instrument.cli.options import (
    BenchOption,
    ImageSizeOption,
    JsonOption,
    OverwriteOption,
    SuperpixelOption,
    print_json,
    refuse_no_amount,
)

if TYPE_CHECKING:
    from instrument.calibration import PictureField
    from instrument.config import BenchConfig, DeadTimeKind, DetectorSection, Measured, Section, SectionName
    from instrument.session import Event, Instrument

ROLES: Final = ("modulator", "counter")
"""Roles that these measurements need: the stage may be missing."""

RecordingsOption: TypeAlias = Annotated[
    Path | None,
    typer.Option("--recordings", help="Folder for the recordings; without it calibration-runs/<date>-<time>."),
]
RateOption: TypeAlias = Annotated[
    float,
    typer.Option("--pattern-rate-hz", help="Pictures a second of the runs to come, in which leak and light are told."),
]


class DeadTime(TypedDict):
    """Arguments of a calibration that is told of the dead time."""

    dead_time_s: float | None
    dead_time_kind: "DeadTimeKind"


def detector(
    bench: BenchOption,
    out: CalibrationOption = None,
    recordings: RecordingsOption = None,
    pattern_rate_hz: RateOption = 20_000.0,
    counts: Annotated[float, typer.Option("--counts", help="Counts wanted in a white picture.")] = 250.0,
    longest: Annotated[
        float, typer.Option("--longest", help="Seconds of the ladder at most; it ends when the kind is certain.")
    ] = 120.0,
    dark: Annotated[float, typer.Option("--dark", help="Seconds of the black picture.")] = 5.0,
    shutter_closed: Annotated[
        bool, typer.Option("--shutter-closed", help="No light comes to the detector: measure its dark counts alone.")
    ] = False,
    image_size: ImageSizeOption = 128,
    superpixel: SuperpixelOption = 2,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Measure dark counts, dead time and its kind, linear limit and flicker; recommend a filter for the counts wanted.

    Take the object out of the light: borders of mirrors within it lose other light than the mean, which in weak light looks
    like dead time of the other kind. Dark counts come from a black picture. Close the shutter and say --shutter-closed to tell
    them from stray light; keep the head in darkness for half an hour before, as its maker does.
    """
    from instrument.calibration import calibrate_detector
    from instrument.views import OUT, figures_table

    refuse_no_amount(pattern_rate_hz=pattern_rate_hz, counts=counts, longest=longest, dark=dark)
    with opened(bench, recordings, image_size, superpixel, overwrite) as (config, instrument, field):
        found = calibrate_detector(
            instrument,
            field,
            pattern_rate_hz=pattern_rate_hz,
            dark_s=dark,
            longest_s=longest,
            shutter_closed=shutter_closed,
        )
        section = found.section
        if shutter_closed and (old := known_detector(config, out)) is not None:
            kept = section.model_dump(include={"date", "dark_rate_hz", "shutter_closed"})
            section = old.model_copy(update={**kept, "dark_rate_hz": section.dark_rate_hz})
        write(config, out, "detector", section, instrument)
    density = None if shutter_closed else found.filter_density(counts)
    if as_json:
        print_json(
            {
                **section.model_dump(mode="json"),
                "white_counts": found.white_counts,
                "filter_density": density,
                "doubts": list(found.doubts),
            }
        )
        return
    rows = {"dark counts": f"{section.dark_rate_hz} /s" + ("" if shutter_closed else ", stray light among them")}
    if not shutter_closed:
        kind = section.dead_time_kind or "of which kind is not certain"
        tau_s = section.dead_time_s
        rows["dead time"] = "not seen: the counter's own is taken" if tau_s is None else f"{_in_ns(tau_s)}, {kind}"
        limit_hz = section.linear_limit_hz
        rows["linear limit"] = "none seen" if limit_hz is None else f"{limit_hz:,.0f} counts/s (a tenth is lost)"
        rows["white picture"] = f"{found.white_counts:.1f} counts at {pattern_rate_hz:g} pictures/s"
        rows[f"for {counts:g} counts"] = _advice(found.filter_density(counts))
        for k, line in enumerate(section.flicker):
            rows[f"lamp {k + 1}"] = f"{line.frequency_hz:.1f} Hz, {100 * line.amplitude:.2f} %: {line.name}"
    OUT.print(figures_table("Detector", rows))
    _end(config, out, found.doubts)


def mirrors(
    bench: BenchOption,
    out: CalibrationOption = None,
    recordings: RecordingsOption = None,
    pattern_rate_hz: RateOption = 20_000.0,
    seconds: Annotated[float, typer.Option("--seconds", help="Seconds of each of the two runs.")] = 4.0,
    image_size: ImageSizeOption = 128,
    superpixel: SuperpixelOption = 2,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Measure what is left of a picture in the next one, what borders of mirrors lose, and when light comes after its edge."""
    from instrument.calibration import calibrate_mirrors
    from instrument.views import OUT, figures_table

    refuse_no_amount(pattern_rate_hz=pattern_rate_hz, seconds=seconds)
    with opened(bench, recordings, image_size, superpixel, overwrite) as (config, instrument, field):
        found = calibrate_mirrors(
            instrument, field, pattern_rate_hz=pattern_rate_hz, seconds=seconds, **dead_time(config, out)
        )
        write(config, out, "mirrors", found.section, instrument)
    section = found.section
    if as_json:
        print_json({**section.model_dump(mode="json"), "doubts": list(found.doubts)})
        return
    rows = {
        "leak": f"{section.leak} of the picture before, at {section.picture_time_s * 1e6:g} us",
        "early light": f"{section.early} of the picture after",
        "edge loss": f"{section.edge_loss} of a mirror's light at each dark side",
        "light after its edge": f"{section.late_s.value * 1e6:.3f} +- {section.late_s.sigma * 1e6:.2g} us",
    }
    OUT.print(figures_table("Mirrors", rows))
    _end(config, out, found.doubts)


def light(
    bench: BenchOption,
    out: CalibrationOption = None,
    recordings: RecordingsOption = None,
    pattern_rate_hz: RateOption = 20_000.0,
    seconds: Annotated[float, typer.Option("--seconds", help="Seconds of the run.")] = 6.0,
    image_size: ImageSizeOption = 128,
    superpixel: SuperpixelOption = 2,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Measure the illumination of the field in 8 x 8 blocks, and the light of a black picture. Take the object out before."""
    from instrument.calibration import calibrate_light
    from instrument.views import OUT, figures_table

    refuse_no_amount(pattern_rate_hz=pattern_rate_hz, seconds=seconds)
    with opened(bench, recordings, image_size, superpixel, overwrite) as (config, instrument, field):
        found = calibrate_light(
            instrument, field, pattern_rate_hz=pattern_rate_hz, seconds=seconds, **dead_time(config, out)
        )
        write(config, out, "light", found.section, instrument)
    section = found.section
    if as_json:
        print_json({**section.model_dump(mode="json"), "doubts": list(found.doubts)})
        return
    rows = {f"row {k + 1}": " ".join(f"{value:5.2f}" for value in row) for k, row in enumerate(section.profile)}
    rows |= {
        "falloff": f"{section.falloff} of the light is missing in the corners",
        "white picture": f"{section.white_hz:,.0f} photons/s",
        "background": f"{section.background_hz} photons and dark counts/s",
    }
    OUT.print(figures_table("Light", rows))
    _end(config, out, found.doubts)


@contextmanager
def opened(
    bench: Path,
    recordings: Path | None,
    image_size: int,
    superpixel: int,
    overwrite: bool,
    roles: tuple[str, ...] = ROLES,
) -> "Generator[tuple[BenchConfig, Instrument, PictureField]]":
    """Open the devices of a calibration, with a line that tells which run goes on."""
    from datetime import UTC, datetime

    from instrument.calibration import PictureField
    from instrument.cli.libraries import tell_libraries
    from instrument.config import load_bench
    from instrument.session import Instrument, PhaseEvent
    from instrument.views import progress

    tell_libraries(bench, roles)
    config = load_bench(bench, roles, calibrated=False)
    with Instrument.from_config(config, only=roles) as instrument, progress() as bars:
        task = bars.add_task("", total=None)

        def tell(event: "Event") -> None:
            if isinstance(event, PhaseEvent):
                bars.update(task, description=event.phase)

        folder = recordings or Path("calibration-runs") / f"{datetime.now(UTC):%Y%m%d-%H%M%S}"
        yield config, instrument, PictureField(folder, image_size, superpixel, overwrite, (tell,))


def write(
    config: "BenchConfig", out: Path | None, name: "SectionName", section: "Section", instrument: "Instrument"
) -> None:
    """Write a section into the calibration file of the bench."""
    from instrument.config import updated_calibration

    updated_calibration(target(config, out), name, section, instrument.devices.identities(), config.magnification)


def known_detector(config: "BenchConfig", out: Path | None) -> "DetectorSection | None":
    """The detector as it was calibrated before; None where it was not."""
    from instrument.config import read_calibration

    path = target(config, out)
    return read_calibration(path).detector if path.exists() else None


def dead_time(config: "BenchConfig", out: Path | None) -> "DeadTime":
    """The dead time that was calibrated, as arguments; what the counter states where it was not."""
    detector = known_detector(config, out)
    if detector is None or detector.dead_time_s is None:
        return {"dead_time_s": None, "dead_time_kind": config.light.dead_time_kind}
    return {
        "dead_time_s": detector.dead_time_s.value,
        "dead_time_kind": detector.dead_time_kind or config.light.dead_time_kind,
    }


def _in_ns(time_s: "Measured") -> str:
    return f"{time_s.value * 1e9:.2f} +- {time_s.sigma * 1e9:.2f} ns"


def _advice(density: float) -> str:
    if abs(density) < 0.02:
        return "the light is right"
    if density > 0:
        return f"add a filter of optical density {density:.2f}"
    return f"take out a filter of optical density {-density:.2f}, or make the lamp {10**-density:.1f} times as bright"


def _end(config: "BenchConfig", out: Path | None, doubts: tuple[str, ...]) -> None:
    from instrument.views import warn

    for doubt in doubts:
        warn(doubt)
    say_written(config, target(config, out))
