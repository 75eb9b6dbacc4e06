"""Makes the third-party distribution of ``plugins/`` look installed."""

import sys
from importlib import invalidate_caches
from pathlib import Path

import pytest

SITES = Path(__file__).parent / "plugins"


@pytest.fixture
def zha(monkeypatch: pytest.MonkeyPatch) -> None:
    """Installs kinopix-zha: one good scheme and eleven broken ones."""
    monkeypatch.setattr(sys, "path", [str(SITES / "zha"), *sys.path])
    invalidate_caches()
