"""The seam: 32-bit integers, cdecl, and a table that lacks a function."""

import ctypes
import inspect
from typing import Any

import pytest

from drivers.alp import Dlp7000, Dlp7000Settings
from drivers.alp.api import AlpApi, Id, Int, Pointer
from drivers.alp.binding import SIGNATURES, bind
from drivers.alp.structs import FlutWrite, ProjectionProgress
from protocols import DriverUnavailable
from tests.drivers.alp.fake_alp import FUNCTIONS, FakeAlp

_INT, _ID, _POINTER = ctypes.c_int32, ctypes.c_uint32, ctypes.c_void_p


class CLibrary(ctypes.CDLL):
    """A library whose functions are real C function pointers that lead to a ``FakeAlp``: ctypes converts every argument."""

    def __init__(self, alp: FakeAlp) -> None:  # pyright: ignore[reportMissingSuperCall] - nothing is loaded
        self.alp = alp
        self.keep: dict[str, Any] = {}

    def __getattr__(self, name: str) -> Any:
        if name not in FUNCTIONS:
            raise AttributeError(name)
        if name not in self.keep:
            self.keep[name] = ctypes.CFUNCTYPE(_INT, *SIGNATURES[name])(self._converter(name))
        return self.keep[name]

    def _converter(self, name: str) -> Any:
        def call(*raw: Any) -> int:
            arguments = [
                _pointer(name, value, raw) if kind is _POINTER else kind(value)
                for kind, value in zip(SIGNATURES[name], raw, strict=True)
            ]
            return self.alp.call(name, *arguments)

        return call


class _Reference:
    """What ``byref`` gives, made from an address."""

    def __init__(self, target: Any) -> None:
        self._obj = target


def _pointer(name: str, address: int, raw: tuple[int, ...]) -> Any:
    if name == "AlpSeqPut":
        return ctypes.c_void_p(address)
    kinds: dict[str, Any] = {"AlpProjControlEx": FlutWrite, "AlpProjInquireEx": ProjectionProgress}
    kind = _ID if name.endswith("Alloc") else kinds.get(name, _INT)
    return _Reference(kind.from_address(address))


def test_the_driver_lives_through_real_c_calls() -> None:
    from tests.drivers.alp.patterns import TIMING, sequence

    alp = FakeAlp()
    with Dlp7000(bind(CLibrary(alp)), Dlp7000Settings(), alp.clock, library="C") as driver:
        driver.load(sequence(3, [1, 2, 1, 0]), TIMING)
        driver.start()
        driver.wait(1.0)
    assert alp.flut == [1, 2, 1, 0]
    assert alp.stored[2] == sequence(3).mirror_plane(2).tobytes()
    assert ("AlpProjStart", 7, 0x80000002) in alp.calls, "ids above 2**31 stay unsigned"


def test_binding_a_c_library_sets_every_argument_type_to_32_bits_or_a_pointer() -> None:
    library = CLibrary(FakeAlp())
    bind(library)
    assert set(SIGNATURES) == FUNCTIONS
    for name in FUNCTIONS:
        function = library.keep[name]
        assert function.restype is _INT
        assert set(function.argtypes) <= {_INT, _ID, _POINTER}
    assert library.keep["AlpSeqTiming"].argtypes == [_ID, _ID, _INT, _INT, _INT, _INT, _INT]
    assert library.keep["AlpProjInquire"].argtypes == [_ID, _INT, _POINTER], "no sequence id"


def test_the_typed_table_and_the_c_signatures_tell_the_same() -> None:
    for name, arguments in SIGNATURES.items():
        taken = list(inspect.signature(getattr(AlpApi, name)).parameters.values())[1:]
        kinds = {Int: _INT, Id: _ID, Pointer: _POINTER, ctypes.c_void_p: _POINTER}
        assert tuple(kinds[parameter.annotation] for parameter in taken) == arguments, name


def test_a_table_without_a_function_is_refused_by_name() -> None:
    class Half(FakeAlp):
        def __getattr__(self, name: str) -> Any:
            if name == "AlpSeqPut":
                raise AttributeError(name)
            return super().__getattr__(name)

    with pytest.raises(DriverUnavailable, match="without AlpSeqPut; expected the 16 functions"):
        bind(Half())


def test_the_systems_own_c_library_is_not_an_alp_library() -> None:
    with pytest.raises(DriverUnavailable, match="without AlpDevAlloc"):
        bind(ctypes.CDLL(None))


def test_structures_have_the_sizes_of_the_packed_header() -> None:
    assert ctypes.sizeof(FlutWrite) == 4 + 4 + 4 * 4096
    assert _offset(FlutWrite, "FrameNumbers") == 8
    assert ctypes.sizeof(ProjectionProgress) == 9 * 4
    assert _offset(ProjectionProgress, "nFrameCounter") == 20


def _offset(structure: type[ctypes.Structure], field: str) -> int:
    """Bytes before a field."""
    return int(getattr(structure, field).offset)
