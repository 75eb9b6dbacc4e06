"""All devices of a bench, one after another: asked, measured with consent, and reported."""

import platform
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias

from instrument.commissioning.counter import dark, dead_time, order, pulses_edges_reads
from instrument.commissioning.modulator import playing, upload
from instrument.commissioning.report import AskedQuestion, CommissioningReport, DeviceReport, Finding
from instrument.commissioning.stage import Stretch, homing, standing, stop, travel
from instrument.config import BenchConfig, load_bench
from instrument.roles import COUNTER, MODULATOR, STAGE, RoleName
from instrument.session import Instrument, Probed, probe_bench, surroundings
from protocols import Answer, BenchQuestion, KinopixError, SafeStateFailed

Effect: TypeAlias = Literal["light", "motion", "homing"]
"""What a measurement does: it shows pictures, moves the stage a little, or sends it to its origin."""

Consent: TypeAlias = Callable[[Effect, str], bool]
"""Asked before anything is shown or moves, with a sentence that says what; False leaves it out."""

_Found: TypeAlias = dict[str, Finding]

_AT_FULL_RATE: Final = ("pulses", "edges", "reads")
"""What the same runs at the highest rate say of the counter."""

_NO_DEVICE: Final = Finding(state="not asked", answer=Answer(said="a device that it needs is missing, or did not open"))


def commission(
    path: str | Path, consent: Consent, *, only: RoleName | None = None, tell: Callable[[str], object] = lambda _: None
) -> CommissioningReport:
    """Ask and measure everything that a program can find out about the devices of a bench.

    Every device is opened, asked and closed by itself; the counter is measured with the modulator in front of it. An error of
    a device is part of the report, and the others are measured all the same. The stage is brought back to where it stood.

    Args:
        path: bench.toml.
        consent: asked before anything is shown or moves.
        only: role of the only device that is asked and measured; None takes all.
        tell: told what is being done.

    Raises:
        ConfigError: mistakes in the file.
        SafeStateFailed: a device could not be made safe; it must be switched off by hand.
    """
    config = load_bench(path, (), calibrated=False)
    tell("opening each device")
    probed = {device.role: device for device in probe_bench(path) if only in {None, device.role}}
    measured: dict[RoleName, _Found] = {role: {"identity": _identity(device)} for role, device in probed.items()}
    open_ones = {role for role, device in probed.items() if device.error is None}
    refused = _Refused(consent)
    if MODULATOR.name in open_ones:
        _measure_modulator(config, refused, measured, tell)
    if COUNTER.name in open_ones:
        _measure_counter(config, refused, measured, tell)
    if STAGE.name in open_ones:
        _measure_stage(config, refused, measured, tell)
    return CommissioningReport(
        made=f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
        versions={
            "kinopix": version("kinopix"),
            "Python": platform.python_version(),
            "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        },
        devices=tuple(_device(config, device, measured, tell) for device in probed.values()),
    )


class _Refused:
    """Asks once for each effect, and remembers the answer."""

    def __init__(self, consent: Consent) -> None:
        self._consent = consent
        self._said: dict[Effect, bool] = {}

    def __call__(self, effect: Effect, what: str) -> Finding | None:
        """Give why it is not done; None: it may be."""
        if effect not in self._said:
            self._said[effect] = self._consent(effect, what)
        return None if self._said[effect] else Finding(state="not asked", answer=Answer(said="nobody agreed to it"))


def _measure_modulator(
    config: BenchConfig, refused: _Refused, measured: dict[RoleName, _Found], tell: Callable[[str], object]
) -> None:
    found = measured[MODULATOR.name]
    no = refused(
        "light",
        "The modulator will show dark and white pictures for some ten seconds. Their light may fall on the detector and on the "
        "object: is it weak enough for both, and may the detector be on?",
    )
    if no is not None:
        found |= {"upload": no, "playing": no}
        return
    tell("modulator: patterns, start, end, halt")
    with Instrument.from_config(config, only=(MODULATOR.name,)) as bench:
        for name, measure in {"upload": upload, "playing": playing}.items():
            found[name] = _tried(partial(measure, bench.modulator, bench.devices.clock))


def _measure_counter(
    config: BenchConfig, refused: _Refused, measured: dict[RoleName, _Found], tell: Callable[[str], object]
) -> None:
    found = measured[COUNTER.name]
    slow = {"order": order, "dark": dark, "dead time": dead_time}
    names = (*_AT_FULL_RATE, *slow)
    if MODULATOR.name not in config.devices:
        no: Finding | None = Finding(
            state="not asked", answer=Answer(said="no modulator in bench.toml, whose sync it needs")
        )
    else:
        no = refused(
            "light",
            "The modulator will show dark and white pictures for some ten seconds, which the detector counts.",
        )
    if no is not None:
        found |= dict.fromkeys(names, no)
        return
    try:
        with Instrument.from_config(config, only=(MODULATOR.name, COUNTER.name)) as bench:
            tell("counter: five runs at the highest rate")
            try:
                found |= {name: _good(answer) for name, answer in pulses_edges_reads(bench).items()}
            except KinopixError as error:
                found |= dict.fromkeys(_AT_FULL_RATE, _failed(error))
            for name, measure in slow.items():
                tell(f"counter: {name}")
                found[name] = _tried(partial(measure, bench))
    except KinopixError as error:  # such as a modulator that does not open
        _unless_unsafe(error)
        found |= {name: _failed(error) for name in names if name not in found}


def _measure_stage(
    config: BenchConfig, refused: _Refused, measured: dict[RoleName, _Found], tell: Callable[[str], object]
) -> None:
    found = measured[STAGE.name]
    with Instrument.from_config(config, only=(STAGE.name,)) as bench:
        stage, clock = bench.stage, bench.devices.clock
        tell("stage: at rest")
        found["standing"] = _tried(lambda: standing(stage, clock))
        if found["standing"].state == "failed":
            return
        where = f"The stage stands at {stage.position().reported_mm:.3f} mm."
        no = refused(
            "motion", f"{where} It will be moved {Stretch(stage)}. Is the way free, and somebody at the switch?"
        )
        if no is not None:
            found |= {"travel": no, "stop": no}
        else:
            tell("stage: there and back, and a stop")
            found["travel"] = _tried(lambda: travel(stage, clock))
            found["stop"] = _tried(lambda: stop(stage, clock))
        no = refused(
            "homing", f"{where} It will look for its origin, which may be at the end of its travel. Is the way free?"
        )
        if no is None:
            tell("stage: homing")
            no = _tried(lambda: homing(stage, clock))
        found["homing"] = no


def _device(
    config: BenchConfig, probed: Probed, measured: Mapping[RoleName, _Found], tell: Callable[[str], object]
) -> DeviceReport:
    own = measured[probed.role]
    tell(f"{probed.role}: questions of its driver")
    found = {name: finding for others in measured.values() for name, finding in others.items()} | own
    return DeviceReport(
        role=probed.role,
        driver=probed.driver,
        identity=probed.identity,
        settings=config.devices[probed.role].settings.model_dump(mode="json"),
        limits=dict(probed.limits),
        measured=own,
        questions=_asked(config, probed, found),
    )


def _asked(config: BenchConfig, probed: Probed, found: Mapping[str, Finding]) -> tuple[AskedQuestion, ...]:
    """Put the driver's own questions. What one asking answers twice is asked once."""
    device = config.devices[probed.role]
    asked: list[AskedQuestion] = []
    numbers: dict[object, int] = {}
    for number, question in enumerate(device.plugin.questions, 1):
        see = ""
        if question.measured is not None:
            finding, see = found.get(question.measured, _NO_DEVICE), question.measured
        elif question.ask is None:
            finding = Finding(state="by hand", answer=Answer(said=question.by_hand))
        elif probed.error is not None:
            finding = _NO_DEVICE
        elif question.ask in numbers:
            first = numbers[question.ask]
            finding, see = asked[first - 1].finding, f"question {first}"
        else:
            numbers[question.ask] = number
            finding = _tried(partial(_ask, config, probed.role, question))
        asked.append(AskedQuestion(text=question.text, finding=finding, see=see, by_hand=question.by_hand))
    return tuple(asked)


def _ask(config: BenchConfig, role: RoleName, question: BenchQuestion[Any]) -> Answer:
    assert question.ask is not None  # noqa: S101 - what has no function is not asked
    with surroundings(config, role) as context:
        return question.ask(config.devices[role].settings, context)


def _identity(device: Probed) -> Finding:
    if device.error is not None:
        return _failed(device.error)
    said = ", ".join(f"{name} {text}" for name, text in device.figures.items())
    return Finding(state="answered", answer=Answer(said=said, doubts=device.doubts))


def _tried(measure: Callable[[], Answer]) -> Finding:
    try:
        return _good(measure())
    except KinopixError as error:
        _unless_unsafe(error)
        return _failed(error)


def _good(answer: Answer) -> Finding:
    return Finding(state="doubtful" if answer.doubts else "answered", answer=answer)


def _failed(error: KinopixError) -> Finding:
    return Finding(state="failed", answer=Answer(said=f"{type(error).__name__}: {error}"))


def _unless_unsafe(error: KinopixError) -> None:
    if isinstance(error, SafeStateFailed):
        raise error
