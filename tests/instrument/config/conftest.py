"""Makes the third-party distributions of ``plugins/`` look installed."""

import sys
from importlib import invalidate_caches
from pathlib import Path

import pytest

SITES = Path(__file__).parent / "plugins"


def _install(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(SITES / name), *sys.path])
    invalidate_caches()


@pytest.fixture
def acme(monkeypatch: pytest.MonkeyPatch) -> None:
    """Installs kinopix-acme: a modulator, a stage, a transport, a scene, one good counter and six broken ones."""
    _install("acme", monkeypatch)


@pytest.fixture
def rival(acme: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Installs kinopix-rival beside it, which offers the counter ``acme-counter`` too."""
    _install("rival", monkeypatch)
