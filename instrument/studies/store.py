"""Finished points on the disk, each a file of its own under the key of what was computed, by which program."""

import hashlib
import json
import os
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from instrument.storage import program
from instrument.studies.processing import Outcome
from instrument.studies.simulated import Simulated
from instrument.studies.study import Compute


@dataclass(frozen=True)
class Point:
    """One run of a study: what is computed of it hangs on these alone."""

    name: str
    """Text that names it to people."""

    label: str
    """Case that it belongs to."""

    compute: Compute
    """Function of settings and seed."""

    settings: Simulated
    """Settings of the run."""

    seed: int
    """Seed of its noise."""

    @property
    def key(self) -> str:
        """Digest of everything that the outcome hangs on."""
        of_whom = f"{self.compute.__module__}.{self.compute.__qualname__}"
        parts = [program(), of_whom, self.settings.model_dump_json(), str(self.seed)]
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:32]


class PointStore:
    """A folder of finished points. A file is there whole, or not at all."""

    def __init__(self, folder: Path) -> None:
        """Use a folder, which is made when the first point is kept."""
        self.folder = folder

    def _path(self, point: Point) -> Path:
        return self.folder / f"{point.key}.npz"

    def read(self, point: Point) -> dict[str, Outcome] | None:
        """Give the outcome of a point; None where it is not finished, or its file is damaged."""
        try:
            with self._path(point).open("rb") as file, np.load(file, allow_pickle=False) as kept:
                table: list[Any] = json.loads(str(kept["figures"]))
                return {
                    str(name): Outcome(dict(figures), np.asarray(kept[f"image{index}"], np.float64))
                    for index, (name, figures) in enumerate(table)
                }
        except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile):
            return None

    def write(self, point: Point, outcomes: dict[str, Outcome]) -> None:
        """Keep the outcome of a point: written under another name first, and then given its own."""
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self._path(point)
        part = path.with_suffix(f".{os.getpid()}.part")
        images: dict[str, Any] = {f"image{index}": outcome.image for index, outcome in enumerate(outcomes.values())}
        figures = json.dumps([[name, outcome.figures] for name, outcome in outcomes.items()])
        with part.open("wb") as file:
            np.savez_compressed(file, figures=np.array(figures), **images)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
        for left in self.folder.glob(f"{path.stem}.*.part"):  # of a process that was killed while it wrote
            left.unlink(missing_ok=True)
