"""What an analysis and a run stand on is made once: a count, as one recording was once corrected four times."""

from collections import Counter
from collections.abc import Callable

import pytest

from instrument import analyse
from instrument.config import scheme_plugin
from instrument.measurement import measurement
from instrument.plan import Plan
from instrument.schemes import select
from tests.support.motions import MOTIONS, letter_b
from tests.support.simulation import simulate


def test_one_analysis_corrects_the_values_once_and_makes_one_scheme(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = Plan(frames=300)
    recording = simulate(plan, letter_b(), MOTIONS["I"], sigma=0.1)
    counted: Counter[str] = Counter()

    def counting(name: str, work: Callable[..., object]) -> Callable[..., object]:
        def call(*arguments: object) -> object:
            counted[name] += 1
            return work(*arguments)

        return call

    monkeypatch.setattr(measurement, "light_of", counting("light", measurement.light_of))
    monkeypatch.setattr(select, "scheme_plugin", counting("scheme", scheme_plugin))
    select._made.cache_clear()

    analyse(recording, method="tv-fourier")

    assert counted == {"light": 1, "scheme": 1}


def test_equal_plans_share_one_scheme_and_its_patterns() -> None:
    first, second = (select.scheme_of(Plan(frames=7)) for _ in range(2))
    assert first is second
    assert select.scheme_of(Plan(frames=8)) is not first
