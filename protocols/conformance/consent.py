"""Before the suite moves a real stage, somebody says that it may."""

import sys
from typing import Any, Final

import pytest

from protocols.conformance.rigs import StageRig
from protocols.conformance.spot import is_hardware, will_do

OPTION: Final = "--kinopix-may-move"

_agreed: Final = pytest.StashKey[set[str]]()


def ask_before_moving(rig: StageRig, config: pytest.Config) -> None:
    """Ask the person at the terminal, once a run and stage; refuse where nobody can answer.

    Raises:
        pytest.Failed: nobody agreed, or the stage stands where the rig does not want it.
    """
    with rig.open() as stage:
        plan, serial = will_do(rig, stage), stage.identity.model_dump_json()
        real = is_hardware(rig, stage)
    agreed = config.stash.setdefault(_agreed, set())
    if not real or serial in agreed or config.getoption(OPTION, default=False):
        return
    if not _answer(plan, config):
        pytest.fail(
            f"{plan} Nobody has agreed to that. To do: look that the way is free, and add {OPTION}", pytrace=False
        )
    agreed.add(serial)


def _answer(plan: str, config: pytest.Config) -> bool:
    capture: Any = config.pluginmanager.getplugin("capturemanager")
    if capture is None or not sys.stdin or not sys.__stdin__ or not sys.__stdin__.isatty():
        return False
    with capture.global_and_fixture_disabled():
        print(f"\n{plan}\nIs the way free? [y/N] ", end="", flush=True)  # noqa: T201 - a question to a person
        return sys.__stdin__.readline().strip().lower() in {"y", "yes"}
