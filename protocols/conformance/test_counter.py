"""What the framework relies on in a ``PhotonCounter``, sentence by sentence of its docstrings."""

from collections.abc import Iterator
from typing import Final

import numpy as np
import pytest

from protocols.conformance.rigs import CounterRig, RigFactory
from protocols.conformance.support import assert_speaks
from protocols.counter import CountBlock, CounterReport, CounterRun, PhotonCounter
from protocols.errors import PlanError, WrongState
from protocols.values import Floats

N: Final = 50
"""Number of bins in most runs."""

PERIOD_S: Final = 1e-3
"""Time between two edges in most runs, in seconds; slower where the counter asks for it."""

LATENCY_S: Final = 0.01
"""Latency that makes ten bins a block, in seconds."""


@pytest.fixture
def rig(open_rig: RigFactory[CounterRig]) -> Iterator[CounterRig]:
    """What the device stands on."""
    with open_rig() as rig:
        yield rig


@pytest.fixture
def counter(rig: CounterRig) -> Iterator[PhotonCounter]:
    """An open device."""
    with rig.open() as counter:
        yield counter


def _run(n_bins: int = N, latency_s: float = LATENCY_S) -> CounterRun:
    return CounterRun(n_bins=n_bins, period_s=PERIOD_S, latency_s=latency_s)


def _play(rig: CounterRig, edges: int) -> None:
    if rig.play is None:
        pytest.skip("the rig has no play: nothing gives sync edges")
    rig.play(edges, PERIOD_S)


def _read_all(counter: PhotonCounter, timeout_s: float = 1.0) -> list[CountBlock]:
    """Give all blocks up to the first empty one."""
    blocks: list[CountBlock] = []
    while len(block := counter.read(timeout_s)):
        blocks.append(block)
    return blocks


def _bins(blocks: list[CountBlock]) -> int:
    return sum(len(block) for block in blocks)


def _counts(blocks: list[CountBlock]) -> Floats:
    return np.concatenate([block.counts.astype(np.float64) for block in blocks])


def _assert_whole(rig: CounterRig, blocks: list[CountBlock], n_bins: int = N) -> None:
    """All bins, none twice, none left out, and bin 0 is the one after the first edge."""
    assert _bins(blocks) == n_bins
    firsts = [block.first_bin for block in blocks]
    assert firsts == [0, *np.cumsum([len(block) for block in blocks])[:-1].tolist()]
    if rig.bright_first and n_bins > 1:
        counts = _counts(blocks)
        assert counts[0::2].min() > counts[1::2].max(), f"bright and dark are not where they belong: {counts}"


def _assert_report(report: CounterReport, bins: int, edges: int) -> None:
    assert report.bins_closed == bins
    assert report.edges_seen in (None, edges)


# What it is


def test_it_satisfies_the_protocol(counter: PhotonCounter) -> None:
    assert isinstance(counter, PhotonCounter)


def test_it_says_who_it_is(counter: PhotonCounter) -> None:
    identity = counter.identity
    assert all(part.strip() for part in (identity.name, identity.vendor, identity.model, identity.driver)), identity
    assert counter.identity == identity


def test_its_limits_can_be_true(counter: PhotonCounter) -> None:
    limits = counter.limits
    assert limits.max_sync_rate_hz >= 1 / PERIOD_S, "too slow for these tests, and for any modulator"
    assert limits.max_count_rate_hz * limits.dead_time_s < 1, "the detector would be dead for longer than it lives"
    assert limits.dark_rate_hz < limits.max_count_rate_hz
    assert limits.edge_time_resolution_s is None or limits.edge_time_resolution_s < 1 / limits.max_sync_rate_hz


def test_entering_gives_the_device_itself(rig: CounterRig) -> None:
    counter = rig.open()
    with counter as entered:
        assert entered is counter


# Arming


def test_reading_while_not_armed_is_refused(counter: PhotonCounter) -> None:
    with pytest.raises(WrongState) as refused:
        counter.read(0.1)
    assert_speaks(refused.value, counter.identity.name)
    counter.arm(_run())
    counter.disarm()
    with pytest.raises(WrongState):
        counter.read(0.1)


def test_arming_twice_is_refused_and_disturbs_nothing(rig: CounterRig, counter: PhotonCounter) -> None:
    counter.arm(_run())
    with pytest.raises(WrongState) as refused:
        counter.arm(_run())
    assert_speaks(refused.value, counter.identity.name)
    _play(rig, N + 1)
    _assert_whole(rig, _read_all(counter))


def test_a_run_beyond_the_limits_is_refused_and_the_next_one_counts(rig: CounterRig, counter: PhotonCounter) -> None:
    limits = counter.limits
    bad = [CounterRun(n_bins=N, period_s=0.5 / limits.max_sync_rate_hz)]
    if limits.max_bins is not None:
        bad.append(CounterRun(n_bins=limits.max_bins + 1, period_s=PERIOD_S))
    for run in bad:
        with pytest.raises(PlanError) as refused:
            counter.arm(run)
        assert_speaks(refused.value, counter.identity.name)
        with pytest.raises(WrongState):
            counter.read(0.1)
    counter.arm(_run())
    _play(rig, N + 1)
    _assert_whole(rig, _read_all(counter))


def test_edges_from_before_arming_do_not_count(rig: CounterRig, counter: PhotonCounter) -> None:
    _play(rig, N + 1)
    rig.clock.sleep_s((N // 2 + 0.5) * PERIOD_S)
    counter.arm(_run())
    blocks = _read_all(counter, 20 * PERIOD_S)
    assert 0 < _bins(blocks) <= N - N // 2
    assert blocks[0].first_bin == 0
    _assert_report(counter.disarm(), _bins(blocks), _bins(blocks) + 1)


# Counting


@pytest.mark.parametrize("n_bins", [1, 2, 9, 10, 11, N, 137])
def test_n_plus_1_edges_give_n_bins_each_once(rig: CounterRig, counter: PhotonCounter, n_bins: int) -> None:
    counter.arm(_run(n_bins))
    _play(rig, n_bins + 1)
    blocks = _read_all(counter)
    _assert_whole(rig, blocks, n_bins)
    _assert_report(counter.disarm(), n_bins, n_bins + 1)


def test_counts_are_whole_photons_or_simulated_light(rig: CounterRig, counter: PhotonCounter) -> None:
    counter.arm(_run())
    _play(rig, N + 1)
    kinds = {block.counts.dtype for block in _read_all(counter)}
    assert kinds == {np.dtype(np.uint32)} or (kinds == {np.dtype(np.float64)} and counter.identity.simulated)


def test_surplus_edges_give_no_surplus_bins(rig: CounterRig, counter: PhotonCounter) -> None:
    counter.arm(_run())
    _play(rig, N + 9)
    blocks = _read_all(counter)
    _assert_whole(rig, blocks)
    rig.clock.sleep_s(10 * PERIOD_S)
    _assert_report(counter.disarm(), N, N + 9)


def test_bins_that_closed_before_the_edges_ceased_are_handed_over(rig: CounterRig, counter: PhotonCounter) -> None:
    counter.arm(_run())
    _play(rig, N // 2 + 1)
    blocks = _read_all(counter)
    _assert_whole(rig, blocks, N // 2)
    assert len(counter.read(2 * LATENCY_S)) == 0
    _assert_report(counter.disarm(), N // 2, N // 2 + 1)


def test_without_edges_a_read_gives_nothing_after_its_time_is_up(rig: CounterRig, counter: PhotonCounter) -> None:
    counter.arm(_run())
    for timeout_s in (0.0, 0.03, 0.2):
        before_s = rig.clock.now_s()
        block = counter.read(timeout_s)
        waited_s = rig.clock.now_s() - before_s
        assert (len(block), block.first_bin) == (0, 0)
        assert 0.99 * timeout_s <= waited_s <= timeout_s + 2 * LATENCY_S
    _assert_report(counter.disarm(), 0, 0)


def test_one_edge_opens_a_bin_and_closes_none(rig: CounterRig, counter: PhotonCounter) -> None:
    counter.arm(_run(1))
    _play(rig, 1)
    assert len(counter.read(10 * PERIOD_S)) == 0
    _assert_report(counter.disarm(), 0, 1)


def test_a_read_after_the_last_bin_is_empty_at_once(rig: CounterRig, counter: PhotonCounter) -> None:
    counter.arm(_run())
    _play(rig, N + 1)
    assert _bins(_read_all(counter)) == N
    before_s = rig.clock.now_s()
    block = counter.read(10.0)
    assert (len(block), block.first_bin) == (0, N)
    assert rig.clock.now_s() - before_s <= LATENCY_S


# Time


def test_about_one_latency_of_bins_makes_a_block(rig: CounterRig, counter: PhotonCounter) -> None:
    per_block = LATENCY_S / PERIOD_S
    counter.arm(_run(137))
    _play(rig, 138)
    counter.read(1.0)  # the first one may be anything: it waits for the first edge
    for block in _read_all(counter)[:-1]:
        assert per_block / 4 <= len(block) <= 4 * per_block


@pytest.mark.parametrize("n_bins", [1, 3, 10, 13, N])
def test_the_last_bins_are_not_held_back(rig: CounterRig, counter: PhotonCounter, n_bins: int) -> None:
    counter.arm(_run(n_bins))
    _play(rig, n_bins + 1)
    begin_s, bins = rig.clock.now_s(), 0
    while bins < n_bins:
        bins += len(counter.read(10.0))
    assert rig.clock.now_s() - begin_s <= (n_bins + 2) * PERIOD_S + 3 * LATENCY_S


@pytest.mark.parametrize("closed", [1, 3, 12])
def test_a_read_with_bins_in_hand_does_not_wait_out_its_time(
    rig: CounterRig, counter: PhotonCounter, closed: int
) -> None:
    counter.arm(_run())
    _play(rig, closed + 1)
    begin_s, bins = rig.clock.now_s(), 0
    while bins < closed:
        block = counter.read(10.0)
        bins += len(block)
        assert len(block), "nothing in ten seconds, though bins have closed"
    assert rig.clock.now_s() - begin_s <= (closed + 2) * PERIOD_S + 4 * LATENCY_S


def test_edge_times_count_from_the_first_edge_and_rise(rig: CounterRig, counter: PhotonCounter) -> None:
    counter.arm(_run())
    _play(rig, N + 1)
    blocks = _read_all(counter)
    step_s = counter.limits.edge_time_resolution_s
    if step_s is None:
        assert all(block.opening_edge_s is None and block.closing_edge_s is None for block in blocks)
        pytest.skip("the counter has no edge times, and gives none")
    opening, closing = list[float](), 0.0
    for block in blocks:
        assert block.opening_edge_s is not None
        assert block.closing_edge_s is not None
        assert block.opening_edge_s.shape == block.counts.shape
        if opening:
            assert block.opening_edge_s[0] == pytest.approx(closing, abs=1e-12), "blocks do not join"
        opening += block.opening_edge_s.tolist()
        closing = block.closing_edge_s
        assert closing > opening[-1]
    assert opening[0] == 0
    gaps_s = np.diff([*opening, closing])
    assert gaps_s == pytest.approx(PERIOD_S, rel=1e-3, abs=2 * step_s)


def test_doubts_and_counts_have_the_same_length(rig: CounterRig, counter: PhotonCounter) -> None:
    counter.arm(_run())
    _play(rig, N + 1)
    for block in _read_all(counter):
        assert block.suspect is None or (block.suspect.shape == block.counts.shape and block.suspect.dtype == np.bool_)


# Disarming


def test_disarming_is_allowed_at_any_time_and_twice(rig: CounterRig, counter: PhotonCounter) -> None:
    _assert_report(counter.disarm(), 0, 0)
    _assert_report(counter.disarm(), 0, 0)
    counter.arm(_run())
    _play(rig, N + 1)
    some = counter.read(1.0)
    assert 0 < len(some) < N
    report = counter.disarm()
    assert report.bins_closed == len(some)
    assert report.edges_seen is None or len(some) < report.edges_seen <= N + 1
    _assert_report(counter.disarm(), 0, 0)


def test_each_run_is_counted_afresh(rig: CounterRig, counter: PhotonCounter) -> None:
    for n_bins in (N, 7, 1, N):
        counter.arm(_run(n_bins))
        _play(rig, n_bins + 1)
        blocks = _read_all(counter)
        _assert_whole(rig, blocks, n_bins)
        edges_s = blocks[0].opening_edge_s
        assert edges_s is None or edges_s[0] == 0
        _assert_report(counter.disarm(), n_bins, n_bins + 1)


def test_a_run_after_one_that_was_broken_off_starts_afresh(rig: CounterRig, counter: PhotonCounter) -> None:
    counter.arm(_run())
    _play(rig, N + 1)
    counter.read(1.0)
    counter.disarm()
    rig.clock.sleep_s(2 * N * PERIOD_S)
    counter.arm(_run(9))
    _play(rig, 10)
    _assert_whole(rig, _read_all(counter), 9)


# Closing


def test_it_can_be_opened_again_after_it_was_closed_armed(rig: CounterRig) -> None:
    identities = set[str]()
    for _ in range(3):
        with rig.open() as counter:
            identities.add(counter.identity.model_dump_json())
            counter.arm(_run())
            _play(rig, N + 1)
            _assert_whole(rig, _read_all(counter))
    assert len(identities) == 1


def test_leaving_hides_no_error(rig: CounterRig) -> None:
    def fail_while_armed() -> None:
        with rig.open() as counter:
            counter.arm(_run())
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_while_armed()
