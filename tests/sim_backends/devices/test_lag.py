"""A simulated bench in real time that cannot keep up says by how much."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from instrument.session import Event, FindingEvent, Instrument
from tests.support.benches import SMALL, bench_toml


@pytest.mark.parametrize(("needed_s", "told"), [(2.3, True), (0.3, True), (0.2, False), (0.0, False)])
def test_a_bench_that_works_out_its_light_too_slowly_says_how_late_its_counts_came(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, needed_s: float, told: bool
) -> None:
    """The machine is busy for that long with the one block of the run; 0.05 s of latency and 0.2 s more are no lag."""
    said: list[str] = []
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        scene: Any = bench.devices.scene
        counts: Callable[[int, int], object] = scene.counts

        def slow_counts(first: int, n: int) -> object:
            bench.devices.clock.sleep_s(needed_s)
            return counts(first, n)

        def listen(event: Event) -> None:
            if isinstance(event, FindingEvent):
                said.append(event.message)

        monkeypatch.setattr(scene, "counts", slow_counts)
        recording = bench.run(SMALL, tmp_path / "run.h5", listeners=[listen])
    assert recording.timing is not None
    note = f"the simulated bench ran up to {needed_s:.1f} s behind real time"
    assert (note in recording.timing.notes) == told
    assert (note in said) == told
