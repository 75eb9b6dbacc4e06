"""The page that users read says what the tests prove."""

from pathlib import Path

import pytest

from tests.faults.page import line
from tests.faults.row import Row
from tests.faults.table import TABLE

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "faults.md"


@pytest.mark.parametrize(("device", "rows"), TABLE.items(), ids=TABLE)
def test_the_page_has_each_row_as_it_was_proved_and_no_other(device: str, rows: tuple[Row, ...]) -> None:
    """To write the tables anew: ``python -m tests.faults.page``."""
    section = PAGE.read_text().split(f"## {device}\n")[1].split("\n## ")[0]
    shown = [text for text in section.splitlines() if text.startswith("| ") and not text.startswith("| fault ")]
    assert shown == [line(row) for row in rows]


def test_no_two_rows_of_a_device_have_the_same_name() -> None:
    for rows in TABLE.values():
        assert len({row.fault for row in rows}) == len(rows)
