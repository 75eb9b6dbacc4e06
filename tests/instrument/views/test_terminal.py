"""Tables and messages as a person reads them, at a fixed width."""

from io import StringIO

import pytest
from rich.console import Console

from instrument.acquisition import Check, CheckReport, TimingReport
from instrument.views import terminal
from protocols import InputError, KinopixError

GOOD = TimingReport(
    verdict="good",
    patterns_expected=24,
    patterns_recorded=24,
    bins_received=25,
    edges_seen=None,
    surplus_edges=None,
    picture_time_s=50e-6,
    mean_period_s=None,
    jitter_s=None,
    largest_deviation_s=None,
    clock_offset_ppm=None,
    frames=4,
    frames_masked=1,
)


def printed(what: object) -> dict[str, str]:
    """Rows of a table of two columns, as printed."""
    out = StringIO()
    Console(file=out, width=120).print(what)
    rows = (line.strip("│ ").split("│") for line in out.getvalue().splitlines() if "│" in line)
    return {row[0].strip(): row[1].strip() for row in rows}


def test_the_least_that_an_audit_says() -> None:
    assert printed(terminal.timing_table(GOOD)) == {
        "verdict": "good",
        "patterns": "24 of 24, 25 bins",
        "frames": "4, 1 masked",
        "picture time": "50 us",
    }


def test_all_that_an_audit_can_say() -> None:
    report = GOOD.model_copy(
        update={
            "verdict": "flagged",
            "edges_seen": 28,
            "surplus_edges": 3,
            "mean_period_s": 50.00125e-6,
            "jitter_s": 12.34e-9,
            "largest_deviation_s": 56.78e-9,
            "clock_offset_ppm": 25.04,
            "gaps": (8,),
            "doubles": tuple(range(10, 18)),
            "irregular": tuple(range(9)),
            "brightest_rate_hz": 1.2345e6,
            "notes": ("first", "second"),
        }
    )
    rows = printed(terminal.timing_table(report))
    assert rows == {
        "verdict": "flagged",
        "patterns": "24 of 24, 25 bins",
        "frames": "4, 1 masked",
        "picture time": "50 us",
        "sync period": "50.0012 us (+25.0 ppm)",
        "jitter": "12.3 ns, at most 56.8 ns",
        "sync edges": "28 seen, 3 after the run",
        "gaps": "1, at pattern 8",
        "doubles": "8, at pattern 10, 11, 12, 13, 14, 15, 16, 17",
        "irregular": "9, at pattern 0, 1, 2, 3, 4, 5, 6, 7, ...",
        "brightest": "1.23e+06 counts/s",
        "note 1": "first",
        "note 2": "second",
    }


def test_checks_have_a_row_each() -> None:
    checks = (Check("field", "good", "256 mirrors"), Check("stage", "error", "too far"))
    rows = printed(terminal.check_table(CheckReport(checks)))
    assert rows == {"field": "good", "stage": "error"}


@pytest.mark.parametrize(
    ("outcome", "colour"),
    [
        ("good", "green"),
        ("warning", "yellow"),
        ("flagged", "yellow"),
        ("error", "red"),
        ("failed", "red"),
        ("x", "white"),
    ],
)
def test_each_outcome_has_its_colour(outcome: str, colour: str) -> None:
    word = terminal.coloured(outcome)
    assert (word.plain, word.style) == (outcome, colour)


@pytest.fixture
def err(monkeypatch: pytest.MonkeyPatch) -> StringIO:
    """Standard error of a narrow terminal without colours."""
    out = StringIO()
    monkeypatch.setattr(terminal, "ERR", Console(file=out, width=40))
    return out


def test_an_error_is_one_paragraph_with_its_notes_and_brackets_stay(err: StringIO) -> None:
    """A line longer than the terminal is not broken, so that it can be searched for and copied."""
    error = InputError(saw="the table [motion] twice, here and there", expected="once", remedy="leave [b]one[/b] out")
    error.add_note("24 patterns are kept in [run].h5")
    terminal.show_error(error)
    assert err.getvalue() == (
        "kinopix: saw the table [motion] twice, here and there; expected once. To do: leave [b]one[/b] out.\n"
        "24 patterns are kept in [run].h5\n"
    )


def test_an_error_without_notes_has_none(err: StringIO) -> None:
    terminal.show_error(KinopixError(saw="a", expected="b", remedy="c"))
    assert err.getvalue() == "kinopix: saw a; expected b. To do: c.\n"


def test_a_warning_keeps_its_brackets(err: StringIO) -> None:
    terminal.warn("1 of 4 frames are masked [red]")
    assert err.getvalue() == "1 of 4 frames are masked [red]\n"


def test_progress_goes_to_standard_error() -> None:
    assert terminal.progress().console is terminal.ERR
    assert terminal.ERR.stderr
    assert not terminal.OUT.stderr
