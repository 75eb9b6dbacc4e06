"""Attacks on the command from outside: signals at random moments, two writers of one file, and inputs that were tampered with.

Linux only: a process that is attacked is watched through ``/proc`` until it hears signals at all.
"""

import contextlib
import io
import os
import random
import signal
import subprocess
import sys
import tempfile
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Final

from benchmarks.simulated import bench_text, plan_text, run_command
from instrument.cli.main import status
from instrument.storage import open_recording
from protocols import KinopixError, MonotonicClock

_HANGS_S: Final = 10.0
_MOST_KB: Final = 2_000_000
_CODES: Final = {"SIGINT": 130, "SIGTERM": 143, "SIGHUP": 129}

_NOISE: Final = 'noise = { kind = "pixel", sigma = 0.1, seed = 1 }'


@dataclass(frozen=True)
class Row:
    """One attack and what came of it."""

    attack: str
    """What was done, and when."""

    wrong: str
    """What was not as it should be; empty where nothing was."""

    took_s: float
    """From the attack to the end, in seconds."""

    @property
    def good(self) -> bool:
        """Whether everything was as it should be."""
        return not self.wrong


def signals(count: int, seed: int) -> list[Row]:
    """Send one to three signals to a run at a random moment, up to 40 ms apart: from the first import to the last."""
    chance, rows = random.Random(seed), list[Row]()
    for _ in range(count):
        name, times, moment_s = chance.choice(list(_CODES)), chance.randrange(1, 4), chance.uniform(0.0, 2.5)
        gaps_s = [chance.uniform(0.0, 0.04) for _ in range(times - 1)]
        with tempfile.TemporaryDirectory(prefix="kinopix-attack-") as folder:
            rows.append(_signalled(Path(folder), name, moment_s, gaps_s))
    return rows


def _signalled(folder: Path, name: str, moment_s: float, gaps_s: list[float]) -> Row:
    clock, number = MonotonicClock(), getattr(signal, name)
    with (folder / "said").open("w+b") as said, _begun(folder, said, realtime=True) as run:
        while not _hears(run.pid) and os.waitid(os.P_PID, run.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
            clock.sleep_s(0.001)
        clock.sleep_s(moment_s)
        sent_s = clock.now_s()
        for gap_s in (0.0, *gaps_s):
            clock.sleep_s(gap_s)
            os.kill(run.pid, number)  # a process that has ended takes it too, until it is waited for
        _, ended, usage = os.wait4(run.pid, 0)
        run.returncode = code = os.waitstatus_to_exitcode(ended)
        took_s = clock.now_s() - sent_s
        said.seek(0)
        text = said.read().decode(errors="replace")
    wrong: list[str] = []
    if code != _CODES[name] and not (code == 0 and "recorded" in text):
        wrong.append(f"exit code {code}")
    if "Traceback" in text or text.count("kinopix: ") > 1:
        wrong.append(f"it said {text[-300:]!r}")
    if took_s > _HANGS_S:
        wrong.append(f"it took {took_s:.1f} s")
    if usage.ru_maxrss > _MOST_KB:
        wrong.append(f"it took {usage.ru_maxrss / 1e6:.1f} GB")
    wrong += _file(folder / "run.h5")
    return Row(f"{name} x{1 + len(gaps_s)} at {moment_s:.2f} s", "; ".join(wrong), took_s)


def _begun(folder: Path, said: IO[bytes], *, realtime: bool) -> subprocess.Popen[bytes]:
    (folder / "bench.toml").write_text(bench_text(_NOISE, realtime=realtime), encoding="utf-8")
    (folder / "plan.toml").write_text(_plan(frames=4000 if realtime else 400), encoding="utf-8")
    # A job in the background inherits an ignored Ctrl-C: what is attacked takes it up again.
    begin = (
        "import os, signal, sys; signal.signal(signal.SIGINT, signal.SIG_DFL); os.execv(sys.executable, sys.argv[1:])"
    )
    command = [sys.executable, "-c", begin, *run_command(folder, folder / "run.h5")]
    return subprocess.Popen(command, stdout=said, stderr=said)


def _plan(frames: int) -> str:
    return plan_text(frames, image_size=16, velocity_mm_s=5.0)


def _hears(pid: int) -> bool:
    """Whether a process has a handler for SIGTERM: Python itself has none."""
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{pid}/status").read_text(encoding="ascii").splitlines():
            if line.startswith("SigCgt:"):
                return bool(int(line.split()[1], 16) >> (signal.SIGTERM - 1) & 1)
    return False


def _file(path: Path) -> list[str]:
    """What is wrong with a file that must be a recording, or not there."""
    if not path.exists():
        return []
    try:
        open_recording(path)
    except KinopixError as error:
        return [f"the file: {error}"]
    return []


def two_writers(count: int, seed: int) -> list[Row]:
    """Begin two runs into one file, up to 0.3 s apart: one records, the other is refused with 2."""
    chance, clock, rows = random.Random(seed), MonotonicClock(), list[Row]()
    for _ in range(count):
        gap_s, begun_s = chance.uniform(0.0, 0.3), clock.now_s()
        with tempfile.TemporaryDirectory(prefix="kinopix-attack-") as name, (Path(name) / "said").open("w+b") as said:
            folder = Path(name)
            one = _begun(folder, said, realtime=False)
            clock.sleep_s(gap_s)
            other = _begun(folder, said, realtime=False)
            codes = sorted((one.wait(), other.wait()))
            said.seek(0)
            text = said.read().decode(errors="replace")
            wrong = [] if codes == [0, 2] else [f"exit codes {codes}"]
            wrong += [f"it said {text[-300:]!r}"] if "Traceback" in text else []
            wrong += _file(folder / "run.h5")
        rows.append(Row(f"{gap_s:.2f} s apart", "; ".join(wrong), clock.now_s() - begun_s))
    return rows


def hostile_inputs(count: int, seed: int) -> list[Row]:
    """Give the command settings and recordings in which bytes were changed, cut, or doubled."""
    chance, clock, rows = random.Random(seed), MonotonicClock(), list[Row]()
    with tempfile.TemporaryDirectory(prefix="kinopix-attack-") as name:
        folder = Path(name)
        whole = {
            "bench.toml": bench_text(_NOISE).encode(),
            "plan.toml": _plan(frames=10).encode(),
        }
        for file, data in whole.items():
            (folder / file).write_bytes(data)
        settings = ["--bench", str(folder / "bench.toml"), "--plan", str(folder / "plan.toml")]
        _answered(["run", *settings, "--out", str(folder / "run.h5")])
        whole["run.h5"] = (folder / "run.h5").read_bytes()
        for _ in range(count):
            file = chance.choice(list(whole))
            (folder / file).write_bytes(_spoiled(whole[file], chance))
            command = ["info", str(folder / file)] if file == "run.h5" else ["check", *settings]
            begun_s = clock.now_s()
            wrong = _answered(command)
            took_s = clock.now_s() - begun_s
            if not wrong and file == "run.h5":
                wrong = "; ".join(
                    part for part in _file(folder / file) if "damaged" not in part and "To do" not in part
                )
            if took_s > _HANGS_S:
                wrong += f" it took {took_s:.1f} s"
            rows.append(Row(f"{file} spoiled", wrong, took_s))
            (folder / file).write_bytes(whole[file])
    return rows


def _spoiled(data: bytes, chance: random.Random) -> bytes:
    place = chance.randrange(len(data))
    match chance.randrange(4):
        case 0:
            return data[:place]
        case 1:
            return data[:place] + bytes(chance.randrange(256) for _ in range(8)) + data[place + 8 :]
        case 2:
            return data[:place] + data[place // 2 :]
        case _:
            changed = bytearray(data)
            for _ in range(20):
                changed[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
            return bytes(changed)


def _answered(arguments: list[str]) -> str:
    """What is wrong with the answer of a command: an error that is none of ours, or an exit code that is none of its own."""
    quiet = io.StringIO()
    try:
        with contextlib.redirect_stdout(quiet), contextlib.redirect_stderr(quiet):
            code = status(arguments)
    except Exception:  # noqa: BLE001 - whatever it is, it is what is looked for
        return traceback.format_exc()[-600:]
    return "" if code in (0, 2, 3) else f"exit code {code}"
