"""Terminals, timebases and the register of a counter, as h10682-daq.md 4.1 to 4.3 have them."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.sim_backends.wire.ni.rig import code_of, ni_rig, read


@pytest.mark.parametrize("term", ["PFI8", "pfi8", "/Dev1/PFI8", "/dev1/pfi8"])
@pytest.mark.parametrize("clock", ["PFI9", "/DEV1/pfi9"])
def test_a_terminal_is_the_same_with_and_without_its_device_in_any_case(term: str, clock: str) -> None:
    with ni_rig() as rig:
        task = rig.task(term=term, clock=clock)
        rig.show(3)
        assert np.diff(read(task, 4)).tolist() == rig.bins(3)


@pytest.mark.parametrize(
    ("timebase", "hz"), [("100MHzTimebase", 100e6), ("20MHzTimebase", 20e6), ("100kHzTimebase", 100e3)]
)
def test_a_timebase_has_the_frequency_of_its_name(timebase: str, hz: float) -> None:
    """Armed at 0 s, first edge at 1 ms, then one each 50 us."""
    with ni_rig() as rig:
        task = rig.task(counter="Dev1/ctr1", term=f"/Dev1/{timebase}")
        rig.show(4)
        assert read(task, 5).tolist() == [round(hz * (1e-3 + k * 50e-6)) for k in range(5)]


def test_a_board_has_no_timebase_above_its_fastest() -> None:
    """At most 20 MHz: there is no terminal of 100 MHz, which is refused as a bad one is (4.5, -89120)."""
    with ni_rig(ci_max_timebase_hz=20e6) as rig:
        assert code_of(rig.task(term="/Dev1/100MHzTimebase", start=False).start) == -89120
        rig.task(term="/Dev1/20MHzTimebase")


@pytest.mark.parametrize(("counters", "last"), [(2, 1), (4, 3)])
def test_a_board_has_as_many_counters_as_it_was_given(counters: int, last: int) -> None:
    """Section 4.5: -200170 for a counter that is not there."""
    with ni_rig(counters=counters) as rig:
        rig.raw_task().ci_channels.add_ci_count_edges_chan(f"Dev1/ctr{last}")
        assert code_of(rig.raw_task().ci_channels.add_ci_count_edges_chan, f"Dev1/ctr{last + 1}") == -200170


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(initial=st.sampled_from([0, 1, 2**31, 2**32 - 4, 2**32 - 1]) | st.integers(0, 2**32 - 1))
def test_unsigned_differences_are_the_bins_whatever_the_register_began_with(initial: int) -> None:
    """Section 4.3: samples are totals modulo 2^32, three photons at the first edge included."""
    with ni_rig() as rig:
        task = rig.task(initial=initial)
        rig.show(6)
        samples, bins = read(task, 7), rig.bins(6)
        assert int(samples[0]) == (initial + 3) % 2**32
        assert np.diff(samples).tolist() == bins
