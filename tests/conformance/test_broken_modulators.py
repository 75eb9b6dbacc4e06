"""A suite that nothing can fail proves nothing: modulators with one mistake each, and the test that finds it."""

import math
from collections.abc import Callable
from dataclasses import replace
from inspect import signature

import numpy as np
import pytest

from protocols import (
    DeviceTimeout,
    ModulatorTiming,
    PatternModulator,
    PatternSequence,
    PlanError,
    UploadProgress,
)
from protocols.conformance import modulator as suite
from protocols.conformance.patterns import sequence_for
from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.devices.modulator import ModulatorSettings, SimulatedModulator
from tests.conformance.biting import FOUND, call
from tests.conformance.rigs import modulator_rig


class AddsAGuard(SimulatedModulator):
    def load(
        self, sequence: PatternSequence, timing: ModulatorTiming, progress: UploadProgress | None = None
    ) -> ModulatorTiming:
        order = np.append(sequence.play_order, sequence.play_order[-1])
        return super().load(replace(sequence, play_order=order), timing, progress)


class KeepsHalfASequence(SimulatedModulator):
    def load(
        self, sequence: PatternSequence, timing: ModulatorTiming, progress: UploadProgress | None = None
    ) -> ModulatorTiming:
        half = replace(sequence, play_order=sequence.play_order[-2:])
        super().load(half, ModulatorTiming(picture_time_us=100))
        self.limits.check_sequence(sequence, "dmd")
        self.limits.check_timing(timing, "dmd")
        return super().load(sequence, timing, progress)


class TellsWhatItWasAsked(SimulatedModulator):
    """Plays 1 % slower than it says."""

    def load(
        self, sequence: PatternSequence, timing: ModulatorTiming, progress: UploadProgress | None = None
    ) -> ModulatorTiming:
        slower = timing.model_copy(update={"picture_time_us": round(timing.picture_time_us * 1.01)})
        super().load(sequence, slower, progress)
        return timing


class IgnoresHalts(SimulatedModulator):
    def halt(self) -> None:
        pass


class NeverWaits(SimulatedModulator):
    def wait(self, timeout_s: float) -> None:
        pass


class BlocksInStart(SimulatedModulator):
    def start(self) -> None:
        super().start()
        self.wait(math.inf)


class SaysOnlyTimeOut(SimulatedModulator):
    def wait(self, timeout_s: float) -> None:
        try:
            super().wait(timeout_s)
        except DeviceTimeout:
            raise DeviceTimeout("dmd", awaited="end", waited_s=timeout_s, progress="nothing", remedy="wait") from None


@pytest.mark.parametrize(
    ("broken", "test"),
    [
        (AddsAGuard, suite.test_n_patterns_and_the_guard_give_n_plus_1_edges),
        (KeepsHalfASequence, suite.test_a_refused_load_leaves_nothing_half_loaded_and_the_next_one_plays),
        (TellsWhatItWasAsked, suite.test_the_timing_that_is_kept_is_read_back),
        (IgnoresHalts, suite.test_a_halt_from_another_thread_stops_the_pictures),
        (IgnoresHalts, suite.test_leaving_halts_the_pictures),
        (NeverWaits, suite.test_a_start_returns_at_once_and_the_device_runs_until_the_wait_is_over),
        (BlocksInStart, suite.test_a_start_returns_at_once_and_the_device_runs_until_the_wait_is_over),
        (SaysOnlyTimeOut, suite.test_a_wait_that_is_too_short_says_how_far_the_run_has_come_and_the_run_goes_on),
    ],
)
def test_a_broken_modulator_is_found(broken: type[SimulatedModulator], test: Callable[..., None]) -> None:
    _try(SimulatedModulator, test)
    with pytest.raises(FOUND):
        _try(broken, test)


def _try(kind: type[SimulatedModulator], test: Callable[..., None]) -> None:
    bench = OpticalBench(SceneSettings())
    rig = modulator_rig(bench, lambda: kind(ModulatorSettings(), bench))
    if "modulator" not in signature(test).parameters:
        call(test, rig=rig)
        return
    bad_load = {"bad_load": _too_slow, "error": PlanError, "limits": ("longest_picture_time_us",)}
    with rig.open() as modulator:
        call(test, rig=rig, modulator=modulator, n_patterns=7, **bad_load)


def _too_slow(modulator: PatternModulator) -> None:
    timing = ModulatorTiming(picture_time_us=modulator.limits.longest_picture_time_us + 1)
    modulator.load(sequence_for(modulator.limits, 5), timing)
