"""The detector of a simulated bench, found by ordinary runs."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from instrument.calibration import PictureField, calibrate_detector
from instrument.config import DeadTimeKind
from instrument.session import Instrument
from instrument.storage import open_recording
from protocols import InputError
from tests.instrument.calibration.benches import bench_of


def field(folder: Path) -> PictureField:
    return PictureField(folder, image_size=32, superpixel=4)


@pytest.mark.parametrize("kind", ["non-paralyzable", "paralyzable"])
def test_dead_time_its_kind_and_the_dark_rate_at_twenty_million_a_second(tmp_path: Path, kind: DeadTimeKind) -> None:
    noise: dict[str, Any] = {"dead_time_s": 2.5e-8, "dead_time_kind": kind, "dark_rate_hz": 3000.0}
    scene = {"edge_loss": 0.02, "mirror_transition_s": 4e-6, "led_flicker": 0.01}
    with bench_of(scene, mcps=20, **noise) as bench:
        found = calibrate_detector(bench, field(tmp_path), dark_s=1.0, longest_s=3.0, flicker_s=0.5)
    section = found.section
    assert section.dead_time_s is not None
    assert section.dead_time_s.value == pytest.approx(2.5e-8, abs=1e-9)
    assert section.dead_time_s.value == pytest.approx(2.5e-8, abs=5 * section.dead_time_s.sigma)
    assert section.dead_time_kind == kind
    assert found.doubts == ()
    assert section.dark_rate_hz.value == pytest.approx(3000, abs=4 * section.dark_rate_hz.sigma)
    assert section.dark_rate_hz.sigma == pytest.approx(np.sqrt(3000), rel=0.05)
    assert section.linear_limit_hz == pytest.approx(4e6 if kind == "non-paralyzable" else 3.79e6, rel=0.05)
    assert [round(line.frequency_hz) for line in section.flicker] == [100]
    assert section.flicker[0].amplitude == pytest.approx(0.01 / 1.5, rel=0.4)  # some of it is lost in dead time
    assert found.filter_density(found.white_counts / 100) == pytest.approx(2.0)


def test_a_bench_that_is_too_dim_says_what_it_cannot_tell(tmp_path: Path) -> None:
    with bench_of(mcps=0.05, dead_time_s=2e-8) as bench:
        found = calibrate_detector(bench, field(tmp_path), dark_s=0.5, longest_s=1.0, flicker_s=0.1)
    assert found.section.dead_time_kind is None
    assert found.section.dead_time_s is None  # what the counter states stays in force
    assert found.section.linear_limit_hz is None
    assert "brighter light" in found.doubts[0]


def test_light_that_excludes_the_counters_own_figure_tells_of_none(tmp_path: Path) -> None:
    with bench_of(mcps=20, dead_time_s=0.0, stated_s=5e-8) as bench:
        found = calibrate_detector(bench, field(tmp_path), dark_s=0.1, longest_s=1.0, flicker_s=0.1)
    assert found.section.dead_time_s is not None
    assert found.section.dead_time_s.value < 5e-9


def test_without_light_there_is_nothing_to_measure_but_dark_counts(tmp_path: Path) -> None:
    with bench_of({"object_level": 0.0}, dark_rate_hz=600.0) as bench:
        with pytest.raises(InputError, match="switch the lamp on"):
            calibrate_detector(bench, field(tmp_path / "open"), dark_s=0.5, longest_s=1.0, flicker_s=0.1)
        found = calibrate_detector(bench, field(tmp_path / "closed"), dark_s=4.0, shutter_closed=True)
    section = found.section
    assert section.dark_rate_hz.value == pytest.approx(600, abs=4 * section.dark_rate_hz.sigma)
    assert section.shutter_closed
    assert section.dead_time_s is None


def test_the_runs_are_kept_as_ordinary_recordings(tmp_path: Path) -> None:
    with bench_of(mcps=20, dead_time_s=2e-8) as bench:
        calibrate_detector(bench, field(tmp_path), dark_s=0.1, longest_s=1.0, flicker_s=0.1)
        assert isinstance(bench, Instrument)
        assert "stage" not in bench.devices.by_role
    names = {path.stem for path in tmp_path.iterdir()}
    assert names == {"detector-dark", "detector-flicker", "detector-look", "detector-ladder-0"}
    ladder = open_recording(tmp_path / "detector-ladder-0.h5")
    assert ladder.plan.scheme.name == "pictures"
    assert ladder.frame_valid.all()
