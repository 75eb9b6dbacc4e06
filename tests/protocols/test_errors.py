"""Errors say what was seen, what was expected, on which device, and what to do; the command's exit code is theirs."""

import pytest

from protocols import (
    DeviceRefused,
    DeviceTimeout,
    InputError,
    KinopixError,
    MotionTooFast,
    PatternMemoryFull,
    PictureTimeTooShort,
    SafeStateFailed,
    TravelExceeded,
    TriggerMissed,
)


@pytest.mark.parametrize(
    ("error", "exit_code", "text"),
    [
        (
            KinopixError(saw="a", expected="b", remedy="c"),
            3,
            "saw a; expected b. To do: c.",
        ),
        (
            InputError(saw="a", expected="b", remedy="c", device="dmd"),
            2,
            "dmd: saw a; expected b. To do: c.",
        ),
        (
            PictureTimeTooShort("dmd", 40.5, 44),
            2,
            "dmd: saw a picture time of 40.5 us; expected at least 44 us. To do: lower pattern_rate_hz to 22727 or less.",
        ),
        (
            PatternMemoryFull("dmd", 50, 40, "pictures in the play order"),
            2,
            "dmd: saw 50 pictures in the play order; expected at most 40. To do: record fewer frames a run.",
        ),
        (
            TravelExceeded("stage", -0.5, (0.0, 400.0)),
            2,
            (
                "stage: saw a target of -0.5 mm; expected 0 to 400 mm. To do: change start_mm, velocity_mm_s or the number of "
                "frames, or the stage's limits in bench.toml."
            ),
        ),
        (
            MotionTooFast("stage", "velocity", 60.0, 50.0, "mm/s"),
            2,
            "stage: saw velocity of 60 mm/s; expected more than 0 and at most 50 mm/s. To do: lower the velocity in plan.toml.",
        ),
        (
            DeviceTimeout("stage", awaited="the end of the move", waited_s=1.23456, progress="12 mm", remedy="look"),
            3,
            "stage: saw 12 mm after 1.23 s; expected the end of the move. To do: look.",
        ),
        (
            DeviceRefused("pmt", code="-50103", saw="a task", expected="none", remedy="end it"),
            3,
            "pmt: saw a task (code -50103); expected none. To do: end it.",
        ),
        (
            TriggerMissed("pmt", bins_read=15, bins_expected=24, waited_s=0.2551),
            3,
            (
                "pmt: saw 15 of 24 patterns counted, then no sync edge for 0.255 s; expected 25 sync edges. To do: check the "
                "sync cable, its level and its width against the counter's input filter."
            ),
        ),
        (
            SafeStateFailed({"stage": OSError("gone"), "dmd": ValueError("mute")}),
            3,
            (
                "stage, dmd: saw stage: gone; dmd: mute; expected stage stopped, modulator halted, counter disarmed. To do: look "
                "at the bench and switch off by hand what is named here."
            ),
        ),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Exception) else "",
)
def test_the_sentence_and_the_exit_code_of_each_error(error: KinopixError, exit_code: int, text: str) -> None:
    assert str(error) == text
    assert error.exit_code == exit_code


def test_the_parts_of_an_error_can_be_asked_for() -> None:
    missed = TriggerMissed("pmt", bins_read=15, bins_expected=24, waited_s=0.25)
    assert (missed.bins_read, missed.bins_expected, missed.device) == (15, 24, "pmt")
    assert DeviceRefused("pmt", code="7", saw="a", expected="b", remedy="c").code == "7"
    failures: dict[str, BaseException] = {"stage": OSError("gone")}
    assert SafeStateFailed(failures).failures is failures
