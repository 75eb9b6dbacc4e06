"""Kinopix's own top-level packages stay its own, whatever lies beside a lab's script.

``protocols``, ``drivers``, ``sim_backends`` and ``instrument`` are plain words. A lab that keeps a ``protocols.py`` beside its
script would have Python import that one, as the script's folder comes first. A finder in front of all others therefore looks
for these four where Kinopix is installed.
"""

import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Final

PACKAGES: Final = ("protocols", "drivers", "sim_backends", "instrument")
"""Top-level packages that Kinopix brings."""

_HOME: Final = Path(__file__).resolve().parent.parent


class _Finder:
    """Finds the packages of Kinopix where Kinopix is, and nothing else."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        """Give the place of one of the four packages; None for every other module, which the next finder then looks for."""
        del target
        return PathFinder.find_spec(name, [str(_HOME)]) if path is None and name in PACKAGES else None


def claim_packages() -> None:
    """Let the names of Kinopix's packages mean these packages from now on.

    Raises:
        ImportError: another module of that name was imported before.
    """
    for name in PACKAGES:
        loaded = sys.modules.get(name)
        place = getattr(loaded, "__file__", None)
        if loaded is not None and (place is None or _HOME not in Path(place).resolve().parents):
            raise ImportError(
                f"kinopix: saw a module {name!r} of another origin ({place}), imported before; expected the package "
                f"{name!r} that Kinopix brings. To do: import kinopix first, or rename your module."
            )
    if not any(finder is _Finder for finder in sys.meta_path):
        sys.meta_path.insert(0, _Finder)
