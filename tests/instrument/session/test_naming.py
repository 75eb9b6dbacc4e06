"""Names of recordings for which nobody gave one."""

import re
from pathlib import Path

from instrument.session import next_name


def test_a_name_is_that_of_no_file_that_is_there(tmp_path: Path) -> None:
    names: list[str] = []
    for _ in range(30):  # far less than a second
        path = next_name(tmp_path)
        assert not path.exists()
        path.touch()
        names.append(path.name)
    assert len(set(names)) == 30
    assert all(re.fullmatch(r"run-\d{8}-\d{6}(-\d+)?\.h5", name) for name in names)
    assert names[0].count("-") == 2
