"""Every row of the fact sheet's error table (section 4.5) against NI's own names and the error tree."""

import pytest
from nidaqmx.error_codes import DAQmxErrors

from drivers.ni.errors import MEANINGS, NiFault, Progress, typed_error
from protocols import (
    CounterOverrun,
    DeviceBusy,
    DeviceDisconnected,
    DeviceRefused,
    DeviceTimeout,
    DriverUnavailable,
    KinopixError,
    TimingFault,
    TriggerMissed,
)

CLASSES: dict[type[KinopixError], list[int]] = {
    TriggerMissed: [-200284],
    CounterOverrun: [-200279, -200222, -200361, -200010, -209829, -200141],
    TimingFault: [-201314, -200313, -200314],
    DriverUnavailable: [-200170, -200220],
    DeviceDisconnected: [-201003, -200324, -88709, -88710],
    DeviceBusy: [-200022, -50103, -89137],
    DeviceTimeout: [-200474, -200560],
    DeviceRefused: [
        *[-200278, -201313, -200140, -200303, -200145, -200147],
        *[-89136, -89120, -200077, -200089, -201025],
    ],
}


@pytest.mark.parametrize(("kind", "code"), [(kind, code) for kind, codes in CLASSES.items() for code in codes])
def test_each_code_is_its_own_branch_of_the_tree(kind: type[KinopixError], code: int) -> None:
    error = typed_error(NiFault("words", code), device="pmt", progress=Progress(7, 9996, 1.5))
    assert type(error) is kind
    assert error.remedy
    assert str(error).startswith("pmt: ")


def test_the_table_has_these_codes_and_no_others() -> None:
    assert sorted(MEANINGS) == sorted(code for codes in CLASSES.values() for code in codes)


@pytest.mark.parametrize("code", sorted(set(MEANINGS)))
def test_the_names_are_those_of_the_nidaqmx_package(code: int) -> None:
    assert DAQmxErrors(code).name == MEANINGS[code].name


def test_a_lost_sample_says_how_far_the_run_had_come() -> None:
    error = typed_error(NiFault("", -200279), device="pmt", progress=Progress(4000, 9996, 0.2))
    assert "SAMPLES_NO_LONGER_AVAILABLE, code -200279" in str(error)
    assert "4000 bins counted" in str(error)
    assert "raise buffer_s" in error.remedy


def test_missing_edges_name_bins_read_and_edges_expected() -> None:
    error = typed_error(NiFault("", -200284), device="pmt", progress=Progress(4000, 9996, 0.2))
    assert "4000 of 9996 patterns counted, then no sync edge for 0.2 s" in str(error)
    assert "9997 sync edges" in str(error)


def test_an_unknown_code_keeps_nis_own_words() -> None:
    error = typed_error(NiFault("Something\n\nnew.", -123456), device="pmt")
    assert isinstance(error, DeviceRefused)
    assert error.code == "-123456"
    assert "'Something new'" in str(error)


def test_a_missing_runtime_says_what_to_install() -> None:
    error = typed_error(NiFault("Could not find an installation of NI-DAQmx."), device="pmt")
    assert isinstance(error, DriverUnavailable)
    assert "pip install 'kinopix[ni]'" in str(error)


def test_a_lost_server_is_a_disconnection_and_another_rpc_failure_is_not() -> None:
    assert isinstance(typed_error(NiFault("", rpc_code="UNAVAILABLE"), device="pmt"), DeviceDisconnected)
    assert isinstance(typed_error(NiFault("", rpc_code="UNIMPLEMENTED"), device="pmt"), DriverUnavailable)
