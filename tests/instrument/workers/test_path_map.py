"""Workers that see other paths are told names that they know."""

from pathlib import Path

import pytest

from instrument.workers import PathMap
from protocols import InputError


def test_the_longest_folder_counts_and_what_lies_in_none_keeps_its_name() -> None:
    paths = PathMap.of(["/data=/mnt/lab", "/data/2026=/archive", "/home/ann=Z:\\ann"])
    assert paths.there("/data/may/run.h5") == "/mnt/lab/may/run.h5"
    assert paths.there("/data/2026/may/run.h5") == "/archive/may/run.h5"
    assert paths.there("/data") == "/mnt/lab"
    assert paths.there("/database/run.h5") == "/database/run.h5"
    assert paths.there("/home/ann/x/run.h5") == "Z:\\ann\\x\\run.h5"


def test_a_relative_path_is_made_absolute_on_both_sides(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert PathMap.of(["here=/there"]).there("here/run.h5") == "/there/run.h5"
    assert PathMap().there("run.h5") == str(tmp_path / "run.h5")


@pytest.mark.parametrize("entry", ["/data", "=/there", "/data="])
def test_an_entry_without_two_sides_is_refused(entry: str) -> None:
    with pytest.raises(InputError, match="HERE=THERE"):
        PathMap.of([entry])
