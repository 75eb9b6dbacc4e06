"""The example benches agree with themselves: the counter takes back the dead time by which the scene loses."""

import tomllib
from pathlib import Path

import pytest

from instrument.session import Instrument

BENCHES = Path(__file__).parents[2] / "examples" / "benches"


@pytest.mark.parametrize("path", sorted(BENCHES.glob("*.toml")), ids=lambda path: path.stem)
def test_the_counter_has_the_dead_time_of_the_scene_and_its_light_is_in_the_linear_range(path: Path) -> None:
    """20 ns: at most 5 million counts a second, 250 in a pattern of 50 us. A USB-CTR's 20.8 ns are the same within 5 %.

    A serial counter's 35 ns: at most 142. Where volts are measured nothing is counted: scene and counter have no dead time.
    """
    noise = tomllib.loads(path.read_text())["scene"]["noise"]
    with Instrument.from_toml(path) as bench:
        limits = bench.devices.counter.limits
    assert limits.dead_time_s == pytest.approx(noise.get("dead_time_s", 0.0), rel=0.05)
    assert noise["peak_counts"] < limits.max_count_rate_hz * 50e-6
