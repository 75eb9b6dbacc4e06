"""What an analysis and a run stand on is made once: a count, as one recording was once corrected four times."""

from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest

import instrument.measurement.measurement as measuring
from instrument import analyse
from instrument.config import scheme_plugin
from instrument.measurement import light_of
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.schemes import select


def test_one_analysis_corrects_the_values_once_and_makes_one_scheme(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = Plan(frames=301)  # no other test has one of so many frames: its scheme is not made yet
    values = np.random.default_rng(0).normal(200.0, 3.0, (301, 6))
    values[0, 4:] = 400.0, 0.0  # the first pattern is all on: there is an object in the light
    recording = Recording(plan, values, np.ones(301, np.bool_), plan.picture_time_s)
    counted: Counter[str] = Counter()

    def counting(name: str, work: Callable[..., object]) -> Callable[..., object]:
        def call(*arguments: object) -> object:
            counted[name] += 1
            return work(*arguments)

        return call

    monkeypatch.setattr(measuring, "light_of", counting("light", light_of))
    monkeypatch.setattr(select, "scheme_plugin", counting("scheme", scheme_plugin))

    analyse(recording, method="tv-fourier")

    assert counted == {"light": 1, "scheme": 1}


def test_equal_plans_share_one_scheme_and_its_patterns() -> None:
    first, second = (select.scheme_of(Plan(frames=7)) for _ in range(2))
    assert first is second
    assert select.scheme_of(Plan(frames=8)) is not first
