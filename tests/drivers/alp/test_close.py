"""Every way out: halted, freed, let go, whatever fails and wherever."""

from collections.abc import Callable
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import DeviceError, KinopixError, WrongState
from tests.drivers.alp.fake_alp import DEVICE, FUNCTIONS, FakeAlp
from tests.drivers.alp.patterns import TIMING, sequence

FIRST = 0x80000002
CODES = st.one_of(
    st.sampled_from([*range(1001, 1015), *range(1018, 1022), 1999]),
    st.integers(-(2**31), 2**31 - 1).filter(bool),
)


def whole_life(alp: FakeAlp) -> None:
    """Open, load, play, halt, close."""
    with alp.open() as driver:
        driver.load(sequence(), TIMING)
        driver.start()
        driver.wait(1.0)
        driver.start()
        driver.halt()


@pytest.mark.parametrize("leave", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_leaving_by_any_error_halts_frees_and_lets_go(leave: type[BaseException]) -> None:
    alp = FakeAlp()

    def leave_in_mid_run() -> None:
        with alp.open() as driver:
            driver.load(sequence(), TIMING)
            driver.start()
            raise leave

    with pytest.raises(leave):
        leave_in_mid_run()
    assert alp.calls[-4:] == [
        ("AlpDevHalt", DEVICE),
        ("AlpDevControl", DEVICE, 2064, 1),
        ("AlpSeqFree", DEVICE, FIRST),
        ("AlpDevFree", DEVICE),
    ]
    assert (alp.held, alp.sequences) == (False, {})


@pytest.mark.parametrize("broken", ["AlpDevHalt", "AlpSeqFree", "AlpDevFree"])
def test_each_step_of_closing_is_tried_even_if_another_fails(broken: str) -> None:
    alp = FakeAlp()
    driver = alp.open()
    driver.load(sequence(), TIMING)
    alp.codes[broken] = 1011
    alp.calls.clear()
    with pytest.raises(DeviceError, match=f"{broken}.*1011"):
        driver.close()
    assert [call[0] for call in alp.calls] == ["AlpDevHalt", "AlpSeqFree", "AlpDevFree"]


def test_all_failures_of_closing_are_told() -> None:
    alp = FakeAlp()
    driver = alp.open()
    alp.codes |= {"AlpDevHalt": 1011, "AlpDevFree": 1002}
    with pytest.raises(DeviceError, match="AlpDevHalt") as caught:
        driver.close()
    assert "AlpDevFree" in caught.value.__notes__[0]


def test_a_failure_while_leaving_does_not_hide_the_error_that_caused_it() -> None:
    alp = FakeAlp()

    def fail_twice() -> None:
        with alp.open():
            alp.codes["AlpDevFree"] = 1002
            raise ValueError("the first error")

    with pytest.raises(ValueError, match="the first error") as caught:
        fail_twice()
    assert "1002" in caught.value.__notes__[0]


def test_a_closed_device_is_closed_and_open_close_open_works() -> None:
    alp = FakeAlp()
    driver = alp.open()
    driver.close()
    alp.calls.clear()
    driver.close()
    driver.halt()
    assert not driver.running
    assert alp.calls == []
    for call in (driver.start, lambda: driver.load(sequence(), TIMING)):
        with pytest.raises(WrongState, match="closed device"):
            call()
    whole_life(alp)
    assert not alp.held


@given(place=st.integers(0, 60), code=CODES)
def test_any_code_from_any_call_is_a_kinopix_error_and_nothing_stays_held(place: int, code: int) -> None:
    alp = FakeAlp()
    alp.fail_at, alp.keep_opening = (place, code), True
    with suppress(KinopixError):
        whole_life(alp)
    failed = alp.calls[place][0] if place < len(alp.calls) else ""
    if failed == "AlpDevAlloc" and code not in (1001, 1011, 1012):
        assert [call[0] for call in alp.calls] == ["AlpDevAlloc"]
    else:
        assert alp.calls[-1] == ("AlpDevFree", DEVICE)
        assert (alp.held, alp.sequences) == (False, {}) or failed == "AlpDevFree"


@given(function=st.sampled_from(sorted(FUNCTIONS)), code=CODES, opened=st.booleans())
def test_a_function_that_always_fails_ends_in_an_error_and_the_device_is_let_go(
    function: str, code: int, *, opened: bool
) -> None:
    alp = FakeAlp()

    def live() -> None:
        if not opened:
            alp.codes[function] = code
        with alp.open() as driver:
            alp.codes[function] = code
            driver.load(sequence(), TIMING)
            driver.start()
            driver.wait(1.0)

    outcome = _outcome(live)
    if function == "AlpDevAlloc" and not opened:
        assert isinstance(outcome, KinopixError)
        return
    assert outcome is None or isinstance(outcome, KinopixError)
    used = {"AlpDevHalt", "AlpDevFree", "AlpSeqAlloc", "AlpSeqFree", "AlpSeqControl", "AlpSeqTiming", "AlpSeqInquire"}
    if function in used | {"AlpSeqPut", "AlpProjStart"}:
        assert isinstance(outcome, KinopixError)
    assert alp.calls[-1] == ("AlpDevFree", DEVICE)
    assert not alp.held or function == "AlpDevFree"


def _outcome(action: Callable[[], None]) -> Exception | None:
    try:
        action()
    except Exception as error:  # noqa: BLE001 - the test looks at what kind it is
        return error
    return None
