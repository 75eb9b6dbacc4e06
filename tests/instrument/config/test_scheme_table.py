"""The ``[scheme]`` of a plan: its name alone, its table or its settings; each mistake with its line."""

from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import pytest
from pydantic import ValidationError

from instrument.config import (
    DEFAULT_SCHEME,
    PluginBroken,
    PluginMissing,
    SchemeSettings,
    find_plugin,
    read_document,
    scheme_plugin,
    scheme_problems,
    settings_of,
)
from instrument.config.scheme_table import SchemePlugin
from instrument.schemes import FourierHadamardSettings
from protocols import Frozen


def problems(folder: Path, text: str) -> list[tuple[int | None, str, str, str, str]]:
    path = folder / "plan.toml"
    path.write_text(text)
    found = scheme_problems(read_document(path))
    assert all(problem.file == path for problem in found)
    return [(p.line, p.key, p.saw, p.expected, p.suggestion) for p in found]


def test_a_name_alone_takes_the_defaults_of_its_scheme() -> None:
    settings = settings_of("fourier-hadamard")
    assert isinstance(settings, FourierHadamardSettings)
    assert settings == FourierHadamardSettings()


def test_a_table_without_a_name_is_of_the_default_scheme() -> None:
    settings = settings_of({"fourier_cycles": 4})
    assert isinstance(settings, FourierHadamardSettings)
    assert (settings.name, settings.fourier_cycles) == (DEFAULT_SCHEME, 4)


def test_settings_are_given_back_as_they_are() -> None:
    settings = FourierHadamardSettings(fourier_cycles=3)
    assert settings_of(settings) is settings


def test_a_table_of_another_scheme_is_that_scheme_s() -> None:
    settings = settings_of({"name": "hadamard", "shuffle_seed": 5})
    assert (settings.name, settings.patterns_per_frame) == ("hadamard", 2)
    assert settings.model_dump()["shuffle_seed"] == 5


def test_what_is_neither_is_refused() -> None:
    with pytest.raises(ValueError, match="give its name, or a table"):
        settings_of(3)
    with pytest.raises(PluginMissing, match="holography"):
        settings_of("holography")
    with pytest.raises(ValidationError, match="fourier_cycles"):
        settings_of({"name": "hadamard", "fourier_cycles": 2})


def test_settings_take_no_other_scheme_s_name() -> None:
    with pytest.raises(ValidationError, match="is hadamard: these are the settings of fourier-hadamard"):
        FourierHadamardSettings(name="hadamard")


def test_a_good_scheme_has_no_problem_however_it_is_given(tmp_path: Path) -> None:
    for text in (
        "frames = 3\n",
        'scheme = "hadamard"\n',
        '[scheme]\nname = "hadamard"\nshuffle_seed = 0\n',
        "[scheme]\n",
    ):
        assert problems(tmp_path, text) == []


def test_a_name_that_is_no_text_is_told_where_it_stands(tmp_path: Path) -> None:
    wanted = ("the name of a scheme", '"fourier-hadamard"')
    assert problems(tmp_path, "frames = 3\nscheme = 7\n") == [(2, "scheme", "7", *wanted)]
    assert problems(tmp_path, "[scheme]\nname = 7\n") == [(2, "scheme.name", "7", *wanted)]


@pytest.mark.parametrize(
    ("text", "line", "key"),
    [
        ('frames = 3\nscheme = "hadamart"\n', 2, "scheme"),
        ('frames = 3\n[scheme]\nshuffle_seed = 3\nname = "hadamart"\n', 4, "scheme.name"),
    ],
)
def test_a_scheme_that_is_not_installed_is_told_once(tmp_path: Path, text: str, line: int, key: str) -> None:
    ((found_line, found_key, saw, expected, _),) = problems(tmp_path, text)
    assert (found_line, found_key) == (line, key)
    assert "did you mean 'hadamard'?" in saw
    assert "fourier-3step" in expected


def test_each_mistake_in_the_table_has_its_own_line(tmp_path: Path) -> None:
    text = '[scheme]\nname = "fourier-3step"\nfourier_cycles = 0\nshuffle_seed = 1\n'
    assert [(line, key) for line, key, *_ in problems(tmp_path, text)] == [
        (3, "scheme.fourier_cycles"),
        (4, "scheme.shuffle_seed"),
    ]


class NoSettings(Frozen):
    """Not of a scheme."""


class Uncounted(SchemeSettings):
    """Does not say how many patterns a frame has."""

    name: str = "hadamard"


class Counted(SchemeSettings):
    """Complete, under a name that is not its entry point's."""

    patterns_per_frame: ClassVar[int] = 2
    name: str = "mine"


@pytest.mark.parametrize(
    ("settings", "saw"),
    [
        (NoSettings, "settings NoSettings that are no SchemeSettings; expected a subclass of"),
        (Uncounted, "settings Uncounted without patterns_per_frame; expected the patterns in a frame"),
        (Counted, "settings Counted whose name is 'mine'; expected the name of its entry point, 'hadamard'"),
    ],
)
def test_settings_that_cannot_be_a_plan_s_are_refused_when_the_scheme_is_loaded(
    settings: type[Any], saw: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = scheme_plugin("hadamard")
    assert isinstance(good, SchemePlugin)
    installed = find_plugin("scheme", "hadamard")
    module = __import__(installed.entry_point.module, fromlist=["plugin"])
    monkeypatch.setattr(module, "plugin", replace(good, settings=settings))
    with pytest.raises(PluginBroken, match=saw):
        installed.load()


def test_every_field_will_do_for_settings_that_do_not_care() -> None:
    Counted().check(image_size=8, superpixel=1)
