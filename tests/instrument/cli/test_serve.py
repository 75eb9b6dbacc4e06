"""``kinopix serve`` and ``kinopix run --web``."""

import json
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from instrument.cli.main import status
from instrument.storage import open_recording
from tests.support.benches import bench_toml, plan_toml


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--host", "0.0.0.0"], "without a token"),  # noqa: S104
        (["--host", "0.0.0.0", "--control", "--bench", "bench.toml"], "without a token"),  # noqa: S104
        (["--token", "short"], "at least 16 plain characters"),
        (["--control"], "--plan or --control without a bench"),
        (["--plan", "plan.toml"], "--plan or --control without a bench"),
        (["no-such-folder"], "no folder"),
        (["--host", "192.0.2.1", "--token", "sixteen-letters!"], "an address of this machine"),
    ],
)
def test_what_cannot_be_served_is_refused(
    arguments: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert status(["serve", "--port", "0", *arguments]) == 2
    assert said in capsys.readouterr().err


def test_without_the_libraries_it_says_how_to_get_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def finds_nothing(_name: str) -> None: ...

    monkeypatch.setattr("instrument.web.server.find_spec", finds_nothing)
    assert status(["serve", str(tmp_path)]) == 2
    assert "pip install 'kinopix[web]'" in capsys.readouterr().err


def test_a_run_with_a_page_says_where_it_is_and_records(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench, out = bench_toml(tmp_path, 'object = "letter-B"'), tmp_path / "run.h5"
    command = ["run", "--web", "--port", "0", "--json", "--bench", bench, "--plan", plan_toml(tmp_path), "--out", out]
    assert status([str(word) for word in command]) == 0
    said = capsys.readouterr()
    assert "page: http://127.0.0.1:" in said.err
    assert "token" not in said.err
    assert json.loads(said.out)["timing"]["verdict"] == "good"
    assert len(open_recording(out)) == 40


def test_a_page_that_may_steer_gets_a_token_of_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench, out = bench_toml(tmp_path), tmp_path / "run.h5"
    command = [
        "run",
        "--web",
        "--control",
        "--port",
        "0",
        "--bench",
        bench,
        "--plan",
        plan_toml(tmp_path),
        "--out",
        out,
    ]
    assert status([str(word) for word in command]) == 0
    token = capsys.readouterr().err.split("?token=")[1].split()[0]
    assert len(token) >= 16


def test_a_page_that_cannot_be_served_keeps_the_run_from_beginning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bench, out = bench_toml(tmp_path), tmp_path / "run.h5"
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        command = ["run", "--web", "--port", port, "--bench", bench, "--plan", plan_toml(tmp_path), "--out", out]
        assert status([str(word) for word in command]) == 2
    assert f"port {port} of 127.0.0.1 refused" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows ends a process without a word to it")
def test_ctrl_c_ends_it_within_two_seconds_though_a_viewer_hangs(tmp_path: Path) -> None:
    begin = "import signal, runpy; signal.signal(signal.SIGINT, signal.default_int_handler); "
    run = "runpy.run_module('kinopix', run_name='__main__', alter_sys=True)"
    arguments = ["serve", str(tmp_path), "--bench", str(bench_toml(tmp_path)), "--port", "0"]
    served = subprocess.Popen([sys.executable, "-c", begin + run, *arguments], stderr=subprocess.PIPE, text=True)
    assert served.stderr is not None
    line = served.stderr.readline()
    port = int(line.split(":")[-1].strip().strip("/"))
    with socket.create_connection(("127.0.0.1", port), timeout=10) as hung:
        hung.sendall(
            f"GET /live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        answer = b""
        while b"simulated KA400Z" not in answer:  # the bench is open, and shown
            answer += hung.recv(4096)
        begun_s = time.monotonic()
        served.send_signal(signal.SIGINT)
        said = served.communicate(timeout=20)[1]
    assert served.returncode == 130
    assert said == "kinopix: interrupted; the bench is safe\n"
    assert time.monotonic() - begun_s < 4  # 2 s for the server, and as long for the process on a busy machine
