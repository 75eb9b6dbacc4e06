"""Light that changes in time: flicker, drift, ambient light."""

import math
from pathlib import Path

import numpy as np
import pytest

from protocols import InputError
from sim_backends.bench.lamp import Ambient, Lamp
from tests.sim_backends.projector import PICTURE_S, all_on, bench_with, dot, pixel, save, show, values


def test_a_lamp_flickers_about_its_drifting_level() -> None:
    """At 100 Hz the sine is 0, 1, 0, -1 after 0, 2.5, 5 and 7.5 ms; the drift of -1 a second takes 0.25 % a step of 2.5 ms."""
    lamp = Lamp(level=2.0, drift_per_s=-1.0, flicker=0.3, flicker_hz=100.0)
    steps = np.arange(4, dtype=np.float64)
    expected = 2.0 * (1 - 0.0025 * steps) * np.array([1.0, 1.3, 1.0, 0.7])
    assert lamp.brightness(0.0025 * steps) == pytest.approx(expected)


def test_flicker_of_the_mains_is_a_line_at_twice_their_frequency_with_its_amplitude(tmp_path: Path) -> None:
    """4,000 pictures of 50 us are 20 periods of 100 Hz: bin 20 of the spectrum holds amplitude / 2, every other nothing."""
    bench = bench_with(tmp_path, object=save(tmp_path, dot(4, 5)), led_flicker=0.3)
    show(bench, [all_on()], times=4000)
    spectrum = np.abs(np.fft.rfft(bench.counts(0, 4000))) / 4000
    assert int(spectrum[1:].argmax()) + 1 == 20
    assert spectrum[0] == pytest.approx(1.0)
    assert 2 * spectrum[20] == pytest.approx(0.3)
    assert np.delete(spectrum, [0, 20]).max() < 1e-12


def test_the_mains_have_sixty_hertz_elsewhere(tmp_path: Path) -> None:
    bench = bench_with(tmp_path, object=save(tmp_path, dot(4, 5)), led_flicker=0.3, ambient_level=1.0, mains_hz=60.0)
    show(bench, [all_on(), pixel(0, 0)], times=2000)
    spectrum = np.abs(np.fft.rfft(bench.counts(0, 4000).reshape(-1, 2)[:, 0]))
    assert int(spectrum[1:].argmax()) + 1 == 24  # 120 Hz in 0.2 s


def test_ambient_light_is_the_same_in_every_picture_and_a_part_of_an_all_lit_one(tmp_path: Path) -> None:
    """The dot of 0.5 gives 0.5 in an all-lit picture. A tenth of it, 0.05, is added to each, lamp and object or not."""
    bench = bench_with(tmp_path, object=save(tmp_path, 0.5 * dot(4, 5)), ambient_level=0.1, light_level=2.0)
    assert values(bench, [all_on(), pixel(0, 0), pixel(4, 5)]) == pytest.approx([1.05, 0.05, 1.05])
    taken_out = bench_with(tmp_path, object="object.npy", ambient_level=0.1, object_level=0.0)
    assert values(taken_out, [all_on(), pixel(0, 0)]) == pytest.approx([0.05, 0.05])


def test_ambient_light_is_there_in_dark_bins_after_the_run_and_in_proportion_to_their_length(tmp_path: Path) -> None:
    faults = [{"kind": "surplus-edges", "edges": 2}, {"kind": "double-edge", "picture": 0, "after_s": 5e-6}]
    bench = bench_with(tmp_path, object=save(tmp_path, dot(4, 5)), ambient_level=0.1, faults=faults)
    show(bench, [pixel(0, 0)])
    assert bench.counts(0, 4).tolist() == pytest.approx([0.01, 0.09, 0.1, 0.1])


def test_ambient_photons_are_counted_by_the_same_measure() -> None:
    """1000 counts a picture from the object alone, a fifth of it from the door."""
    noise = {"kind": "poisson", "peak_counts": 1000.0, "seed": 4}
    bench = bench_with(object="square", object_height_px=4, start_px=(8.0, 8.0), noise=noise, ambient_level=0.2)
    show(bench, [pixel(0, 0)], times=2000)
    assert bench.counts(0, 2000).mean() == pytest.approx(200.0, abs=4 * math.sqrt(200 / 2000))


def test_rippling_ambient_light_is_integrated_over_each_bin() -> None:
    """Over half a period of 100 Hz, 5 ms, a sine of amplitude 1 has the mean 2 / pi; over the next half minus that."""
    ambient = Ambient(level_per_s=200.0, ripple=0.5, ripple_hz=100.0)
    light = ambient.light(np.array([0.0, 0.005, 0.0]), np.array([0.005, 0.010, 0.010]))
    assert light == pytest.approx([1 + 1 / math.pi, 1 - 1 / math.pi, 2.0])


def test_ripple_begins_at_the_first_edge_and_not_at_the_first_picture(tmp_path: Path) -> None:
    """Twice 2.5 kHz, an edge a fifth of a picture before it: one bin of 50 us is a quarter of a period, from 0 to its crest.

    The mean of a sine over it is 2 / pi.
    """
    scene = {"object": save(tmp_path, dot(4, 5)), "ambient_level": 1.0, "ambient_ripple": 1.0, "mains_hz": 2500.0}
    bench = bench_with(tmp_path, **scene)
    show(bench, [pixel(0, 0)] * 4, sync_delay_s=PICTURE_S / 5)
    swing = 2 / math.pi
    assert bench.counts(0, 4).tolist() == pytest.approx([1 + swing, 1 + swing, 1 - swing, 1 - swing])


def test_the_light_at_the_first_picture_is_the_measure_of_ambient_light_and_must_be_there() -> None:
    with pytest.raises(InputError, match="ambient_level are the measure"):
        show(bench_with(object="square", object_height_px=2, start_px=(-50.0, 8.0), ambient_level=0.1), [all_on()])
