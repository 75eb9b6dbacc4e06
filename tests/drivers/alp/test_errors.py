"""Return codes: each a typed error that says what to do."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.alp.errors import error_of
from protocols import DeviceBusy, DeviceDisconnected, DeviceError, DeviceRefused, DriverUnavailable, WrongState


@pytest.mark.parametrize(
    ("code", "name", "error", "remedy"),
    [
        (1001, "ALP_NOT_ONLINE", DeviceDisconnected, "power"),
        (1002, "ALP_NOT_IDLE", DeviceBusy, "halt"),
        (1003, "ALP_NOT_AVAILABLE", DeviceRefused, "open it again"),
        (1004, "ALP_NOT_READY", DeviceBusy, "close the other program"),
        (1005, "ALP_PARM_INVALID", DeviceRefused, "limits"),
        (1006, "ALP_ADDR_INVALID", DeviceRefused, "load the patterns again"),
        (1007, "ALP_MEMORY_FULL", DeviceRefused, "fewer frames"),
        (1008, "ALP_SEQ_IN_USE", DeviceBusy, "halt"),
        (1009, "ALP_HALTED", WrongState, "load the patterns again"),
        (1010, "ALP_ERROR_INIT", DeviceRefused, "switch the board off"),
        (1011, "ALP_ERROR_COMM", DeviceDisconnected, "USB cable"),
        (1012, "ALP_DEVICE_REMOVED", DeviceDisconnected, "plug the board in"),
        (1013, "ALP_NOT_CONFIGURED", DeviceRefused, "switch the board off"),
        (1014, "ALP_LOADER_VERSION", DriverUnavailable, "USB driver"),
        (1018, "ALP_ERROR_POWER_DOWN", DeviceRefused, "switch the board off"),
        (1019, "ALP_DRIVER_VERSION", DriverUnavailable, "update"),
        (1020, "ALP_SDRAM_INIT", DeviceRefused, "switch the board off"),
        (1021, "ALP_CONFIG_MISMATCH", DeviceRefused, "ALP version"),
        (1999, "ALP_ERROR_UNKNOWN", DeviceRefused, "report"),
    ],
)
def test_every_code_of_the_header_has_its_error(code: int, name: str, error: type[DeviceError], remedy: str) -> None:
    found = error_of(code, "AlpSeqPut", "dmd")
    assert type(found) is error
    assert str(found).startswith(f"dmd: saw AlpSeqPut answer {name}: ")
    assert f"(code {code})" in str(found)
    assert remedy in found.remedy
    if isinstance(found, DeviceRefused):
        assert found.code == str(code)


@pytest.mark.parametrize("code", [1001, 1011, 1012])
def test_a_board_that_is_not_there_when_looked_for_is_an_unavailable_driver(code: int) -> None:
    assert type(error_of(code, "AlpDevAlloc", "dmd")) is DriverUnavailable


@given(code=st.integers(-(2**31), 2**31 - 1).filter(lambda code: not 1001 <= code <= 1999))
def test_unknown_codes_are_refusals_that_keep_the_code(code: int) -> None:
    found = error_of(code, "AlpProjStart", "dmd")
    assert isinstance(found, DeviceRefused)
    assert found.code == str(code)
    assert "no known header" in str(found)
