"""Lines as the fact sheet has them."""

import pytest

from drivers.grbl.codec import (
    Alarm,
    Event,
    Okay,
    Other,
    Refused,
    Report,
    Setting,
    Version,
    Welcome,
    jog_to,
    understand,
    write_setting,
)


@pytest.mark.parametrize(
    ("line", "event"),
    [
        (b"ok", Okay()),
        (b"error:9", Refused(9)),
        (b"ALARM:1", Alarm(1)),
        (b"$110=3000.000", Setting(110, 3000.0)),
        (b"[VER:1.1f.20170801:]", Version("1.1f.20170801")),
        (b"Grbl 1.1f ['$' for help]", Welcome()),
        (b"[MSG:Caution: Unlocked]", Other(b"[MSG:Caution: Unlocked]")),
        (b"<Idle|MPos:0.000,0.000,0.000|FS:0.0,0>", Report("Idle", "", (0.0, 0.0, 0.0), None, None)),
        (b"<Hold:1|MPos:1.000,-2.500,0.000|Bf:15,128|Pn:X>", Report("Hold", "1", (1.0, -2.5, 0.0), None, None)),
        (
            b"<Jog|WPos:1.000,2.000,3.000|WCO:10.000,0.000,0.000>",
            Report("Jog", "", None, (1.0, 2.0, 3.0), (10.0, 0.0, 0.0)),
        ),
        (b"<Idle|MPos:0.000,0.000", Other(b"<Idle|MPos:0.000,0.000")),
        (b"o\xebk", Other(b"o\xebk")),
        (b"okay", Other(b"okay")),
        (b"error:9x", Other(b"error:9x")),
    ],
)
def test_a_line_means_one_thing(line: bytes, event: Event) -> None:
    assert understand(line) == event


def test_a_jog_is_in_millimetres_a_minute_and_in_machine_coordinates() -> None:
    assert jog_to("Y", -12.34567, 0.5) == b"$J=G53G90G21Y-12.3457F30.000\n"


def test_a_setting_has_three_decimals() -> None:
    assert write_setting(121, 50) == b"$121=50.000\n"
