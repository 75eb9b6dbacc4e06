"""The pytest plug-in: ``--kinopix-driver package.module:factory`` hands a rig factory to the suite of its kind."""

from importlib import import_module
from pathlib import Path
from typing import Any, Final, cast, get_args, get_type_hints

import pytest

from protocols.conformance.consent import OPTION
from protocols.conformance.rigs import CounterRig, ModulatorRig, Rig, RigFactory, StageRig

_SUITES: Final[dict[str, type[Rig]]] = {
    "test_modulator": ModulatorRig,
    "test_counter": CounterRig,
    "test_stage": StageRig,
}
_HERE: Final = Path(__file__).parent
_SELF: Final = "protocols.conformance"
_EXAMPLE: Final = "my_package.conformance:stage_rig"

_factories: Final = pytest.StashKey[dict[str, RigFactory[Any]]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option."""
    parser.getgroup("kinopix", "conformance to the protocols of Kinopix").addoption(
        "--kinopix-driver",
        action="append",
        default=[],
        metavar="MODULE:FACTORY",
        help=f"rig factory of a driver to test, such as {_EXAMPLE}; may be given many times",
    )
    parser.getgroup("kinopix").addoption(
        OPTION,
        action="store_true",
        default=False,
        help="move a real stage without asking: the way is free, and somebody is at the switch",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Import the factories before anything is collected, so that a wrong name is the first thing one sees.

    Raises:
        pytest.UsageError: a wrong name, or none though the suites are to be run.
    """
    names = cast("list[str]", config.getoption("--kinopix-driver"))
    if not names and any(argument.startswith(_SELF) for argument in config.args):
        raise pytest.UsageError(f"no driver to test. To do: add --kinopix-driver {_EXAMPLE}")
    config.stash[_factories] = {name: import_factory(name) for name in names}


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out the suites of which no driver was named."""
    if collection_path.parent != _HERE or not collection_path.name.startswith("test_"):
        return None
    kind = _kind_of_suite(collection_path.stem)
    return None if any(rig_type(factory) is kind for factory in config.stash[_factories].values()) else True


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run each test of a suite once for each driver of its kind."""
    suite = metafunc.definition.path
    if suite.parent == _HERE and "open_rig" in metafunc.fixturenames:
        kind = _kind_of_suite(suite.stem)
        fitting = {
            name: factory for name, factory in metafunc.config.stash[_factories].items() if rig_type(factory) is kind
        }
        metafunc.parametrize("open_rig", fitting.values(), ids=fitting.keys())


def rig_type(factory: RigFactory[Any]) -> type[Rig] | None:
    """Which rig a factory gives, by its annotation; None where it does not say."""
    gives = get_type_hints(factory).get("return")
    return next((kind for kind in _SUITES.values() if kind is gives or kind in get_args(gives)), None)


def _kind_of_suite(module: str) -> type[Rig]:
    return next(kind for suite, kind in _SUITES.items() if module.startswith(suite))


def import_factory(name: str) -> RigFactory[Any]:
    """Give the rig factory that ``package.module:factory`` names.

    Raises:
        pytest.UsageError: there is none, or it does not say which rig it gives.
    """
    module, _, attribute = name.partition(":")
    try:
        factory: RigFactory[Any] = getattr(import_module(module), attribute)
    except (ImportError, AttributeError, ValueError) as error:
        raise pytest.UsageError(
            f"--kinopix-driver {name}: {error}. To do: name a function as {_EXAMPLE}, in an installed package"
        ) from error
    if not callable(factory) or rig_type(factory) is None:
        raise pytest.UsageError(
            f"--kinopix-driver {name}: no rig factory. To do: annotate what it gives, such as -> Generator[StageRig]"
        )
    return factory
