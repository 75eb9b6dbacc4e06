"""What a recording is, as a table."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from rich.table import Table
from rich.text import Text

from instrument.views.terminal import coloured, figures_table, plain

if TYPE_CHECKING:  # only named in signatures: a table loads no numpy
    from instrument.plan import Plan
    from instrument.storage import AnalysisInfo, RecordingInfo
    from protocols import DeviceIdentity


def recording_table(info: "RecordingInfo") -> Table:
    """Give what a recording is, a line for each thing that a person may ask of it."""
    masked = "not audited" if info.frames_masked is None else f"{info.frames_masked} masked"
    rows: dict[str, str | Text] = {
        "title": info.title,
        **{name: text for name in ("user", "sample", "notes") if (text := getattr(info, name))},
        "written by": f"{info.program} {info.version}, layout {info.layout}, {info.file_bytes / 1e6:.1f} MB",
        "recorded": f"{info.start_time} to {info.end_time or '-'}",
        "state": _state(info),
        "plan": _no_scheme(info.missing_scheme) if info.plan is None else plan_in_words(info.plan),
        "frames": f"{info.frames} of {'?' if info.plan is None else info.plan.frames}, {masked}",
        "holds": _holds(info),
        **{role: _device(identity) for role, identity in info.devices.items()},
    }
    if info.timing is not None:
        rows["timing"] = coloured(info.timing.verdict)
        rows |= _numbered("note", info.timing.notes)
    if info.analysis is not None:
        rows |= _analysis(info.analysis)
        rows |= _numbered("doubt", info.analysis.table.get("doubts") or ())
    return figures_table(str(info.path), rows)


def _no_scheme(name: str) -> Text:
    return plain(f"its scheme {name!r} is not installed here: install the distribution that offers it", "yellow")


def plan_in_words(plan: "Plan") -> str:
    """Say a plan in one line: scheme, frames, rate, image size, motion."""
    motion = plan.motion
    moves = "at rest" if motion is None else f"{motion.velocity_mm_s:g} mm/s from {motion.start_mm:g} mm"
    size = f"{plan.image_size} x {plan.image_size} px"
    return f"{plan.scheme.name}, {plan.frames} frames, {plan.pattern_rate_hz:g} patterns/s, {size}, {moves}"


def about_in_words(plan: "Plan") -> str:
    """Say what a run is about in one line, as its plan has it: title, sample, user; empty where it says nothing."""
    return "" if plan.run is None else plan.run.in_words


def _state(info: "RecordingInfo") -> str:
    match info.state:
        case "interrupted":
            return f"interrupted: {info.interrupted}"
        case "being recorded":
            return f"being recorded by process {info.process_id}"
        case "cut off":
            return "cut off: its program ended without closing it"
        case "complete":
            return "complete"


def _holds(info: "RecordingInfo") -> str:
    there = (
        ("photon counts" if info.photon_counts else "values of a detector that does not count", True),
        ("edge times", info.edge_times),
        ("truth", info.truth),
        ("analysis", info.analysis is not None),
    )
    return ", ".join(what for what, held in there if held)


def _device(identity: "DeviceIdentity") -> str:
    more = (
        ("serial", identity.serial),
        ("firmware", identity.firmware),
        ("driver", identity.driver),
    )
    return ", ".join([f"{identity.vendor} {identity.model}", *(f"{what} {text}" for what, text in more if text)])


def _analysis(analysis: "AnalysisInfo") -> dict[str, str]:
    """The figures that are there, whatever version of the program stored them."""
    table = analysis.table
    rows = {"analysis": f"{analysis.date}, {analysis.program} {analysis.version}"}
    travel_px: Any = table.get("travel_px")
    if travel_px:
        rows["travel"] = ", ".join(f"{float(along):.2f}" for along in travel_px) + " px"
    for name, key, form in (
        ("stated uncertainty", "sigma_px", "{:.3f} px"),
        ("displacement MSE", "displacement_mse_px2", "{:.4f} px^2"),
        ("PSNR", "psnr_db", "{:.1f} dB"),
        ("misfit", "misfit", "{:.3f} (1 is the noise alone)"),
    ):
        if table.get(key) is not None:
            rows[name] = form.format(float(table[key]))
    return rows


def _numbered(name: str, texts: Iterable[str]) -> dict[str, str]:
    return {f"{name} {k}": text for k, text in enumerate(texts, 1)}
