"""What differs from one family of NI boards to another: the filters of a line, and how close two pulses may be.

X Series User Manual, table 8-1 (PFI filters) and page 7-47; M Series and USB-621x manuals, the same tables; NI 660x manual,
page 2-7: with duplicate-count prevention the source may have a quarter of the fastest timebase at most.
"""

from dataclasses import dataclass

from protocols import InputError

_M_SERIES = ("621", "622", "625", "628")


@dataclass(frozen=True)
class Family:
    """One family."""

    name: str
    filters_s: tuple[float, ...]
    """Widths that every pulse longer than passes; the board has these and no others."""

    custom_filters: bool
    """Whether other widths can be made from a timebase, in steps of 25 ns or 10 us."""


X_SERIES = Family("X series", (90e-9, 5.12e-6, 2.56e-3), custom_filters=True)
M_SERIES = Family("M series", (125e-9, 6.425e-6, 2.55e-3), custom_filters=False)


def family_of(product: str) -> Family | None:
    """Tell the family by the product's number: 63xx is X, 621x to 628x is M; None: neither.

    >>> family_of("PCIe-6321").name
    'X series'
    >>> family_of("USB-6218 (BNC)").name
    'M series'
    """
    number = next((part[:4] for part in product.replace("-", " ").split() if part[:4].isdigit()), "")
    if number.startswith("63"):
        return X_SERIES
    return M_SERIES if number[:3] in _M_SERIES else None


def dead_time_s(max_timebase_hz: float) -> float:
    """Pulse pairs that merge: four periods of the fastest timebase.

    >>> round(dead_time_s(100e6) * 1e9)
    40
    """
    return 4 / max_timebase_hz


def check_filter(product: str, width_s: float | None, device: str) -> None:
    """Hold a filter against the board's own widths.

    Raises:
        InputError: a width that this family does not have; names those that it has.
    """
    family = family_of(product)
    if width_s is None or family is None or family.custom_filters:
        return
    if all(abs(width_s / known_s - 1) > 1e-3 for known_s in family.filters_s):
        raise InputError(
            device=device,
            saw=f"sync_filter_s = {width_s:g} on a {product}",
            expected="one of " + ", ".join(f"{known_s:g}" for known_s in family.filters_s) + f" ({family.name})",
            remedy="set sync_filter_s to one of them under [counter] in bench.toml, or leave it out",
        )
