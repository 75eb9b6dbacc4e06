"""Power cuts: what a disk may hold of a recording when the current goes, and what of it can still be read.

A disk owes nothing but what was synced. Of everything written after the last sync it may hold any part, in any order, page by
page. So images are made of recording and journal: as they were at the last sync, but that each page that was written since is
drawn from all that it has held meanwhile, where a new page may be zeros too; the length is any of those that the file has had.
``power_cut(count, seed)`` gives a row for each pair of images: whether ``open_recording`` reads no other number than was
measured, or refuses, and whether ``recover`` gives every count that was synced.
"""

import random
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from instrument.plan import Plan
from instrument.storage import Keeper, RecordingWriter, open_recording, recover
from protocols import CountBlock, InputError

PAGE_BYTES: Final = 4096
"""What a disk and its file system write at once."""

_BLOCK: Final = 1000  # patterns: 0.05 s at 20 kHz
_BLOCKS_A_SYNC: Final = 10
_IMAGES_A_BLOCK: Final = 3
_PERIOD_S: Final = 50e-6

Bytes = NDArray[np.uint8]


@dataclass(frozen=True)
class Row:
    """One image of a disk after a power cut."""

    synced: int
    """Patterns that had been synced."""

    written: int
    """Patterns that had been written."""

    kept: int
    """Patterns that are read before a recovery; -1 where the recording is refused."""

    wrong: int
    """Values read, before the recovery or after it, that were not measured so, and synced ones that are missing."""

    recovered: int
    """Patterns after ``recover``; -1 where it refuses."""

    error: str = ""
    """Why it was recovered no better."""

    @property
    def good(self) -> bool:
        """Whether all that was synced is there after a recovery, and nothing else than was measured is read at any time."""
        return self.recovered >= self.synced and not self.wrong


def power_cut(count: int, seed: int) -> list[Row]:
    """Record one run after another without a disk, and cut the power at ``count`` moments."""
    rows = list[Row]()
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="kinopix-attack-") as name:
        folder = Path(name)
        while len(rows) < count:
            rows += _run(folder, chance, min(120, count - len(rows)))
    return rows


def _run(folder: Path, chance: random.Random, count: int) -> list[Row]:
    """One run, a block at a time: each is on its way to the disk before the next, as if the run waited for it."""
    out, rows = folder / "run.h5", list[Row]()
    plan = Plan(frames=40_000, image_size=32, superpixel=4)
    writer = RecordingWriter(out, plan, picture_time_s=_PERIOD_S, sync=lambda _: None, overwrite=True)
    keeper = Keeper(writer, sync_s=1e6)
    done = synced = 0
    states = dict[Path, list[Bytes]]()  # as synced, and all since
    while len(rows) < count:
        values = np.arange(done, done + _BLOCK, dtype=np.float64)
        keeper.raw(CountBlock(done, values, values * _PERIOD_S, (done + _BLOCK) * _PERIOD_S))
        keeper.wait_until_written()
        _note(folder, states)
        keeper.placed(values, values * _PERIOD_S)
        keeper.wait_until_written()
        _note(folder, states)
        done += _BLOCK
        if done % (_BLOCKS_A_SYNC * _BLOCK) == 0 or not synced:
            states = {path: [state[-1]] for path, state in states.items()}
            synced = done
            continue
        for number in range(min(_IMAGES_A_BLOCK, count - len(rows))):
            there = folder / f"cut-{done}-{number}"
            there.mkdir()
            for path, held in states.items():
                (there / path.name).write_bytes(_image(held, chance).tobytes())
            rows.append(_row(there / out.name, synced, done))
            shutil.rmtree(there)
    keeper.finish(frame_valid=np.ones(-(-done // plan.patterns_per_frame), bool), report="{}")
    out.unlink()
    return rows


def _note(folder: Path, states: dict[Path, list[Bytes]]) -> None:
    for path in folder.iterdir():
        if path.is_file() and not path.name.startswith("."):
            states.setdefault(path, []).append(_content(path))


def _content(path: Path) -> Bytes:
    return np.fromfile(path, np.uint8)


def _image(states: list[Bytes], chance: random.Random) -> Bytes:
    """Draw each page from all that it has held."""
    longest = -(-max(len(state) for state in states) // PAGE_BYTES) * PAGE_BYTES
    pages = np.zeros((len(states), longest // PAGE_BYTES, PAGE_BYTES), np.uint8)
    for state, whole in zip(states, pages.reshape(len(states), -1), strict=True):
        whole[: len(state)] = state
    image = pages[0].copy()
    for page in np.flatnonzero((pages != pages[0]).any(axis=(0, 2))):
        image[page] = pages[chance.randrange(len(states)), page]
    return np.asarray(image.ravel()[: len(chance.choice(states))], np.uint8)


def _row(image: Path, synced: int, written: int) -> Row:
    kept = recovered = -1
    wrong, error = 0, ""
    try:
        kept, wrong = _measured(image, 0)
    except InputError as refused:
        error = str(refused)
    try:
        recover(image)
        recovered, wrong_after = _measured(image, synced)
        wrong += wrong_after
    except Exception as caught:  # noqa: BLE001 - whatever it is, the counts are not there
        error = f"{type(caught).__name__}: {caught}"
    return Row(synced, written, kept, wrong, recovered, error)


def _measured(image: Path, synced: int) -> tuple[int, int]:
    """Patterns read, and how many numbers are wrong or missing: the n-th value was n, at n periods."""
    recording = open_recording(image)
    values = recording.values.ravel()
    edges = np.full(len(values), np.nan) if recording.edge_time_s is None else recording.edge_time_s.ravel()
    there = np.flatnonzero(np.isfinite(values))
    wrong = int(np.count_nonzero((values[there] != there) | (edges[there] != there * _PERIOD_S)))
    return len(there), wrong + int(np.count_nonzero(~np.isfinite(values[:synced]))) + max(0, synced - len(values))
