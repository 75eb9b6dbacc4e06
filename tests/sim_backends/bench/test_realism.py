"""A bench with the flaws of a real one."""

import numpy as np
import pytest

from instrument import Plan, simulate
from sim_backends.bench import SceneSettings
from sim_backends.bench.noise_settings import PhotonNoise, PixelNoise
from sim_backends.bench.realism import REALISTIC


def _scene(**table: object) -> SceneSettings:
    return SceneSettings.model_validate({"realism": "realistic", **table})


def test_an_ideal_bench_has_no_flaw() -> None:
    ideal = SceneSettings()
    assert ideal.realism == "ideal"
    assert {key: getattr(ideal, key) for key in REALISTIC} == dict.fromkeys(REALISTIC, 0.0)


def test_a_realistic_bench_has_the_figures_of_the_data_sheets() -> None:
    scene = _scene()
    assert (scene.mirror_transition_s, scene.mirror_settling_s) == (4e-6, 8.5e-6)
    assert isinstance(scene.noise, PhotonNoise)
    assert (scene.noise.dead_time_s, scene.noise.dark_rate_hz, scene.noise.peak_counts) == (20e-9, 600.0, 250.0)
    assert {key: getattr(scene, key) for key in REALISTIC} == REALISTIC


def test_what_the_table_says_holds_key_by_key() -> None:
    scene = _scene(edge_loss=0.0, blur_px=1.5, noise={"kind": "poisson", "peak_counts": 40.0, "seed": 3})
    assert (scene.edge_loss, scene.blur_px, scene.mirror_transition_s) == (0.0, 1.5, 4e-6)
    assert isinstance(scene.noise, PhotonNoise)
    assert (scene.noise.peak_counts, scene.noise.seed, scene.noise.dead_time_s) == (40.0, 3, 20e-9)
    assert _scene(noise={"kind": "pixel"}).noise == PixelNoise(kind="pixel")


def test_what_was_filled_in_is_written_out_and_read_again() -> None:
    scene = _scene(edge_loss=0.01)
    assert SceneSettings.model_validate_json(scene.model_dump_json()) == scene


def test_flaws_stay_within_their_bounds() -> None:
    """What is filled in is not validated by pydantic: the same table, said key by key, is."""
    said = {**REALISTIC, "noise": _scene().noise}
    assert SceneSettings.model_validate(said).model_copy(update={"realism": "realistic"}) == _scene()


def test_a_realistic_bench_runs_and_only_values_differ() -> None:
    """The whole instrument: the truth is that of an ideal bench, but for the blur; some light is lost, and some is added."""
    plan = Plan(frames=60, motion=None)
    real = simulate(plan, {"realism": "realistic", "background": "letter-T"})
    ideal = simulate(plan, {"noise": {"kind": "poisson"}, "background": "letter-T"})
    assert real.truth is not None
    assert ideal.truth is not None
    assert real.truth.displacement_px.tolist() == ideal.truth.displacement_px.tolist()
    assert real.truth.image.sum() == pytest.approx(ideal.truth.image.sum(), rel=1e-3)
    assert real.truth.background is not None
    assert ideal.truth.background is not None
    assert real.truth.background.sum() == pytest.approx(ideal.truth.background.sum(), rel=1e-3)
    assert np.isfinite(real.values).all()
    assert not np.array_equal(real.values, ideal.values)
