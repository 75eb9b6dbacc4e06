"""The emulator's server is in this process: what the environment says of other hosts has no part in it."""

from pathlib import Path

import pytest

from instrument.session import Instrument
from tests.faults.bench import bench_toml
from tests.faults.row import Row
from tests.support.benches import SMALL


@pytest.mark.parametrize("name", ["http_proxy", "https_proxy", "all_proxy", "grpc_proxy"])
def test_a_proxy_does_not_come_between_driver_and_emulator(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """Port 9 takes nothing. Without a list of exceptions, 127.0.0.1 too would be asked for there."""
    for exception in ("no_proxy", "NO_PROXY", "no_grpc_proxy"):
        monkeypatch.delenv(exception, raising=False)
    monkeypatch.setenv(name, "http://127.0.0.1:9")
    with Instrument.from_toml(bench_toml(Row(fault="none", counter="ni"), tmp_path)) as bench:
        assert len(bench.run(SMALL, tmp_path / "run.h5")) == SMALL.frames
