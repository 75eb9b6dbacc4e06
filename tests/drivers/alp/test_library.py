"""The search for the vendor's library, on computers that are described and not there."""

from collections.abc import Callable
from pathlib import Path

import pytest

from drivers.alp.library import Machine, find_library
from protocols import DriverUnavailable
from tests.drivers.alp.fake_alp import FakeAlp


def loader(*present: str, tried: list[str] | None = None) -> Callable[[str], object]:
    """Loads what is present; anything else is missing."""

    def load(path: str) -> object:
        if tried is not None:
            tried.append(path)
        if path not in present:
            raise OSError(f"{path}: cannot open shared object file: No such file or directory")
        return FakeAlp()

    return load


def windows(bits: int = 64, *present: str, tried: list[str] | None = None) -> Machine:
    """A Windows computer on which ALP-4.3 is registered."""
    registry = {"4.3": r"C:\Program Files\ALP-4.3"}
    return Machine(windows=True, bits=bits, registry_path=registry.get, load=loader(*present, tried=tried))


@pytest.mark.parametrize(
    ("bits", "path"),
    [
        (64, r"C:\Program Files\ALP-4.3\ALP-4.3 high-speed API\x64\alp4395.dll"),
        (32, r"C:\Program Files\ALP-4.3\ALP-4.3 high-speed API\alp4395.dll"),
    ],
)
def test_windows_asks_the_registry_and_takes_the_folder_of_its_word_size(bits: int, path: str) -> None:
    assert find_library(None, windows(bits, path)).label == f"ALP-4.3 {path}"


def test_linux_looks_into_the_vendors_folder_and_then_asks_the_loader() -> None:
    tried: list[str] = []
    machine = Machine(windows=False, load=loader("libalp41.so", tried=tried))
    assert find_library(None, machine).label == "ALP-4.1 libalp41.so"
    folder = "/usr/lib/x86_64-linux-gnu/"
    assert tried == [
        *(f"{folder}libalp{n}.so" for n in (44, 43, 42, 41, 51, 50)),
        "libalp44.so",
        "libalp43.so",
        "libalp42.so",
        "libalp41.so",
    ]


def test_a_path_in_the_settings_is_the_only_one_tried() -> None:
    tried: list[str] = []
    machine = Machine(windows=False, load=loader("libalp43.so", tried=tried))
    with pytest.raises(
        DriverUnavailable, match=r"library: /opt/mine.so \(cannot open shared object file: No such.*\); expected"
    ):
        find_library(Path("/opt/mine.so"), machine)
    assert tried == ["/opt/mine.so"]


def test_the_basic_api_is_refused_by_name() -> None:
    with pytest.raises(DriverUnavailable, match="'basic' API"):
        find_library(Path("alpV42basic.dll"), windows(64, "alpV42basic.dll"))


def test_a_search_in_vain_names_every_library_once_and_where_it_was_looked_for() -> None:
    with pytest.raises(DriverUnavailable) as caught:
        find_library(None, windows())
    report = str(caught.value)
    for name in ("Alp44.dll", "alp4395.dll", "alpV42.dll", "alpD41.dll", "alp51.dll", "alp50.dll"):
        assert report.count(name) == 1
    assert "neither in the folders that ViALUX's installer registers nor where the system looks" in report
    assert "64-bit" in report
    assert 'set library = "<file>"' in report


def test_a_library_that_is_there_and_does_not_load_is_told_with_the_reason() -> None:
    def load(path: str) -> object:
        raise OSError(f"{path}: wrong ELF class: ELFCLASS32" if "43" in path else f"{path}: No such file or directory")

    with pytest.raises(DriverUnavailable) as caught:
        find_library(None, Machine(windows=False, load=load))
    report = str(caught.value)
    assert "/usr/lib/x86_64-linux-gnu/libalp43.so (wrong ELF class: ELFCLASS32)" in report
    assert (
        "libalp44.so, libalp42.so, libalp41.so, libalp51.so, libalp50.so neither in /usr/lib/x86_64-linux-gnu nor"
        in report
    )


def test_a_library_without_the_functions_is_passed_over_and_reported() -> None:
    machine = Machine(windows=False, load=lambda _path: object())
    with pytest.raises(DriverUnavailable, match=r"libalp43.so .an ALP function table without AlpDevAlloc, AlpDevHalt"):
        find_library(None, machine)
