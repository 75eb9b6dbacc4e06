"""Registers, units and axes of both boxes, with the field values and ranges of ka400z.md 3A to 3C."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim_backends.wire.stepper.motion import Rates, Trapezoid
from tests.sim_backends.wire.zolix.host import mc600, sc300


def test_a_rotary_stage_of_ratio_180_turns_by_an_800th_of_a_degree_a_pulse() -> None:
    """Section 3B, field values: 360 / (1600 x 180) = 0.00125 degrees a pulse, so that 1 degree is 800 pulses."""
    host = mc600()
    for sent in (b"SetStageStyle X,R\r", b"SetStageStepsRev X,1600\r", b"SetStageDriveRat X,180\r", b"SetUnit X,d\r"):
        assert host.ask(sent) == b"OK\r"
    assert host.ask(b"GoPosition X,O,R,P,1\r") == b"READY\r"
    assert host.line() == b"X 1.000,OK\r"
    assert host.ask(b"SetUnit X,s\r") == b"OK\r"
    assert host.ask(b"Position? X\r") == b"POSITION? X,800.0,OK\r"


@pytest.mark.parametrize(
    ("verb", "um", "mm"),
    [("SetSpeed", 15_000, 15), ("SetInitSpeed", 6000, 6), ("SetAccSpeed", 10_000, 10), ("SetHomeSpeed", 4000, 4)],
)
def test_field_values_in_micrometres_are_those_in_millimetres(verb: str, um: int, mm: int) -> None:
    """Section 3B, field values of a linear stage: pitch 4, 1600 a turn, unit um."""
    host = mc600()
    for sent in ("SetStagePitch X,4", "SetStageStepsRev X,1600", "SetUnit X,u", f"{verb} X,{um}"):
        assert host.ask(f"{sent}\r".encode()) == b"OK\r"
    assert host.ask(f"{verb}? X\r".encode()) == f"{verb.upper()}? X,{um}.0,OK\r".encode()
    host.ask(b"SetUnit X,m\r")
    assert host.ask(f"{verb}? X\r".encode()) == f"{verb.upper()}? X,{mm}.000,OK\r".encode()


@pytest.mark.parametrize(
    ("sent", "answered"),
    [
        ("SetStagePitch X,999.9", b"OK\r"),
        ("SetStagePitch X,1000", b"E01\r"),
        ("SetStagePitch X,-4", b"E01\r"),
        ("SetStageStepsRev X,9999999", b"OK\r"),
        ("SetStageStepsRev X,10000000", b"E01\r"),
        ("SetStageStepsRev X,0", b"E01\r"),
        ("SetStageDriveRat X,9999", b"OK\r"),
        ("SetStageDriveRat X,10000", b"E01\r"),
        ("SetStageDriveRat X,0", b"E01\r"),
        ("SetInitSpeed X,-1", b"E01\r"),
        ("SetAccSpeed X,0", b"E01\r"),
        ("SetHomeSpeed X,0", b"E01\r"),
        ("SetSpeed X,.5", b"OK\r"),
        ("SetSpeed X,1e3", b"E01\r"),
        ("SetOrigin X,N", b"OK\r"),
        ("SetOrigin X,U", b"E01\r"),
        ("Setsechhomemode X,1", b"OK\r"),
        ("Setsechhomemode X,3", b"E01\r"),
        ("SetUserLimitAble X,E", b"OK\r"),
        ("SetUserLimitAble X,ED", b"E01\r"),
        ("SetStageStyle X,R", b"OK\r"),
        ("SetStageWorkState X,C", b"OK\r"),
        ("SetStageWorkState X,P", b"E01\r"),
    ],
)
def test_a_register_takes_what_the_sheet_lists_and_keeps_its_value_otherwise(sent: str, answered: bytes) -> None:
    """Words of 3B; 3C has 0 < pitch < 1000, 0 < pulses a turn < 1e7 and 0 < ratio < 1e4."""
    host = mc600()
    verb = sent.split(" ", maxsplit=1)[0]
    before = host.ask(f"{verb}? X\r".encode())
    assert host.ask(f"{sent}\r".encode()) == answered
    after = host.ask(f"{verb}? X\r".encode())
    assert (after == before) is (answered == b"E01\r")


def test_each_axis_has_registers_and_a_position_of_its_own() -> None:
    """Four axes, X, Y, Z and T; no fifth."""
    host = mc600(unit="s")
    for number, axis in enumerate("XYZT", 1):
        host.ask(f"GoPosition {axis},O,R,N,{number}\r".encode())
        assert host.line() == f"{axis} -{number}.0,OK\r".encode()
    assert host.ask(b"SetSpeed Z,77\r") == b"OK\r"
    assert host.ask(b"SetSpeed? T\r") == mc600(unit="s").ask(b"SetSpeed? T\r")
    assert host.ask(b"Position? Y\r") == b"POSITION? Y,-2.0,OK\r"
    assert host.ask(b"Position? U\r") == b"E01\r"


def test_several_axes_go_home_and_the_others_stay() -> None:
    """Section 3B: GonAxisHome has a Y or an N for each of X, Y, Z, T."""
    host = mc600(unit="s")
    for axis in "XYZT":
        host.ask(f"GoPosition {axis},O,R,P,40\r".encode())
        host.line()
    assert host.ask(b"GonAxisHome N,Y,N,Y\r") == b"READY\r"
    assert sorted([host.line(), host.line()]) == [b"T 0.0,OK\r", b"Y 0.0,OK\r"]
    assert [host.ask(f"Position? {axis}\r".encode()) for axis in "XYZT"] == [
        b"POSITION? X,40.0,OK\r", b"POSITION? Y,0.0,OK\r", b"POSITION? Z,40.0,OK\r", b"POSITION? T,0.0,OK\r"
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("target", "answered"), [("P,5", b"READY\r"), ("P,5.01", b"E02\r"), ("N,3", b"READY\r"), ("N,3.01", b"E02\r")]
)
def test_soft_limits_belong_to_the_range_and_are_off_until_switched_on(target: str, answered: bytes) -> None:
    """Section 3B: E on, D off. From -3 to 5 mm; pulses of 2.5 um."""
    host = mc600(soft_limit="refuse", travel_mm=[-50.0, 50.0])
    for sent in (b"SetUserPositiveLimit X,5\r", b"SetUserNegativeLimit X,-3\r", b"SetUserLimitAble X,E\r"):
        assert host.ask(sent) == b"OK\r"
    assert host.ask(f"GoPosition X,O,A,{target}\r".encode()) == answered
    host.rest()
    host.ask(b"SetUserLimitAble X,D\r")
    assert host.ask(b"GoPosition X,O,A,P,9\r") == b"READY\r"


@settings(max_examples=25, deadline=None)
@given(pulses=st.integers(-20_000, 20_000), unit=st.sampled_from(["m", "u", "s"]))
def test_where_an_axis_is_sent_it_says_that_it_is(pulses: int, unit: str) -> None:
    """400 pulses a millimetre: 0.0025 mm or 2.5 um each. The sign is a letter, the number has none."""
    host = mc600(unit=unit, travel_mm=[-60.0, 60.0])
    value = pulses / {"m": 400, "u": 0.4, "s": 1}[unit]
    sent = f"GoPosition X,O,A,{'N' if pulses < 0 else 'P'},{abs(value):f}\r".encode()
    assert host.ask(sent) == b"READY\r"
    name, told = host.line().split(b" ")
    assert name == b"X"
    assert float(told.removesuffix(b",OK\r")) == pytest.approx(value, abs=6e-4 if unit == "m" else 0.051)
    assert host.controller.reported_mm() == pytest.approx(pulses / 400)


def test_sc300_speeds_are_read_back_by_the_letters_swapped() -> None:
    """Section 3A: the settings of a turntable in the field, V = 20000, A = 30000, F = 2500; each axis has its own."""
    host = sc300(axes="XY")
    for sent in (b"VX,20000\r", b"AX,30000\r", b"FX,2500\r"):
        assert host.ask(sent) == b"OK\r"
    answers = [host.ask(sent) for sent in (b"XV\r", b"XA\r", b"XF\r", b"YV\r", b"YA\r", b"YF\r")]
    assert answers == [b"XV,20000\r", b"XA,30000\r", b"XF,2500\r", b"YV,8000\r", b"YA,16000\r", b"YF,1000\r"]


@pytest.mark.parametrize(
    ("sent", "answered"), [(b"VX,9999999\r", b"OK\r"), (b"VX,10000000\r", b"E0\r"), (b"VX,\r", b"E0\r")]
)
def test_an_sc300_takes_numbers_of_one_to_seven_digits(sent: bytes, answered: bytes) -> None:
    assert sc300().ask(sent) == answered


def test_sc300_positions_add_up_with_their_signs() -> None:
    """Section 3A: moves are relative and the number is unsigned."""
    host = sc300(travel_mm=[-100.0, 100.0])
    for sent, position in ((b"+X,300\r", 300), (b"-X,1000\r", -700), (b"+X,650\r", -50)):
        host.port.write(sent)
        assert host.line() == f"?X,{position}\r".encode()
    assert host.ask(b"?X\r") == b"?X,-50\r"


@given(
    distance=st.floats(1, 1e5),
    top=st.floats(10, 2e4),
    initial=st.floats(0, 1e4),
    acceleration=st.floats(10, 1e5),
)
def test_a_trapezoid_takes_the_time_and_has_the_peak_of_the_sheet(
    distance: float, top: float, initial: float, acceleration: float
) -> None:
    """Section 5.1: s_r = (v^2 - v0^2) / 2a; 2 (v - v0) / a + (d - 2 s_r) / v, or a triangle with v_p = sqrt(a d + v0^2).

    An initial speed above the top speed counts as the top speed.
    """
    start = min(initial, top)
    ramp = (top**2 - start**2) / (2 * acceleration)
    if 2 * ramp <= distance:
        peak = top
        duration = 2 * (top - start) / acceleration + (distance - 2 * ramp) / top
    else:
        peak = math.sqrt(acceleration * distance + start**2)
        duration = 2 * (peak - start) / acceleration
    for sign in (1, -1):
        move = Trapezoid(sign * distance, Rates(top, initial, acceleration))
        assert move.duration_s == pytest.approx(duration, rel=1e-6)
        assert move.speed(move.duration_s / 2) == pytest.approx(sign * peak, rel=1e-6)
