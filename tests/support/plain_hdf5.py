"""The file as somebody sees it who has h5py and nothing of ours. h5py has no types: they end here."""

from pathlib import Path
from typing import Any, Literal

import h5py  # pyright: ignore[reportMissingTypeStubs]
import numpy as np
from numpy.typing import NDArray


def opened(path: Path, mode: Literal["r", "r+", "w"] = "r") -> Any:
    """An ``h5py.File``."""
    return h5py.File(path, mode)


def array(path: Path, name: str) -> NDArray[Any]:
    """A dataset whole."""
    with opened(path) as file:
        return np.asarray(file[name])


def text(path: Path, name: str) -> str:
    """A string."""
    with opened(path) as file:
        return str(file[name].asstr()[()])


def attribute(path: Path, name: str, key: str) -> Any:
    """An attribute."""
    with opened(path) as file:
        return file[name].attrs[key]


def link(path: Path, name: str, target: Path, item: str) -> None:
    """Add a link into another file."""
    with opened(path, "r+") as file:
        file[name] = h5py.ExternalLink(str(target), item)
