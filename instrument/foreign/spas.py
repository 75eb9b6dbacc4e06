"""The pair of files that SPAS writes: NAME_spectraldata.npz and NAME_metadata.json.

SPAS (github.com/openspyrit/spas) shows split Walsh patterns to a spectrometer. What is known of its files is read from its own
``metadata.py`` (names of the fields; lists are stored as text), ``generate.py`` (pattern 2k is H+ of row k of the Walsh matrix in
two dimensions, pattern 2k + 1 its complement; row k has k // m sign changes down and k % m across) and ``acquisition.py``
(``spectral_data`` has a row for each pattern as it was shown, a column for each wavelength).
"""

import json
from pathlib import Path
from typing import Any, Final, cast

import numpy as np

from instrument.config import RunTable
from instrument.foreign.arrays import arrays_of
from instrument.foreign.pairs import HadamardPairs
from protocols import Floats, InputError, Integers
from protocols.plain_file import NoPlainFile, path_of, read_plain

DATA: Final = "_spectraldata.npz"
METADATA: Final = "_metadata.json"
_MOST_METADATA_BYTES: Final = 100_000_000


def is_spas(path: str | Path) -> bool:
    """Whether a name is that of one of the pair."""
    return path_of(path).name.endswith((DATA, METADATA))


def read_spas(path: str | Path, band_nm: tuple[float, float] | None = None) -> HadamardPairs:
    """Read a pair of files, of which one is named. The light of a pattern is the sum over its spectrum, or over a band of it.

    Args:
        path: either file.
        band_nm: first and last wavelength that are summed; None for all.

    Raises:
        InputError: one of the files is missing or damaged, they do not belong together, or patterns were shown that have no
            scheme here.
    """
    path = path_of(path)
    name = path.name.removesuffix(DATA).removesuffix(METADATA)
    tables = _tables(path.with_name(name + METADATA))
    people, acquisition, modulator = (
        tables.get(table, {}) for table in ("Metadata", "Acquisition parameters", "DMD parameters")
    )
    spectra = arrays_of(path.with_name(name + DATA)).get("spectral_data")
    size = _size(acquisition, name)
    shown = _numbers(acquisition, "patterns").astype(np.int64)
    if spectra is None or spectra.ndim != 2 or spectra.dtype.kind not in "iuf" or len(spectra) != len(shown):
        what = "none" if spectra is None else f"of shape {spectra.shape}"
        raise _refused(name, f"spectral_data {what} for {len(shown)} patterns", "a row for each pattern that was shown")
    light = _light(np.asarray(spectra, np.float64), acquisition, band_nm, name)
    time_us: Any = modulator.get("picture_time_us")
    prefix = str(people.get("pattern_prefix", ""))
    doubts = (
        ()
        if prefix.lower().startswith("walsh")
        else (f"the patterns are called {prefix!r} and are taken for Walsh patterns",)
    )
    return HadamardPairs(
        image_size=size,
        pairs=_pairs(shown, size, name),
        values=light.reshape(-1, 2),
        picture_time_s=time_us * 1e-6 if isinstance(time_us, int | float) and time_us > 0 else None,
        about=_about(name, people),
        missing=(*doubts, "the light was measured by a spectrometer: it is a sum of its readings, and no count"),
        origin={"file": name + DATA, "metadata": json.dumps([people, modulator], default=str)},
    )


def _tables(path: Path) -> dict[str, dict[str, Any]]:
    """The tables of the metadata, by what they call themselves."""
    try:
        found: Any = json.loads(read_plain(path, _MOST_METADATA_BYTES))
    except NoPlainFile as error:
        raise _refused(path.name, str(error.strerror), "a plain file") from error
    except OSError as error:
        raise _refused(path.name, error.strerror or str(error), "both files of the pair, in one folder") from error
    except (ValueError, RecursionError) as error:
        raise _refused(path.name, f"no JSON ({error})", "metadata as SPAS writes them") from error
    if not isinstance(found, list) or not all(isinstance(table, dict) for table in cast("list[object]", found)):
        raise _refused(path.name, "JSON that is no list of tables", "metadata as SPAS writes them")
    tables = cast("list[dict[str, Any]]", found)
    return {str(table.get("class_description")): table for table in tables}


def _size(acquisition: dict[str, Any], name: str) -> int:
    across, down = acquisition.get("pattern_dimension_x"), acquisition.get("pattern_dimension_y")
    if not isinstance(across, int) or across != down or across < 8 or across & (across - 1):
        raise _refused(
            name, f"patterns of {across} x {down} px", "square patterns whose side is a power of two, 8 or more"
        )
    if acquisition.get("mask_index"):
        raise _refused(name, "patterns in a mask", "patterns that fill their square")
    return across


def _numbers(table: dict[str, Any], key: str) -> Floats:
    """A list that is stored as text, such as ``"[0, 1, 2]"``; empty where it is missing or was cut short by numpy."""
    text: Any = table.get(key)
    if isinstance(text, list):
        text = " ".join(map(str, cast("list[object]", text)))
    try:
        return np.array([float(number) for number in str(text or "").strip("[] \n").replace(",", " ").split()])
    except (ValueError, TypeError):
        return np.zeros(0)


def _pairs(shown: Integers, size: int, name: str) -> Integers:
    """``(n, 2)``: Walsh rows of patterns that come as H+ and H- in turn."""
    first, second = shown[::2], shown[1::2]
    if not len(shown) or len(shown) % 2 or np.any(first % 2) or np.any(second != first + 1):
        raise _refused(name, "patterns that are no pairs", "each pattern and its complement in turn: 2k, 2k + 1")
    rows = first // 2
    if rows.min() < 0 or rows.max() >= size * size:
        raise _refused(
            name, f"pattern {int(shown.max())}", f"patterns 0 to {2 * size * size - 1} of {size} x {size} px"
        )
    return np.stack([rows // size, rows % size], axis=1)


def _light(spectra: Floats, acquisition: dict[str, Any], band_nm: tuple[float, float] | None, name: str) -> Floats:
    if band_nm is None:
        return np.asarray(spectra.sum(axis=1))
    wavelengths_nm = _numbers(acquisition, "wavelengths")
    if len(wavelengths_nm) != spectra.shape[1]:
        raise _refused(name, f"{len(wavelengths_nm)} wavelengths for {spectra.shape[1]} columns", "one for each column")
    inside = (wavelengths_nm >= band_nm[0]) & (wavelengths_nm <= band_nm[1])
    if not inside.any():
        raise _refused(
            name,
            f"no wavelength from {band_nm[0]:g} to {band_nm[1]:g} nm",
            f"a band within {wavelengths_nm.min():g} to {wavelengths_nm.max():g} nm",
        )
    return np.asarray(spectra[:, inside].sum(axis=1))


def _about(name: str, people: dict[str, Any]) -> RunTable:
    """What the metadata tell people, without what no text has."""

    def said(key: str, most: int) -> str:
        return "".join(c for c in str(people.get(key) or "") if c.isprintable())[:most]

    facts = ("description", "light_source", "filter", "date", "time")
    notes = "\n".join(f"{fact}: {text}" for fact in facts if (text := said(fact, 1000)))
    return RunTable(title=said("experiment_name", 200) or name[:200], sample=said("object", 200), notes=notes)


def _refused(name: str, saw: str, expected: str) -> InputError:
    return InputError(
        saw=f"{name}: {saw}",
        expected=expected,
        remedy="give the pair of files of one acquisition by SPAS: NAME_spectraldata.npz and NAME_metadata.json",
    )
