"""bench.toml, plan.toml and trajectories that were made to do harm are refused in words, and soon."""

import os
import sys
from pathlib import Path

import pytest

import instrument.config.check as checking
from instrument.config import ConfigError, load_bench
from instrument.config.document import MOST_BYTES, read_document
from instrument.config.errors import MOST_TOLD
from instrument.plan import Plan
from protocols import InputError
from sim_backends.bench.files import load_trajectory
from tests.support.benches import bench_toml, plan_toml


def refusal(folder: Path, text: str) -> str:
    path = folder / "plan.toml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        Plan.from_toml(path)
    return str(caught.value)


def test_ten_thousand_unknown_keys_are_counted_and_the_first_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def suggest_key(key: str, known: object) -> str:
        asked.append(key)
        return ""

    monkeypatch.setattr(checking, "suggest_key", suggest_key)
    said = refusal(tmp_path, "frames = 3\n" + "\n".join(f"unknown_{k} = {k}" for k in range(10_000))).splitlines()
    assert said[0].startswith("10000 mistakes in ")
    assert [f"unknown_{k}" in line for k, line in enumerate(said[1:-1])] == [True] * MOST_TOLD
    assert said[-1] == f"  and {10_000 - MOST_TOLD} more"
    assert len(asked) == MOST_TOLD, "a suggestion takes a millisecond: only those that are told are looked for"


def test_the_first_mistakes_of_a_bench_are_told_with_suggestions(tmp_path: Path) -> None:
    path = bench_toml(tmp_path, "lihgt_level = 2.0\n" + "\n".join(f"unknown_{k} = {k}" for k in range(10_000)))
    with pytest.raises(ConfigError, match=r"did you mean light_level\?") as caught:
        load_bench(path)
    assert str(caught.value).endswith(f"and {10_001 - MOST_TOLD} more")


def test_every_line_is_counted_once(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text("\n".join(f"key_{k} = [\n{k}]" for k in range(3)))
    document = read_document(path)
    assert [document.line_of((f"key_{k}",)) for k in range(3)] == [1, 3, 5]
    assert [document.line_of((f"key_{k}", 0)) for k in range(3)] == [2, 4, 6]


@pytest.mark.parametrize(
    ("text", "saw"),
    [
        ("frames = 1" + 400 * "0", "a whole number of 1329 bits"),
        ("frames = 0x" + 90_000 * "f", "a whole number of 360000 bits"),
        ("frames = " + 5000 * "9", "a number of more than 4300 digits"),
        ("frames = 1e999", "saw Infinity"),
        ("frames = 3\npattern_rate_hz = 1e999", "pattern_rate_hz: saw Infinity"),
        ("frames = 3\npattern_rate_hz = nan", "pattern_rate_hz: saw NaN"),
        ("frames = 3\npattern_rate_hz = 1e-300", "pattern_rate_hz: saw 1e-300"),
        ("frames = 9223372036854775807", "frames: saw 9223372036854775807"),
        ("frames = 100000000", "at most 16666666 of this scheme"),
        ("frames = 1000000\nimage_size = 1024\nsuperpixel = 1", "take 786 GB, where 8 are the most"),
        ("frames = 3\nimage_size = 4194304", "image_size: saw 4194304"),
        ("frames = 3000000\npattern_rate_hz = 1.0", "takes 208 days, where 7 are the most"),
        ("frames = 3\n[motion]\nvelocity_mm_s = 1e-300", "at least 1e-06"),
        ("frames = 3\n[motion]\nvelocity_mm_s = 1e300", "motion.velocity_mm_s: saw 1e+300"),
        ("frames = 3\n[motion]\nvelocity_mm_s = 1.0\nacceleration_mm_s2 = 1e-300", "days"),
        ("frames = 3\n[motion]\nvelocity_mm_s = 1.0\nsettle_s = 1e9", "settle_s: saw 1000000000.0"),
        (".".join(100 * "a") + " = 1", "nested beyond all measure"),
        (".".join(2000 * "a") + " = 1", "a line with 1999 dots"),
        ("a = " + 300 * "[" + 300 * "]", "nested beyond all measure"),
        ('"' + 5000 * "k" + '" = 1', "kkk...: saw an unknown key"),
    ],
)
def test_what_no_bench_has_is_refused_and_named(tmp_path: Path, text: str, saw: str) -> None:
    said = refusal(tmp_path, text)
    assert saw in said
    assert len(said) < 1000


def test_the_largest_runs_that_are_known_are_plans() -> None:
    assert Plan(frames=16_666_666).patterns == 99_999_996
    assert Plan(frames=333_334, pattern_rate_hz=100_000.0).patterns > 2_000_000
    assert Plan(frames=1_666_667).run_time_s == pytest.approx(500.0, rel=1e-3)


def test_a_large_file_is_refused_by_its_size(tmp_path: Path) -> None:
    said = refusal(tmp_path, "#" * (MOST_BYTES + 1))
    assert f"{MOST_BYTES + 1} bytes or more, where {MOST_BYTES} are the most" in said
    with (tmp_path / "way.csv").open("wb") as stream:
        stream.truncate(10**12)
    with pytest.raises(InputError, match="1000000000000 bytes or more"):
        load_trajectory(tmp_path / "way.csv")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files")
def test_pipes_and_devices_are_refused_without_waiting(tmp_path: Path) -> None:
    for name in ("bench.toml", "plan.toml", "way.csv"):
        os.mkfifo(tmp_path / name)
    with pytest.raises(ConfigError, match="FIFO"):
        load_bench(tmp_path / "bench.toml")
    with pytest.raises(ConfigError, match="FIFO"):
        Plan.from_toml(tmp_path / "plan.toml")
    with pytest.raises(InputError, match="FIFO"):
        load_trajectory(tmp_path / "way.csv")
    with pytest.raises(ConfigError, match="a device"):
        Plan.from_toml("/dev/zero")
    with pytest.raises(InputError, match="a device"):
        load_trajectory(Path("/dev/zero"))


@pytest.mark.parametrize(
    ("rows", "saw"),
    [
        ("0,1e7,0", "line 2: saw '0,1e7,0'"),
        ("0,1e300,0", "at most 1000000"),
        ("0," + 200_000 * "1" + ",0", "field larger than field limit"),
        ("0," + 300 * "1" + "x,0", "1...'"),
        ("\0,1,2", "line 2"),
        pytest.param("0,1,2\n" * 1_000_001, "1000001 rows", marks=pytest.mark.thorough),
    ],
)
def test_a_trajectory_of_absurd_size_is_refused(tmp_path: Path, rows: str, saw: str) -> None:
    path = tmp_path / "way.csv"
    path.write_text("t_s,x_px,y_px\n" + rows)
    with pytest.raises(InputError) as caught:
        load_trajectory(path)
    assert saw in str(caught.value).replace(f"saw {path}, line 2: ", "line 2: saw ")
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize(
    "scene",
    [
        'faults = [{ kind = "double-edge", picture = 3, after_s = 1e9 }]',
        'faults = [{ kind = "surplus-edges", edges = 2000000000 }]',
        "start_px = [1e300, 0.0]",
        "mirror_transition_s = 1e9",
        "sync_jitter_s = 1e300",
        "axis_angle_deg = 1e300",
        'noise = { kind = "poisson", dark_rate_hz = 1e300 }',
    ],
)
def test_a_scene_beyond_all_measure_is_refused_at_its_line(tmp_path: Path, scene: str) -> None:
    with pytest.raises(ConfigError, match=rf"bench.toml:11: scene\.{scene.split(maxsplit=1)[0]}.*than or equal"):
        load_bench(bench_toml(tmp_path, scene))


def test_a_plan_that_exists_is_still_read(tmp_path: Path) -> None:
    assert Plan.from_toml(plan_toml(tmp_path)).frames == 40
