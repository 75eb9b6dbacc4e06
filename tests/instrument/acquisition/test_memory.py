"""Whether a plan fits into this computer: the figures, and where they come from."""

from pathlib import Path

import pytest

from instrument.acquisition.memory import analysis_bytes, available_bytes, recording_bytes
from instrument.plan import Plan
from tests.support.plans import plan_of


def test_the_need_grows_with_patterns_and_with_the_hadamard_patterns() -> None:
    """230 MB of program, 1024 bytes a pattern, 2.5 bytes a pixel of each of 1,666 Hadamard patterns."""
    assert analysis_bytes(Plan(frames=1666)) == 230_000_000 + 9996 * 1024 + 1666 * 128**2 * 5 // 2
    assert analysis_bytes(Plan(frames=1666, image_size=16)) == 230_000_000 + 9996 * 1024 + 256 * 16**2 * 5 // 2
    assert recording_bytes(Plan(frames=1666)) == 230_000_000 + 9996 * 128 + 1666 * 128**2 * 5 // 2
    assert analysis_bytes(plan_of("fourier-3step", 100)) == 230_000_000 + 600 * 1024  # tracking alone


def test_what_is_available_is_read_from_the_system(tmp_path: Path) -> None:
    (tmp_path / "meminfo").write_text("MemTotal: 9000 kB\nMemFree: 10 kB\nMemAvailable:    4000 kB\n")
    assert available_bytes(tmp_path / "meminfo", tmp_path) == 4_096_000
    (tmp_path / "memory.max").write_text("max\n")
    (tmp_path / "memory.current").write_text("500000\n")
    assert available_bytes(tmp_path / "meminfo", tmp_path) == 4_096_000
    (tmp_path / "memory.max").write_text("2000000\n")
    assert available_bytes(tmp_path / "meminfo", tmp_path) == 1_500_000


def test_without_proc_the_memory_of_the_computer_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def sysconf(name: str) -> int:
        return {"SC_PHYS_PAGES": 1000, "SC_PAGE_SIZE": 4096}[name]

    monkeypatch.setattr("instrument.acquisition.memory.os.sysconf", sysconf, raising=False)
    assert available_bytes(tmp_path / "none", tmp_path) == 4_096_000

    def unknown(_name: str) -> int:
        raise ValueError

    monkeypatch.setattr("instrument.acquisition.memory.os.sysconf", unknown, raising=False)
    assert available_bytes(tmp_path / "none", tmp_path) is None
