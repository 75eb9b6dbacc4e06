"""Memory accounting in binary frames, by any order of allocations (dlp7000.md 2.1, 7.1 item 2)."""

import hypothesis.strategies as st
from hypothesis import settings
from hypothesis.stateful import Bundle, MultipleResults, RuleBasedStateMachine, consumes, invariant, multiple, rule

from tests.sim_backends.wire.alp.client import Client

_FRAMES = 64


class Memory(RuleBasedStateMachine):
    """A board of 64 frames against a bitmap of them, kept by first fit."""

    sequences = Bundle[tuple[int, int, int]]("sequences")

    def __init__(self) -> None:
        super().__init__()
        self.alp = Client(memory_frames=_FRAMES)
        self.device = self.alp.device()
        self.taken = "." * _FRAMES

    @rule(target=sequences, planes=st.integers(1, 8), pictures=st.integers(1, 20))
    def allocate(self, planes: int, pictures: int) -> MultipleResults[tuple[int, int, int]] | tuple[int, int, int]:
        """It succeeds exactly where a gap is long enough, and takes the first such gap."""
        size = planes * pictures
        start = self.taken.find("." * size)
        code, sequence = self.alp.ask("AlpSeqAlloc", self.device, planes, pictures)
        assert code == (1007 if start < 0 else 0)
        if start < 0:
            nothing: MultipleResults[tuple[int, int, int]] = multiple()
            return nothing
        self.taken = self.taken[:start] + "x" * size + self.taken[start + size :]
        return (sequence, start, size)

    @rule(allocated=consumes(sequences))
    def free(self, allocated: tuple[int, int, int]) -> None:
        """It succeeds once."""
        sequence, start, size = allocated
        assert self.alp("AlpSeqFree", self.device, sequence) == 0
        assert self.alp("AlpSeqFree", self.device, sequence) == 1006
        self.taken = self.taken[:start] + "." * size + self.taken[start + size :]

    @invariant()
    def available_memory_is_the_largest_gap(self) -> None:
        """What ALP_AVAIL_MEMORY tells is what an AlpSeqAlloc can have."""
        largest = max(map(len, self.taken.split("x")))
        assert self.alp.ask("AlpDevInquire", self.device, 2003) == (0, largest)

    def teardown(self) -> None:
        """Freeing the board frees everything."""
        assert self.alp("AlpDevFree", self.device) == 0
        assert self.alp.ask("AlpDevInquire", self.alp.device(), 2003) == (0, _FRAMES)


TestMemory = Memory.TestCase
TestMemory.settings = settings(max_examples=20, stateful_step_count=20, deadline=None)
