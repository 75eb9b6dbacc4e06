"""Voltages of the emulated board, sample by sample."""

import numpy as np
import pytest

from sim_backends.bench import OpticalBench, Projection, SceneSettings
from sim_backends.wire.ni_analog.settings import NiAnalogEmulatorSettings
from sim_backends.wire.ni_analog.signal import Signal


def playing(n: int, **settings: object) -> tuple[Signal, OpticalBench]:
    """Lit and dark in turns, 10 us a picture, from 10 us on; sampled at 1 MHz."""
    noise = {"kind": "poisson", "peak_counts": 1000.0, "seed": 1}
    bench = OpticalBench(SceneSettings.model_validate({"object": "letter-B", "noise": noise}))
    values = {"noise_v": 0.0, "settle_s": 0.0, **settings}
    signal = Signal(NiAnalogEmulatorSettings.model_validate(values), bench, 1e6)
    lit_and_dark = np.stack([np.full((768, 128), fill, np.uint8) for fill in (0xFF, 0x00)])
    bench.show(Projection(bench.clock.now_s() + 1e-5, 1e-5, lambda index: lit_and_dark[index], np.arange(n) % 2))
    bench.clock.sleep_s(0.001)
    return signal, bench


def test_each_bin_has_its_level_and_each_edge_its_pulse() -> None:
    signal, bench = playing(4, offset_v=0.1)
    light, sync = signal.take(50)
    counts = bench.counts(0, 3)
    assert light[:10] == pytest.approx(0.1)
    for k in range(3):
        assert light[10 * (k + 1) : 10 * (k + 2)] == pytest.approx(0.1 + 1e-3 * counts[k])
    assert light[40:] == pytest.approx(0.1)  # behind the last edge
    assert np.flatnonzero(np.diff(sync > 1)).tolist() == [9, 14, 19, 24, 29, 34, 39, 44]


def test_a_preamplifier_follows_by_its_time_constant() -> None:
    """After one time constant 1 - 1/e of a step is there."""
    signal, bench = playing(4, settle_s=4e-6)
    light, _ = signal.take(20)
    assert light[13] / (1e-3 * bench.counts(0, 1)[0]) == pytest.approx(1 - np.exp(-1), rel=1e-6)


def test_pieces_are_the_whole() -> None:
    one, other = playing(6, settle_s=3e-6)[0], playing(6, settle_s=3e-6)[0]
    whole = one.take(60)
    parts = [other.take(n) for n in (1, 14, 45)]
    for k in (0, 1):
        np.testing.assert_allclose(np.concatenate([part[k] for part in parts]), whole[k], atol=1e-12)


def test_no_sample_comes_before_its_time() -> None:
    signal, bench = playing(4)
    signal.take(signal.ready())
    assert signal.ready() == 0
    bench.clock.sleep_s(5.5e-6)
    assert signal.ready() in {5, 6}


def test_inputs_clip() -> None:
    assert playing(4, volts_per_light=1.0)[0].take(20)[0].max() == 10.0
    assert playing(4, volts_per_light=1.0, polarity="negative")[0].take(20)[0].min() == -10.0
