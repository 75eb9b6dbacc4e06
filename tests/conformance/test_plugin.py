"""The option ``--kinopix-driver``: what it names, and what it answers to a wrong name."""

import subprocess
import sys
from contextlib import AbstractContextManager

import pytest

from protocols.conformance import CounterRig, ModulatorRig, StageRig
from protocols.conformance.plugin import import_factory, rig_type
from tests.conformance import rigs


def test_only_the_suites_themselves_need_pytest() -> None:
    code = "import sys, protocols.conformance; sys.exit('pytest' in sys.modules or 'hypothesis' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_factory_is_found_by_its_module_and_name() -> None:
    assert import_factory("tests.conformance.rigs:mc600") is rigs.mc600


def manager() -> AbstractContextManager[CounterRig]:
    raise NotImplementedError


def test_the_annotation_says_which_suite_a_factory_is_for() -> None:
    assert rig_type(rigs.dlp7000) is ModulatorRig
    assert rig_type(rigs.sc300) is StageRig
    assert rig_type(rigs.ni) is CounterRig
    assert rig_type(manager) is CounterRig


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("tests.conformance.rigs:mc60", "has no attribute 'mc60'"),
        ("tests.conformanc.rigs:mc600", "No module named 'tests.conformanc'"),
        ("tests.conformance.rigs", "name a function as my_package.conformance:stage_rig"),
        ("", "name a function as my_package.conformance:stage_rig"),
        ("tests.conformance.rigs:PHOTONS", "annotate what it gives, such as -> Generator"),
        ("tests.conformance.rigs:_plugin", "annotate what it gives, such as -> Generator"),
    ],
)
def test_a_wrong_name_is_answered_with_what_to_do(name: str, answer: str) -> None:
    with pytest.raises(pytest.UsageError, match=answer) as wrong:
        import_factory(name)
    assert f"--kinopix-driver {name}" in str(wrong.value)
