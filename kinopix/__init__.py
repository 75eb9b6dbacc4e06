"""Kinopix: instrument control for single-pixel imaging of moving objects.

``import kinopix`` gives the names that a lab script needs; each loads what it stands on when it is first used.
"""

from typing import Any

from kinopix.own_packages import claim_packages

claim_packages()

import instrument  # noqa: E402 - its name must be claimed before

__all__ = list(instrument.__all__)  # pyright: ignore[reportUnsupportedDunderAll] - the names stand in __init__.pyi


def __getattr__(name: str) -> Any:
    """Give a public name of the framework."""
    if name in __all__:
        return getattr(instrument, name)
    raise AttributeError(f"module 'kinopix' has no attribute {name!r}")


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
