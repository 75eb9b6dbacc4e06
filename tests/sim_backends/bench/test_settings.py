"""The [scene] table, and how it is found."""

import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from pydantic import ValidationError

from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.bench.noise_settings import NoNoise, PhotonNoise, PixelNoise
from sim_backends.bench.plugin import plugin

FULL = """
realism = "realistic"
object = "bars"
object_height_px = 40
start_px = [30.0, 31.5]
trajectory = "path.csv"
object_at_mm = 5.0
px_per_mm = 7.2
axis_angle_deg = 44.0
light_level = 0.8
led_drift_per_s = -0.01
led_flicker = 0.02
mains_hz = 60
illumination_falloff = 0.35
ambient_level = 0.1
ambient_ripple = 0.5
object_growth = 0.03
object_turn_deg = -3.0
blur_px = 0.7
object_level = 0.5
background = "letter-T"
background_px = [90, 30]
background_level = 0.25
edge_loss = 0.01
mirror_transition_s = 4e-6
mirror_settling_s = 8.5e-6
mirrors_inverted = true
swap = { patterns_per_frame = 6, first = 4, second = 5 }
patterns_late = -1
spike_probability = 1e-3
spike_factor = 100
fresh_noise = true
sync_jitter_s = 1e-8
faults = [
    { kind = "drop-edge", picture = 5 },
    { kind = "double-edge", picture = 6, after_s = 3e-6 },
    { kind = "stall", picture = 7 },
    { kind = "surplus-edges", edges = 2 },
]
realtime = true
[noise]
kind = "poisson"
peak_counts = 250
peak_in_s = 5e-5
dark_rate_hz = 600
dead_time_s = 2e-8
dead_time_kind = "paralyzable"
afterpulse_probability = 0.01
afterpulse_delay_s = 2e-6
seed = 7
"""


def test_a_table_with_every_key_is_read() -> None:
    scene = SceneSettings.model_validate(tomllib.loads(FULL))
    assert scene.noise == PhotonNoise(
        kind="poisson",
        peak_counts=250,
        peak_in_s=5e-5,
        dark_rate_hz=600,
        dead_time_s=2e-8,
        dead_time_kind="paralyzable",
        afterpulse_probability=0.01,
        afterpulse_delay_s=2e-6,
        seed=7,
    )
    assert scene.noise.model_fields_set == set(PhotonNoise.model_fields)
    assert [fault.kind for fault in scene.faults] == ["drop-edge", "double-edge", "stall", "surplus-edges"]
    assert set(tomllib.loads(FULL)) == set(SceneSettings.model_fields)


def test_an_empty_table_is_a_noise_free_letter() -> None:
    scene = SceneSettings.model_validate({})
    assert scene.object == "letter-B"
    assert scene.noise == NoNoise()


def test_the_published_noise_is_sigma_of_a_tenth() -> None:
    scene = SceneSettings.model_validate({"noise": {"kind": "pixel"}})
    assert scene.noise == PixelNoise(kind="pixel", sigma=0.1, seed=0)


@pytest.mark.parametrize(
    "table",
    [
        {"objekt": "letter-B"},
        {"noise": {"kind": "gauss"}},
        {"noise": {"kind": "pixel", "peak_counts": 3}},
        {"noise": {"kind": "poisson", "seed": -1}},
        {"noise": {"kind": "poisson", "dead_time_s": 20}},
        {"light_level": 0},
        {"edge_loss": 0.3},
        {"px_per_mm": -7.2},
        {"start_px": [1.0]},
        {"faults": [{"kind": "explode", "picture": 1}]},
        {"faults": [{"kind": "stall"}]},
        {"sync_jitter_s": float("nan")},
        {"px_per_mm": 1e308},
        {"light_level": 1e308},
        {"object_height_px": 1e6},
        {"realism": "real"},
        {"led_flicker": 1.1},
        {"mains_hz": 0},
        {"illumination_falloff": -0.1},
        {"ambient_ripple": 2.0},
        {"object_growth": -1.0},
        {"blur_px": -0.5},
        {"object_turn_deg": 361},
        {"swap": {"patterns_per_frame": 5}},
        {"swap": {"first": -1}},
        {"patterns_late": 0.5},
        {"spike_probability": 1.5},
        {"spike_factor": 0},
        {"noise": {"kind": "poisson", "dead_time_kind": "extending"}},
        {"noise": {"kind": "poisson", "afterpulse_probability": 0.6}},
        {"noise": {"kind": "poisson", "afterpulse_delay_s": 0}},
    ],
)
def test_unknown_keys_and_impossible_values_are_refused(table: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        SceneSettings.model_validate(table)


def test_the_plug_in_is_found_by_its_entry_point_and_opens_a_bench() -> None:
    found = EntryPoint("optical-bench", "sim_backends.bench.plugin:plugin", "kinopix.scenes").load()
    assert found is plugin
    assert plugin.settings is SceneSettings
    assert isinstance(plugin.open(SceneSettings(), Path()), OpticalBench)
