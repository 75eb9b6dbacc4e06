"""``kinopix new-driver``: a package with a driver that passes its conformance suite, to begin with."""

import keyword
import re
import sys
from pathlib import Path
from typing import Annotated, Final, Literal

import typer

from instrument.cli.options import JsonOption, print_json

_KINDS: Final = {"modulator": "ModulatorRig", "counter": "CounterRig", "stage": "StageRig"}
_NAME: Final = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
_LONGEST: Final = 60
_TAKEN: Final = frozenset(
    {"drivers", "instrument", "kinopix", "numpy", "protocols", "pydantic", "pytest", "serial", "simulated", "tests"}
)
"""Names of packages and drivers that a new one would hide."""


def new_driver(
    name: Annotated[str, typer.Argument(help="Name of the driver, as bench.toml will name it: acme-m1.")],
    kind: Annotated[Literal["stage", "counter", "modulator"], typer.Option(help="What it drives.")],
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder to make; the driver's name here if not given.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Write a package with a driver, its emulator and its tests, which pass: then put the commands of your device into it."""
    from instrument.views import say
    from protocols import InputError

    if len(name) > _LONGEST or not _NAME.fullmatch(name):
        raise InputError(
            saw=f"the name {name[:_LONGEST]!r}",
            expected=f"at most {_LONGEST} small letters and digits, in words joined by -, such as acme-m1",
            remedy="name it so; it is the name of the distribution, and with _ that of the package",
        )
    if keyword.iskeyword(name) or name in sys.stdlib_module_names | _TAKEN:
        raise InputError(
            saw=f"the name {name}, which is a word or a module of Python, or a package that drivers stand on",
            expected="a name of its own",
            remedy=f"add the maker's name, such as acme-{name}",
        )
    folder = out or Path(name)
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(
            saw=f"{folder}, which exists",
            expected="a folder to make, or an empty one",
            remedy="name another with --out",
        )
    files = {folder / path: text for path, text in files_of(name, kind).items()}
    for place, text in files.items():
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")
        if not as_json:
            say(f"written {place}")
    if as_json:
        print_json({"folder": str(folder), "written": [str(place) for place in files]})
    else:
        say(f"next: cd {folder}; pip install -e '.[dev]'; pytest; then README.md")


def files_of(name: str, kind: Literal["stage", "counter", "modulator"]) -> dict[str, str]:
    """Give the files of the package by their path in its folder.

    Args:
        name: of the driver.
        kind: what it drives.
    """
    from importlib.resources import files

    package = name.replace("-", "_")
    words = {
        "package": package,
        "driver": name,
        "kind": kind,
        "Class": "".join(word.capitalize() for word in name.split("-")),
        "title": " ".join(word.capitalize() for word in name.split("-")),
        "Rig": _KINDS[kind],
    }
    for role in _KINDS:
        words[role] = name if role == kind else "simulated"
        words[f"{role} transport"] = f'transport = "{name}-emulator"\n' if role == kind else ""
    source = files("instrument.cli") / "new"

    def text(template: str) -> str:
        raw = (source / f"{template}.txt").read_text(encoding="utf-8")
        return re.sub(r"@([A-Za-z ]+)@", lambda found: words[found[1]], raw)

    modules = {
        f"{package}/{module}.py": text(f"{kind}-{module}.py") for module in ("driver", "emulator", "conformance")
    }
    return {
        "pyproject.toml": text("pyproject.toml"),
        "README.md": text("README.md"),
        f"{package}/__init__.py": f'"""{words["title"]} for Kinopix."""\n',
        f"{package}/py.typed": "",
        f"{package}/line.py": text("line.py"),
        **modules,
        "tests/test_conformance.py": text("test_conformance.py"),
        "bench.toml": text("bench.toml"),
        "plan.toml": text("plan.toml"),
    }
