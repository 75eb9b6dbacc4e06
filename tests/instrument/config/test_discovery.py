"""Plug-ins are found by name, and what is wrong with one is said."""

import shutil
import sys
from importlib import invalidate_caches
from pathlib import Path

import pytest

from instrument.config import PluginBroken, PluginMissing, find_plugin, installed_plugins, list_plugins
from protocols import DriverPlugin

pytestmark = pytest.mark.usefixtures("acme")


def test_a_third_party_plug_in_is_found_and_nothing_is_imported_before_it_is_loaded() -> None:
    sys.modules.pop("kinopix_acme.good", None)
    found = find_plugin("modulator", "acme-projector")
    assert (found.distribution, found.version) == ("kinopix-acme", "1.2.0")
    assert "kinopix_acme.good" not in sys.modules
    plugin = found.load()
    assert isinstance(plugin, DriverPlugin)
    assert plugin.summary == "Acme projector"


def test_a_plug_in_that_is_installed_or_removed_meanwhile_is_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    before = [plugin.name for plugin in installed_plugins("counter")]
    record = tmp_path / "kinopix_late-1.0.dist-info"
    record.mkdir()
    (record / "METADATA").write_text("Metadata-Version: 2.1\nName: kinopix-late\nVersion: 1.0\n")
    (record / "entry_points.txt").write_text("[kinopix.counters]\nlate = nowhere:plugin\n")
    assert [plugin.name for plugin in installed_plugins("counter")] == sorted([*before, "late"])
    shutil.rmtree(record)
    assert [plugin.name for plugin in installed_plugins("counter")] == before


def test_the_simulated_devices_are_found_by_the_same_road() -> None:
    assert find_plugin("counter", "simulated").distribution == "kinopix"


def test_a_missing_plug_in_is_an_error_that_names_what_is_installed() -> None:
    with pytest.raises(PluginMissing) as caught:
        find_plugin("modulator", "acme-projectr")
    assert caught.value.exit_code == 2
    assert "'acme-projectr', a modulator plug-in that no installed distribution offers" in caught.value.saw
    assert "did you mean 'acme-projector'?" in caught.value.saw
    assert "acme-projector" in caught.value.expected
    assert "simulated" in caught.value.expected


def test_a_kind_of_which_nothing_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [])
    invalidate_caches()
    with pytest.raises(PluginMissing, match="an installed transport plug-in: there is none"):
        find_plugin("transport", "acme-wire")


@pytest.mark.parametrize(
    ("name", "cause", "expected"),
    [
        ("acme-no-library", "ImportError: libacme.so: cannot open shared object file", "to import without an error"),
        ("acme-gone", "AttributeError: .*not_there", "to import without an error"),
        ("acme-device", "kinopix_acme.wrong:Device of type type", "a protocols.DriverPlugin"),
        ("acme-transport", "kinopix_acme.good:wire of type TransportPlugin", "a protocols.DriverPlugin"),
        ("acme-loose", "settings Loose that ignore keys they do not know", "such as a protocols.Frozen"),
        ("acme-greedy", "settings Greedy with the key transport", "another name for that key"),
    ],
)
def test_a_broken_plug_in_is_an_error_that_names_distribution_and_cause(name: str, cause: str, expected: str) -> None:
    with pytest.raises(PluginBroken, match=cause) as caught:
        find_plugin("counter", name).load()
    assert caught.value.exit_code == 2
    assert caught.value.device == f"counter plug-in '{name}' of kinopix-acme 1.2.0"
    assert expected in caught.value.expected
    assert "repair or reinstall kinopix-acme 1.2.0" in caught.value.remedy


@pytest.mark.usefixtures("rival")
def test_one_name_in_two_distributions_is_an_error_that_names_both() -> None:
    with pytest.raises(PluginMissing, match=r"offered by kinopix-acme 1\.2\.0 and kinopix-rival 0\.3"):
        find_plugin("counter", "acme-counter")


def test_the_list_holds_every_plug_in_the_broken_ones_too() -> None:
    lines = {
        (line.plugin.kind, line.plugin.name): line
        for line in list_plugins()
        if line.plugin.distribution == "kinopix-acme"
    }
    assert len(lines) == 11
    good = lines["counter", "acme-counter"]
    assert (good.summary, good.availability.ready, good.error) == ("Acme counter", True, "")
    unready = lines["modulator", "acme-projector"]
    assert unready.availability.missing == "libacme: install it from the maker's CD"
    broken = lines["counter", "acme-no-library"]
    assert broken.error == "ImportError: libacme.so: cannot open shared object file"
    assert not broken.availability.ready
    careless = lines["stage", "acme-axis"]
    assert (careless.summary, careless.error) == ("Acme axis", "OSError: bus error")
    assert lines["scene", "acme-desk"].availability.ready


def test_plug_ins_are_listed_by_name() -> None:
    names = [plugin.name for plugin in installed_plugins("counter") if plugin.distribution == "kinopix-acme"]
    assert names == sorted(names)
