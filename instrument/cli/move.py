"""``kinopix move``: the stage alone."""

from typing import TYPE_CHECKING, Annotated, Final

import typer

from instrument.cli.options import BenchOption, JsonOption, print_json

if TYPE_CHECKING:
    from instrument.session import Instrument
    from protocols import LinearStage, Motion, MotionProfile

_LOOK_S: Final = 0.1
"""Time between two looks at the stage while it moves."""


def move(
    target: Annotated[
        str,
        typer.Argument(
            metavar="TARGET", help="Millimetres (12.5), a distance with its sign (+1.5, +-1.5), home, where, or stop."
        ),
    ],
    bench: BenchOption,
    velocity: Annotated[
        float | None, typer.Option("--velocity", help="mm/s; without it 10, or what the stage can do.")
    ] = None,
    acceleration: Annotated[
        float | None, typer.Option("--acceleration", help="mm/s^2; without it 50, or what the stage can do.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Move the stage, look for its origin, ask where it is, or stop it. No other device is touched.

    The stage is stopped, and seen to stand, on every way out. A target outside of the travel is refused before anything moves.
    """
    from instrument.cli.libraries import tell_libraries
    from instrument.session import Instrument
    from instrument.views import say, warn

    wanted = _wanted(target)
    tell_libraries(bench, ("stage",))
    with Instrument.from_toml(bench, only=("stage",)) as instrument:
        stage = instrument.stage
        if not stage.homed and target != "home":
            warn("the stage does not know its origin: its millimetres count from where it was switched on")
        if target == "where":
            pass
        elif target == "stop":
            stage.stop()
        elif target == "home":
            _follow(instrument, stage.home())
        else:
            assert wanted is not None  # noqa: S101 - _wanted gives a number for all other targets
            relative, millimetres = wanted
            profile = _profile(stage, velocity, acceleration)
            start = stage.move_by if relative else stage.move_to
            _follow(instrument, start(millimetres, profile))
        if as_json:
            print_json(_figures(stage))
        else:
            say(_where(stage))


def _wanted(target: str) -> tuple[bool, float] | None:
    """Whether a target is a distance, and its millimetres; None for one in words."""
    from math import isfinite

    from protocols import InputError

    if target in {"home", "where", "stop"}:
        return None
    try:
        millimetres = float(target.removeprefix("+"))
    except ValueError:
        millimetres = float("nan")
    if not isfinite(millimetres):
        raise InputError(
            saw=f"the target {target!r}",
            expected="millimetres (12.5), a distance (+1.5, +-1.5), home, where, or stop",
            remedy="correct it",
        )
    return target.startswith("+"), millimetres


def _profile(stage: "LinearStage", velocity: float | None, acceleration: float | None) -> "MotionProfile":
    """The profile asked for, gentle in what was not; a stage refuses what it cannot do."""
    from protocols import InputError

    for name, value in (("velocity", velocity), ("acceleration", acceleration)):
        if value is not None and not 0 < value < float("inf"):
            raise InputError(saw=f"--{name} {value:g}", expected="a number above 0", remedy="correct it")
    asked = {"velocity_mm_s": velocity, "acceleration_mm_s2": acceleration}
    given = {name: value for name, value in asked.items() if value is not None}
    return stage.limits.gentle_profile.model_copy(update=given)


def _follow(instrument: "Instrument", motion: "Motion") -> None:
    """Tell where the stage is until it stands."""
    from rich.live import Live

    from instrument.views import ERR, plain

    clock, stage = instrument.devices.clock, instrument.stage
    with Live(console=ERR, transient=True) as live:
        while not motion.done and clock.now_s() < stage.stands_by_s:
            live.update(plain(_where(stage)))
            clock.sleep_s(_LOOK_S)
    motion.wait()


def _figures(stage: "LinearStage") -> dict[str, object]:
    """Where the stage is, for programs."""
    position = stage.position()
    return {
        "stage": stage.identity.name,
        "position_mm": position.reported_mm,
        "commanded_mm": position.commanded_mm,
        "predicted": position.predicted,
        "homed": stage.homed,
        "travel_mm": list(stage.limits.travel_mm),
    }


def _where(stage: "LinearStage") -> str:
    """Where the stage is, in words."""
    position = stage.position()
    how = "predicted: the controller is mute while it moves" if position.predicted else "as the controller tells"
    low, high = stage.limits.travel_mm
    return f"{stage.identity.name}: {position.reported_mm:.4f} mm ({how}), travel {low:g} to {high:g} mm"
