r"""Find the vendor's ALP library, and tell in full what was tried where it is not found (fact sheet 3.1).

Windows: the registry value ``Path`` of ``HKLM\SOFTWARE\ViALUX\ALP-<release>`` names the installation; below it lies the API's
folder, with a sub-folder ``x64`` for 64-bit programs. Linux: ``/usr/lib/x86_64-linux-gnu``. On both the system's own loader
is asked last. A path in bench.toml is the only one tried: a wrong setting is never healed by another library.
"""

import ctypes
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Final, NamedTuple

from drivers.alp.api import AlpApi
from drivers.alp.binding import bind
from protocols.errors import DriverUnavailable


class _Release(NamedTuple):
    number: str
    windows: str
    linux: str
    folder: str


RELEASES: Final = (
    _Release("4.4", "Alp44.dll", "libalp44.so", "ALP-4.4 high-speed API"),
    _Release("4.3", "alp4395.dll", "libalp43.so", "ALP-4.3 high-speed API"),
    _Release("4.2", "alpV42.dll", "libalp42.so", "ALP-4.2 high-speed API"),
    _Release("4.1", "alpD41.dll", "libalp41.so", "ALP-4.1 high-speed API"),
    _Release("5.1", "alp51.dll", "libalp51.so", "ALP-5.1 API"),
    _Release("5.0", "alp50.dll", "libalp50.so", "ALP-5.0 API"),
)
"""File names and folders, in the order in which they are tried: the newest of the ALP-4 family first."""

LINUX_FOLDER: Final = "/usr/lib/x86_64-linux-gnu"


class Library(NamedTuple):
    """A library that was loaded and has all functions."""

    api: AlpApi
    """Functions of the library."""

    label: str
    """Release and path of the library, for people."""


if sys.platform == "win32":
    import winreg

    def _registry_path(release: str) -> str | None:
        try:
            with winreg.OpenKey(winreg.HKEY_LOCAL_MACHINE, rf"SOFTWARE\ViALUX\ALP-{release}") as key:
                return str(winreg.QueryValueEx(key, "Path")[0])
        except OSError:
            return None
else:

    def _registry_path(_release: str) -> str | None:
        return None


@dataclass(frozen=True)
class Machine:
    """What the search needs to know of the computer; tests describe another one."""

    windows: bool = sys.platform == "win32"
    """Whether DLL names and the registry apply."""

    bits: int = 64 if sys.maxsize > 2**32 else 32
    """Word size of this Python: it must be the library's."""

    registry_path: Callable[[str], str | None] = _registry_path
    """Installation path of a release, by its number; None where it is not registered."""

    load: Callable[[str], object] = ctypes.CDLL
    """Loads a library by path or bare name, or raises ``OSError``."""


def find_library(setting: Path | None, machine: Machine | None = None, *, device: str = "dmd") -> Library:
    """Load the library named by ``setting``, or the first one found.

    Raises:
        DriverUnavailable: none could be used; names every library looked for, and what was wrong with those that are there.
    """
    machine = machine or Machine()
    tried: list[str] = []
    absent: dict[str, None] = {}
    for number, path, obstacle in _places(setting, machine):
        if path is None:
            tried += [obstacle] if setting is not None else []
            continue
        try:
            return Library(bind(machine.load(path), device=device), f"ALP-{number} {path}")
        except OSError as error:
            if setting is None and _is_absent(error):
                absent[PureWindowsPath(path).name if machine.windows else PurePosixPath(path).name] = None
            else:
                tried.append(f"{path} ({str(error).removeprefix(f'{path}: ')})")
        except DriverUnavailable as error:
            tried.append(f"{path} ({error.saw})")
    raise DriverUnavailable(
        device=device,
        saw="no usable ALP library: " + "; ".join([*tried, *([_nowhere(absent, machine)] if absent else [])]),
        expected=f"the ViALUX ALP-4 high-speed API for {machine.bits}-bit programs",
        remedy='install it from the disc or download of the board, or set library = "<file>" under [modulator] in bench.toml',
    )


def _is_absent(error: OSError) -> bool:
    """Whether a library is not there at all, by what loaders say on Linux and Windows."""
    return isinstance(error, FileNotFoundError) or "No such file" in str(error) or "Could not find module" in str(error)


def _nowhere(names: Iterable[str], machine: Machine) -> str:
    folder = "the folders that ViALUX's installer registers" if machine.windows else LINUX_FOLDER
    return f"{', '.join(names)} neither in {folder} nor where the system looks for libraries"


def _places(setting: Path | None, machine: Machine) -> Iterator[tuple[str, str | None, str]]:
    """Release, path to try (or None) and, where there is none, why."""
    if setting is not None:
        if "basic" in setting.name.lower():
            yield "?", None, f"{setting} (the 'basic' API is another one and cannot play preloaded sequences)"
        else:
            yield "?", str(setting), ""
        return
    for release in RELEASES:
        if not machine.windows:
            yield release.number, f"{LINUX_FOLDER}/{release.linux}", ""
        elif (root := machine.registry_path(release.number)) is None:
            yield release.number, None, "not registered"
        else:
            folder = PureWindowsPath(root, release.folder)
            folder = folder / "x64" if machine.bits == 64 else folder
            yield release.number, str(folder / release.windows), ""
    for release in RELEASES:
        yield release.number, release.windows if machine.windows else release.linux, ""
