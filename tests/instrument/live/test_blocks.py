"""The queue between acquisition and live analysis."""

import numpy as np

from instrument.live.blocks import BlockQueue
from tests.instrument.live.streams import block


def test_a_full_queue_drops_its_oldest_blocks_and_counts_them() -> None:
    """Seven blocks of 10 into room for 35: the last three stay."""
    queue = BlockQueue(35)
    for k in range(7):
        queue.put(block(10 * k, np.ones(10)))
    assert queue.blocks_dropped == 4
    assert queue.patterns == 30
    assert [taken.first_pattern for taken in queue.take(wait=True) or []] == [40, 50, 60]
    assert queue.patterns == 0


def test_the_newest_block_stays_however_large_it_is() -> None:
    queue = BlockQueue(35)
    queue.put(block(0, np.ones(10)))
    queue.put(block(10, np.ones(1000)))
    assert [len(taken.values) for taken in queue.take(wait=True) or []] == [1000]
    assert queue.blocks_dropped == 1


def test_a_block_is_copied_so_that_its_buffer_may_be_used_again() -> None:
    queue = BlockQueue(100)
    buffer = np.ones(6)
    queue.put(block(0, buffer))
    buffer[:] = 7
    (taken,) = queue.take(wait=True) or []
    assert taken.values.tolist() == [1.0] * 6


def test_a_closed_queue_is_emptied_and_then_ends() -> None:
    queue = BlockQueue(100)
    assert queue.take(wait=False) == []
    queue.put(block(0, np.ones(6)))
    queue.close()
    queue.put(block(6, np.ones(6)))
    assert len(queue.take(wait=True) or []) == 1
    assert queue.take(wait=True) is None


def test_a_queue_that_forgets_ends_at_once() -> None:
    queue = BlockQueue(100)
    queue.put(block(0, np.ones(6)))
    queue.close(forget=True)
    assert queue.take(wait=True) is None
    assert queue.blocks_dropped == 0
