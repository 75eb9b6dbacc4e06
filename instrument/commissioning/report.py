"""The report of a commissioning: a value, its text, and its JSON."""

from pathlib import Path
from typing import Any, Final, Literal, TypeAlias

from pydantic import Field

from instrument.roles import RoleName
from instrument.storage import json_text
from protocols import Answer, DeviceIdentity, FigureValue, Frozen

State: TypeAlias = Literal["answered", "doubtful", "failed", "not asked", "by hand"]
"""What became of a question: a program answered it; it did, and differs from what Kinopix takes for granted; the device raised an
error; nobody agreed, or a device was missing; it is for a person."""

_MARKS: Final[dict[State, str]] = {
    "answered": "ok", "doubtful": "DOUBT", "failed": "FAILED", "not asked": "not asked", "by hand": "BY HAND",
}  # fmt: skip


class Finding(Frozen):
    """What was found, or why nothing was."""

    state: State
    """What became of it."""

    answer: Answer
    """The finding; where there is none, why."""


class AskedQuestion(Frozen):
    """A question of the driver's how-to, and its answer."""

    text: str
    """The question."""

    finding: Finding
    """Its answer."""

    see: str = ""
    """Name of the measurement, or number of the question, that answered it; empty where the answer stands here alone."""

    by_hand: str = ""
    """What a person has to look at; empty where nothing is left."""


class DeviceReport(Frozen):
    """One device."""

    role: RoleName
    """Its place on the bench."""

    driver: str
    """Driver that bench.toml names."""

    identity: DeviceIdentity | None
    """Who it is; None where it did not open."""

    settings: dict[str, Any]
    """The driver's settings, defaults included."""

    limits: dict[str, Any]
    """Its limits, in the units that their names say."""

    measured: dict[str, Finding]
    """Measurements by name."""

    questions: tuple[AskedQuestion, ...]
    """The driver's own questions."""


class CommissioningReport(Frozen):
    """All devices of a bench."""

    made: str
    """Date and time, UTC."""

    versions: dict[str, str]
    """Kinopix, Python, operating system."""

    devices: tuple[DeviceReport, ...] = Field(default=())
    """In the order of their roles."""

    @property
    def answered(self) -> int:
        """Number of questions that the program has answered, whole or in part."""
        return sum(asked.finding.state in {"answered", "doubtful"} for asked in self._asked)

    @property
    def by_hand(self) -> int:
        """Number of questions of which something is left for a person."""
        return sum(bool(asked.by_hand) for asked in self._asked)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Everything that differs from what Kinopix takes for granted."""
        found = (
            (device.role, finding)
            for device in self.devices
            for finding in (
                *device.measured.values(),
                *(asked.finding for asked in device.questions if not asked.see),
            )
        )
        return tuple(dict.fromkeys(f"{role}: {doubt}" for role, finding in found for doubt in finding.answer.doubts))

    @property
    def failed(self) -> bool:
        """Whether a device did not open or raised an error."""
        return any(
            finding.state == "failed"
            for device in self.devices
            for finding in (*device.measured.values(), *(asked.finding for asked in device.questions))
        )

    @property
    def _asked(self) -> tuple[AskedQuestion, ...]:
        return tuple(asked for device in self.devices for asked in device.questions)

    def text(self) -> str:
        """The report for a person, with a line to fill in for each question that is left."""
        lines = ["Kinopix commissioning report", f"made {self.made}", *(f"{k} {v}" for k, v in self.versions.items())]
        for device in self.devices:
            lines += ["", *_device_lines(device)]
        asked, by_hand = len(self._asked), self.by_hand
        lines += [
            "",
            f"{self.answered} of {asked} questions answered; {by_hand} want a person's look, in part or whole.",
        ]
        lines += [f"doubt: {doubt}" for doubt in self.doubts]
        return "\n".join(lines) + "\n"

    def write(self, stem: Path) -> tuple[Path, Path]:
        """Write ``stem.txt`` and ``stem.json``, and give both paths.

        Raises:
            OSError: they cannot be written.
        """
        paths = stem.with_name(f"{stem.name}.txt"), stem.with_name(f"{stem.name}.json")
        paths[0].write_text(self.text(), encoding="utf-8")
        paths[1].write_text(json_text(self.model_dump(mode="json"), indent=2) + "\n", encoding="utf-8")
        return paths


def _device_lines(device: DeviceReport) -> list[str]:
    lines = [f"== {device.role}: {device.driver}", "settings"]
    lines += [f"    {name} = {value}" for name, value in device.settings.items()]
    lines += ["measured"]
    for name, finding in device.measured.items():
        lines += _finding_lines(f"  {name}", finding)
    if device.questions:
        lines += ["questions of its how-to"]
    for number, asked in enumerate(device.questions, 1):
        lines.append(f"  {number}. {asked.text}")
        if asked.see:
            lines.append(f"      [{_MARKS[asked.finding.state]}] see {asked.see} above")
        elif asked.finding.state != "by hand":
            lines += _finding_lines("     ", asked.finding)
        if asked.by_hand:
            lines += [f"      [BY HAND] {asked.by_hand}", "      ____________________________________________"]
    return lines


def _finding_lines(head: str, finding: Finding) -> list[str]:
    lines = [f"{head} [{_MARKS[finding.state]}] {finding.answer.said}"]
    lines += [f"        {name} = {_short(value)}" for name, value in finding.answer.figures.items()]
    return lines + [f"        doubt: {doubt}" for doubt in finding.answer.doubts]


def _short(value: FigureValue) -> str:
    """A figure with seven digits; the JSON has them all."""
    if isinstance(value, tuple):
        return ", ".join(map(_short, value))
    return f"{value:.7g}" if isinstance(value, float) else str(value)
