"""The command is ended from outside at every moment of its life, by one signal and by a storm of them.

The answer is always one paragraph, 128 and the signal's number, and a valid file or none.

Every signal is sent by the process itself at a known place, or by a second process that goes on until the first has gone. A test
that runs as a job in the background has inherited an ignored Ctrl-C, so each process begins by taking it up again.
"""

import json
import subprocess
import sys
from collections.abc import Generator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from instrument.plan import MotionPlan, Plan
from instrument.storage import open_recording
from tests.support.benches import bench_toml, plan_toml

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows ends a process without a word to it")

PLAN = Plan(
    frames=20,
    image_size=8,
    pattern_rate_hz=1000,
    motion=MotionPlan(start_mm=1.0, velocity_mm_s=25.0, acceleration_mm_s2=200.0, field="may-leave"),
)

BEGIN = """
import os, runpy, signal, subprocess, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
def send(name):
    os.kill(os.getpid(), getattr(signal, name))
def storm(name):
    flood = "import os, signal, sys, time\\nwhile True:\\n    os.kill(int(sys.argv[1]), getattr(signal, sys.argv[2]))"
    subprocess.Popen([sys.executable, "-c", flood + "; time.sleep(0.002)", str(os.getpid()), name], stdout=-3, stderr=-3)
def at(owner, name, act, when=lambda *_: True):
    before = getattr(owner, name)
    def wrapped(*arguments, **options):
        if when(*arguments):
            act()
        return before(*arguments, **options)
    setattr(owner, name, wrapped)
class AtImport:
    def __init__(self, wanted, act):
        self.wanted, self.act = wanted, act
    def find_spec(self, name, path=None, target=None):
        if name == self.wanted:
            sys.meta_path.remove(self)
            self.act()
def at_import(wanted, act):
    sys.meta_path.insert(0, AtImport(wanted, act))
"""

COMMAND = 'runpy.run_module("kinopix", run_name="__main__", alter_sys=True)\n'

LOADED = """
import gc, json, os, sys
import instrument.calibration, instrument.cli.main, instrument.live, instrument.session, instrument.storage, instrument.views.live
import sim_backends.devices.counter, sim_backends.devices.modulator, sim_backends.devices.stage
gc.freeze()  # copies need not look through what they share
for line in sys.stdin:
    program, told = json.loads(line)
    if os.fork() == 0:
        os.dup2(os.open(told, os.O_WRONLY | os.O_CREAT), 2)
        os.dup2(os.open(os.devnull, os.O_RDWR), 0)
        os.dup2(0, 1)
        exec(compile(program, "attacked", "exec"), globals())
        break
    print(os.waitstatus_to_exitcode(os.wait()[1]), flush=True)
"""
"""A program that has loaded what the command stands on, and becomes the command in a copy of itself, each time it is asked to."""


class Loaded:
    """That program. A run that is begun in it has nothing left to load, which takes most of the time otherwise."""

    def __init__(self, folder: Path) -> None:
        (folder / "attacked.py").write_text(LOADED)
        self._told = folder / "told"
        self._process = subprocess.Popen(
            [sys.executable, "-m", "attacked"], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def ended(self, what: str, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
        """As ``ended``."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        argv = ["kinopix", *map(str, arguments)]
        self._told.write_text("")
        self._process.stdin.write(
            json.dumps([f"{BEGIN}sys.argv = {argv!r}\n{what}\n{COMMAND}", str(self._told)]) + "\n"
        )
        self._process.stdin.flush()
        code = int(self._process.stdout.readline())
        return subprocess.CompletedProcess(argv, code, "", self._told.read_text())

    def close(self) -> None:
        self._process.communicate()


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> Generator[Loaded]:
    program = Loaded(tmp_path_factory.mktemp("loaded"))
    yield program
    program.close()


def ended(what: str, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Run the command in a process of its own, with ``what`` prepared to happen to it."""
    argv = f"sys.argv = {['kinopix', *map(str, arguments)]!r}\n"
    with TemporaryDirectory() as folder:  # as a module: only so is it ended as ``python -m kinopix`` is
        (Path(folder) / "attacked.py").write_text(BEGIN + argv + what + "\n" + COMMAND)
        return subprocess.run(
            [sys.executable, "-m", "attacked"],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )


def assert_one_paragraph(done: subprocess.CompletedProcess[str], code: int) -> None:
    assert done.returncode == code, done.stderr
    told = [line for line in done.stderr.splitlines() if line.startswith("kinopix: interrupted")]
    assert len(told) == 1, done.stderr
    assert "Traceback" not in done.stderr
    assert "Exception" not in done.stderr
    assert "Aborted" not in done.stderr


def assert_valid_or_none(path: Path) -> None:
    if path.exists():
        assert 0 < len(open_recording(path)) <= PLAN.frames
    assert [left for left in path.parent.iterdir() if left.suffix not in (".h5", ".toml")] == []


@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)])
@pytest.mark.parametrize("library", ["instrument.cli", "typer"])
@pytest.mark.parametrize("how", ["send", "storm"])
def test_a_signal_while_the_command_is_loaded_ends_it_in_one_line(name: str, code: int, library: str, how: str) -> None:
    """A storm is given a second to arrive, which the wait for a process that never comes takes."""
    wait = "" if how == "send" else ", signal.sigtimedwait([signal.SIGUSR1], 20)"
    done = ended(f"at_import({library!r}, lambda: ({how}({name!r}){wait}))", "--help")
    assert (done.returncode, done.stdout) == (code, "")
    assert done.stderr == "kinopix: interrupted before anything was begun\n"


@pytest.mark.parametrize("library", ["numpy", "h5py", "pydantic_core", "instrument.acquisition.run"])
def test_ctrl_c_while_a_command_loads_what_it_stands_on_is_told_in_one_line(tmp_path: Path, library: str) -> None:
    out = tmp_path / "run.h5"
    arguments = ("run", "--bench", bench_toml(tmp_path), "--plan", plan_toml(tmp_path, PLAN), "--out", out)
    assert_one_paragraph(ended(f"at_import({library!r}, lambda: send('SIGINT'))", *arguments), 130)
    assert not out.exists()


def test_a_signal_that_is_ignored_stays_ignored(tmp_path: Path) -> None:
    """As under ``nohup``, and as a job in the background, which inherits an ignored Ctrl-C."""
    out = tmp_path / "run.h5"
    arguments = ("run", "--bench", bench_toml(tmp_path), "--plan", plan_toml(tmp_path, PLAN), "--out", out)
    both = "lambda: (send('SIGHUP'), send('SIGINT'))"
    what = (
        "signal.signal(signal.SIGHUP, signal.SIG_IGN); signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        f"at_import('typer', {both})\nfrom instrument.storage import RecordingWriter\nat(RecordingWriter, 'append', {both})"
    )
    done = ended(what, *arguments)
    assert done.returncode == 0, done.stderr
    assert len(open_recording(out)) == PLAN.frames


PHASES = ("uploading", "positioning", "arming", "running up", "counting", "coming to rest", "storing")

MOMENTS = {
    **{
        phase: f"from instrument.session import work; at(work._Host, 'tell', ACT, lambda _self, phase: phase == {phase!r})"
        for phase in PHASES
    },
    "while the file is created": "from instrument.session import work; at(work, '_writer', ACT)",
    "when the file is there": "from instrument.acquisition import run; at(run.TimingAudit, '__init__', ACT)",
    "between audit and file": "from instrument.storage import RecordingWriter; at(RecordingWriter, 'finish', ACT)",
    "while the file is closed": "from instrument.storage import RecordingWriter; at(RecordingWriter, 'close', ACT)",
    "while the bench is made safe": "from instrument.session import instrument as i; at(i, 'make_safe', ACT)",
    "while devices are closed": "from sim_backends.devices.stage import SimulatedStage as s; at(s, '__exit__', ACT)",
}


STORMS = ("arming", "counting", "between audit and file", "while the file is closed", "while devices are closed")


@pytest.mark.parametrize(
    ("moment", "how"),
    [
        *((moment, "send") for moment in MOMENTS),
        *(
            pytest.param(moment, "storm", marks=[] if moment in STORMS else [pytest.mark.thorough])
            for moment in MOMENTS
        ),
    ],
)
def test_ctrl_c_at_any_moment_of_a_run(loaded: Loaded, tmp_path: Path, moment: str, how: str) -> None:
    """A storm begins there and goes on, every 2 ms, until the process has gone."""
    out = tmp_path / "run.h5"
    arguments = ("run", "--bench", bench_toml(tmp_path), "--plan", plan_toml(tmp_path, PLAN), "--out", out)
    wait = "" if how == "send" else ", signal.sigtimedwait([signal.SIGUSR1], 0.2)"
    act = f"lambda: ({how}('SIGINT'){wait})"
    assert_one_paragraph(loaded.ended(MOMENTS[moment].replace("ACT", act), *arguments), 130)
    assert_valid_or_none(out)


def test_an_interrupt_that_is_lost_in_a_destructor_comes_again(loaded: Loaded, tmp_path: Path) -> None:
    """Python can raise nothing out of a destructor: it prints a traceback there, and goes on."""
    out = tmp_path / "run.h5"
    scene = "realtime = true"
    slow = PLAN.model_copy(update={"frames": 2000, "motion": None})
    arguments = ("run", "--bench", bench_toml(tmp_path, scene), "--plan", plan_toml(tmp_path, slow), "--out", out)
    what = (
        "class Dying:\n"
        "    def __del__(self):\n"
        "        send('SIGINT')\n"
        "        [None for _ in range(1000)]\n"
        "from instrument.session import Run\n"
        "at(Run, 'wait', lambda: Dying())"
    )
    assert_one_paragraph(loaded.ended(what, *arguments), 130)


def test_an_interrupt_in_the_text_of_an_exec_ends_with_the_same_code(tmp_path: Path) -> None:
    """Python would end by the signal itself (-2), though the interrupt was met: dataclasses and pydantic run such texts."""
    out = tmp_path / "run.h5"
    arguments = ("run", "--bench", bench_toml(tmp_path), "--plan", plan_toml(tmp_path, PLAN), "--out", out)
    text = "send('SIGINT')\\n[None for _ in range(1000)]"
    what = f'from instrument.session import Run\nat(Run, "wait", lambda: exec("{text}", globals()))'
    assert_one_paragraph(ended(what, *arguments), 130)
