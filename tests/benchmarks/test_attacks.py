"""Disks that fail in mid-run, and programs that are killed: the short form of ``benchmarks.attack_disk`` and ``attack_kill``."""

import sys

import pytest

from benchmarks.attack_disk import cut, disk_full
from benchmarks.attack_kill import killed
from benchmarks.attack_power import power_cut

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of another process (prlimit) are Linux")


TIMES = [1, pytest.param(2, marks=pytest.mark.thorough)]


@pytest.mark.parametrize("times", TIMES)
def test_a_full_disk_ends_the_run_and_costs_no_count(times: int) -> None:
    for row in disk_full(times, seed=1, frames=4000):
        assert row.good, row
        assert row.ended_s < 5


def test_a_file_that_is_cut_ends_the_run_with_one_paragraph() -> None:
    (row,) = cut(1, seed=1, frames=4000)
    assert (row.exit_code, row.paragraphs) == (3, 1)
    assert "another program has cut while" in row.said
    assert row.ended_s < 5


@pytest.mark.parametrize("times", TIMES)
def test_a_killed_run_lacks_at_most_a_tenth_of_a_second(times: int) -> None:
    for row in killed(times, seed=1):
        assert row.good, row


def test_whatever_pages_the_disk_has_kept_every_synced_count_is_recovered_and_no_other_number_is_read() -> None:
    rows = power_cut(14, seed=3)
    assert [row for row in rows if not row.good] == []
    assert {row.kept >= 0 for row in rows} == {True, False}  # some images are refused, and some can be read as they are
