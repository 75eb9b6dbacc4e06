"""The entry point."""

from pathlib import Path

import pytest
from pydantic import ValidationError

from drivers.alp import Dlp7000Settings
from drivers.alp import plugin as module
from drivers.alp.binding import bind
from drivers.alp.library import Library
from drivers.alp.plugin import plugin
from protocols import BenchContext, DriverUnavailable, PatternModulator
from tests.drivers.alp.fake_alp import DEVICE, FakeAlp


def has_library(monkeypatch: pytest.MonkeyPatch, alp: FakeAlp) -> None:
    """Make the search find this table."""
    library = Library(bind(alp), "ALP-4.3 somewhere")

    def find(_setting: Path | None) -> Library:
        return library

    monkeypatch.setattr(module, "find_library", find)


def test_a_transport_takes_the_place_of_the_library() -> None:
    alp = FakeAlp()
    with plugin.open(plugin.settings(), BenchContext(clock=alp.clock, transport=alp)) as driver:
        assert isinstance(driver, PatternModulator)
        assert driver.identity.simulated
        assert "transport FakeAlp" in driver.identity.driver
    assert not alp.held


def test_something_else_as_transport_is_refused() -> None:
    with pytest.raises(DriverUnavailable, match="mend the transport"):
        plugin.open(plugin.settings(), BenchContext(transport="a serial port"))


def test_a_library_path_is_relative_to_bench_toml(tmp_path: Path) -> None:
    with pytest.raises(DriverUnavailable, match=str(tmp_path / "alp.so")):
        plugin.open(Dlp7000Settings(library=Path("alp.so")), BenchContext(folder=tmp_path))


def test_without_a_library_the_driver_says_what_is_missing() -> None:
    found = plugin.availability()
    if found.ready:
        pytest.skip("this machine has the vendor's library")
    assert "libalp43.so" in found.missing or "alp4395.dll" in found.missing
    assert plugin.probe() == ()


def test_with_a_library_the_driver_is_ready_and_finds_the_board(monkeypatch: pytest.MonkeyPatch) -> None:
    alp = FakeAlp()
    has_library(monkeypatch, alp)
    assert plugin.availability().version == "ALP-4.3 somewhere"
    assert alp.calls == [], "looking for the library touches no board"
    assert plugin.probe() == ("ALP board 4711, DMD type 4, through ALP-4.3 somewhere",)
    assert [call[0] for call in alp.calls] == [
        "AlpDevAlloc",
        "AlpDevInquire",
        "AlpDevInquire",
        "AlpDevHalt",
        "AlpDevFree",
    ]


HELD = "ALP board, held by another program, or by one that was killed"


@pytest.mark.parametrize(("code", "lines"), [(1001, ()), (1004, (HELD,))])
def test_a_probe_without_a_free_board_does_not_fail(
    monkeypatch: pytest.MonkeyPatch, code: int, lines: tuple[str, ...]
) -> None:
    alp = FakeAlp()
    alp.codes["AlpDevAlloc"] = code
    has_library(monkeypatch, alp)
    assert plugin.probe() == lines


def test_a_probe_that_breaks_lets_go_of_the_board(monkeypatch: pytest.MonkeyPatch) -> None:
    alp = FakeAlp()
    alp.codes["AlpDevInquire"] = 1011
    has_library(monkeypatch, alp)
    with pytest.raises(Exception, match="1011"):
        plugin.probe()
    assert alp.calls[-1] == ("AlpDevFree", DEVICE)


def test_an_unknown_setting_is_an_error() -> None:
    with pytest.raises(ValidationError, match="polarity"):
        Dlp7000Settings.model_validate({"polarity": "high"})
