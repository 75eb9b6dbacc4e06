"""Past recordings of a folder, with the pictures that lie beside them."""

from collections.abc import Callable
from pathlib import Path
from threading import Lock
from typing import Any, Final

import numpy as np

from instrument.storage import RecordingInfo, StoredAnalysis, recording_info, stored_analysis
from instrument.views import plan_in_words
from protocols import InputError

MOST: Final = 500
"""Recordings that are listed: the newest."""

PICTURES: Final = ("summary", "image", "trajectory", "error", "angle", "background", "timing")
"""Pictures that ``kinopix analyse`` draws, in the order in which they are shown."""

_POINTS: Final = 800
_PNG: Final = b"\x89PNG\r\n\x1a\n"


class Shelf:
    """Reads recordings when it is asked, but none while a run goes on: reading would take turns with its writing.

    What was read of a file is kept until it changes.
    """

    def __init__(self, folder: Path, quiet: Callable[[], bool] = lambda: True) -> None:
        """Show a folder.

        Args:
            folder: where recordings lie.
            quiet: whether files may be read now.

        Raises:
            InputError: there is no such folder.
        """
        if not folder.is_dir():
            raise InputError(saw=f"no folder {folder}", expected="a folder with recordings", remedy="correct the name")
        self.folder = folder
        self._quiet = quiet
        self._lock = Lock()
        self._known: dict[Path, tuple[tuple[float, int], dict[str, Any]]] = {}

    def recordings(self) -> list[dict[str, Any]]:
        """Give the recordings, the newest first, each with what is known of it."""
        files = [file for file in self.folder.glob("*.h5") if file.is_file() and not file.name.startswith(".")]
        files.sort(key=lambda file: (-file.stat().st_mtime, file.name))
        return [self._line(file) for file in files[:MOST]]

    def recording(self, name: str) -> dict[str, Any] | None:
        """Give all that is shown of one recording; None where there is none of that name."""
        file = self._file(name)
        if file is None:
            return None
        line = self._line(file)
        if not self._quiet() or line.get("error"):
            return line
        try:
            return line | {"path": _path(stored_analysis(file), stated=line.get("sigma_px") is not None)}
        except InputError as error:
            return line | {"error": str(error)}

    def picture(self, name: str, picture: str) -> Path | None:
        """Give the file of a picture of a recording; None where there is none, or what is there is no PNG."""
        file = self._file(name)
        if file is None or picture not in PICTURES:
            return None
        path = self.folder / f"{file.stem}-{picture}.png"
        if not path.is_file():
            return None
        with path.open("rb") as opened:
            return path if opened.read(len(_PNG)) == _PNG else None

    def _file(self, name: str) -> Path | None:
        """The recording of that name: of those in the folder, so that no name leads out of it."""
        return next((file for file in self.folder.glob("*.h5") if file.name == name and file.is_file()), None)

    def _line(self, file: Path) -> dict[str, Any]:
        stat = file.stat()
        state = (stat.st_mtime, stat.st_size)
        pictures = [name for name in PICTURES if (self.folder / f"{file.stem}-{name}.png").is_file()]
        line: dict[str, Any] = {"name": file.name, "changed_s": stat.st_mtime, "bytes": stat.st_size}
        line["pictures"] = pictures
        with self._lock:
            kept = self._known.get(file)
        if kept is not None and kept[0] == state:
            return line | kept[1]
        if not self._quiet():
            return line | {"unread": True}
        try:
            known = _known(recording_info(file))
        except InputError as error:
            return line | {"error": str(error)}
        with self._lock:
            self._known[file] = (state, known)
        return line | known


def _known(info: RecordingInfo) -> dict[str, Any]:
    """What the page shows of a recording."""
    table = {} if info.analysis is None else dict(info.analysis.table)
    return {
        "state": info.state,
        "interrupted": info.interrupted,
        "about": ", ".join(text for text in (info.title, info.sample, info.user) if text),
        "recorded": info.start_time,
        "frames": info.frames,
        "frames_masked": info.frames_masked,
        "plan": None if info.plan is None else plan_in_words(info.plan),
        "verdict": None if info.timing is None else info.timing.verdict,
        "notes": [] if info.timing is None else list(info.timing.notes),
        "devices": [f"{device.vendor} {device.model}".strip() for device in info.devices.values()],
        "analysed": None if info.analysis is None else info.analysis.date,
        "sigma_px": table.get("sigma_px"),
        "travel_px": table.get("travel_px"),
        "psnr_db": table.get("psnr_db"),
        "doubts": list(table.get("doubts") or ()),
    }


def _path(analysis: StoredAnalysis | None, *, stated: bool) -> dict[str, Any] | None:
    """The path, with its uncertainty where that is ``stated``, every so many frames; None where there is none."""
    if analysis is None or analysis.displacement_px is None:
        return None
    step = max(1, len(analysis.displacement_px) // _POINTS)
    rows = {"px": analysis.displacement_px, "sigma_px": analysis.sigma_px if stated else None}
    mm = analysis.displacement_mm
    found = {name: array[::step].tolist() for name, array in rows.items() if array is not None}
    scale = None if mm is None else _scale(analysis.displacement_px, mm)
    return {"time_s": analysis.time_s[::step].tolist(), "px_per_mm": scale, **found}


def _scale(displacement_px: Any, displacement_mm: Any) -> float | None:
    """Pixels a millimetre, from the longest way."""
    px, mm = np.hypot(*displacement_px.T), np.hypot(*displacement_mm.T)
    known = np.isfinite(px) & np.isfinite(mm) & (mm > 0)
    return float(px[known].max() / mm[known].max()) if known.any() else None
