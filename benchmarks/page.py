"""What the page reaches in a browser: ``python -m benchmarks.page [--seconds 2] [--viewers 1] [--picture FILE | --alone]``.

A run at 20 kHz (128 px) is simulated once; then its counts are played again in real time, by simulated devices whose light is
known already, so that the computer has only that to do which it has on a real bench: record, follow the object, make images,
serve the page. Chromium looks on without a screen, and says when each image was painted.

It needs Chromium: ``apt-get install chromium``, or KINOPIX_CHROMIUM with the path of the program.
"""

import argparse
import os
import shutil
import socket
import sys
import time
from contextlib import chdir
from datetime import UTC, datetime
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event as Flag
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

from benchmarks.simulated import bench_text
from instrument import Instrument, Plan
from instrument.analysis import analyse, store
from instrument.config import CalibratedDevice, Calibration, DisplacementSection, write_calibration
from instrument.live import LiveAnalysis
from instrument.plan import MotionPlan
from instrument.session import Event, ImageEvent, TrackingEvent
from instrument.storage import open_recording
from instrument.views import write_pictures
from instrument.web import Board, Desk, PageServer, RunPage, Shelf
from protocols import Floats

_SCENE = ("start_px = [32.4, 32.7]", 'noise = { kind = "poisson", seed = 1, peak_counts = 200.0 }')

_DEVICES = {
    "modulator": CalibratedDevice(vendor="Kinopix", model="simulated DLP7000"),
    "counter": CalibratedDevice(vendor="Kinopix", model="simulated H10682 and counter"),
    "stage": CalibratedDevice(vendor="Kinopix", model="simulated KA400Z"),
}
_SCALE = DisplacementSection(
    date=datetime(2023, 4, 1, tzinfo=UTC),
    image_size=128,
    superpixel=2,
    px_per_mm_x=7.2 / 2**0.5,
    px_per_mm_y=7.2 / 2**0.5,
    covariance=((1e-4, 0.0), (0.0, 1e-4)),
)
"""The scale that simulated benches have unless told otherwise."""

_IMAGES_HZ = 52


def main() -> None:
    """Print one line a figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=2.0, help="of the run")
    parser.add_argument("--viewers", type=int, default=1, help="pages in the browser")
    parser.add_argument("--frozen", type=int, default=0, help="viewers that take nothing")
    parser.add_argument("--picture", type=Path, default=None, help="PNG to write: the page in the midst of the run")
    parser.add_argument("--alone", action="store_true", help="no run: 52 images a second that were made before")
    arguments = parser.parse_args()
    chromium = os.environ.get("KINOPIX_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        sys.exit("no Chromium: apt-get install chromium, or set KINOPIX_CHROMIUM to the program")
    print(f"cores {os.cpu_count()}, load {os.getloadavg()[0]:.1f}, {chromium}")
    if arguments.alone:
        alone(chromium, arguments.seconds)
        return
    frames = round(arguments.seconds * 20_000 / 6)
    velocity = 12.0 / arguments.seconds
    plan = Plan(frames=frames, motion=MotionPlan(velocity_mm_s=velocity, acceleration_mm_s2=50.0))
    if arguments.picture is not None:
        arguments.picture = arguments.picture.resolve()
    with TemporaryDirectory() as folder, chdir(folder):
        Path("runs").mkdir()
        played(Path("runs"), plan, chromium, arguments)


def played(folder: Path, plan: Plan, program: str, arguments: argparse.Namespace) -> None:
    """Simulate the run, play it again with pages that look on, and print what they saw."""
    picture: Path | None = arguments.picture
    counts, pause = _simulated(folder, plan), Flag()
    bench = folder / "bench.toml"
    bench.write_text(bench_text(*_SCENE, realtime=True, calibration="mine.toml"))
    shelf = None if picture is None else Shelf(_analysed(folder))
    page, made = RunPage(Board("bench.toml"), Desk()), list[float]()

    def known(edge: int, n: int) -> Floats:
        return counts[edge : edge + n]

    def note(event: Event) -> None:
        if isinstance(event, ImageEvent) and not event.final:
            made.append(time.time())

    with (
        Instrument.from_toml(bench) as instrument,
        PageServer(page.board, page.desk, shelf, port=0) as server,
        sync_playwright() as library,
    ):
        chromium = library.chromium.launch(executable_path=program, args=["--no-sandbox"])
        scene: Any = instrument.devices.scene
        scene.counts = known
        hung = [_frozen(server.port) for _ in range(arguments.frozen)]
        tabs = [chromium.new_page() for _ in range(arguments.viewers)]
        for tab in tabs:
            tab.goto(server.address)
        board = page.begins(instrument, plan)
        zero_s = time.time() - scene.clock.now_s()
        live = LiveAnalysis(plan)
        spent_s = time.process_time()
        with instrument.start(plan, folder / "again.h5", listeners=[live, board, note]) as run:
            board.show_run(run)
            board.say("recording")
            while run.snapshot.patterns_done == 0:
                pause.wait(0.01)
            first_edge_s = zero_s + _first_edge_s(scene)
            if picture is not None:
                pause.wait(0.7 * plan.run_time_s)
                taken = tabs[0].screenshot(full_page=True)
                Image.open(BytesIO(taken)).quantize(250).save(picture, optimize=True)
            while not run.done:
                pause.wait(0.05)
            recording = run.wait()
            spent_s = time.process_time() - spent_s
            run.wait_for_listeners(10.0)
        tabs[0].wait_for_timeout(200)
        seen = [tab.evaluate("kinopix.seen") for tab in tabs]
        for line in hung:
            line.close()
    end_s = first_edge_s + plan.run_time_s
    print(
        f"recording equal to the one without viewers: {np.array_equal(recording.values.ravel(), counts[: plan.patterns])}"
    )
    print(
        f"live images made: {len(made) / plan.run_time_s:.1f} a second; the process used {spent_s / plan.run_time_s:.2f} cores"
    )
    for tab in seen:
        _print(tab, first_edge_s, end_s, plan.frame_time_s)


def alone(program: str, seconds: float) -> None:
    """Show images that were made before, as often as a run makes them, and print what server and page take for it."""
    board, pause = Board("no run"), Flag()
    images = [np.random.default_rng(seed).random((128, 128)) for seed in range(8)]
    with PageServer(board, port=0) as server, sync_playwright() as library:
        tab = library.chromium.launch(executable_path=program, args=["--no-sandbox"]).new_page()
        tab.goto(server.address)
        pause.wait(1.0)
        count = round(_IMAGES_HZ * seconds)
        spent_s, begun_s = time.process_time(), time.time()
        for k in range(count):
            board(ImageEvent(frame=64 * k, image=images[k % len(images)]))
            board(TrackingEvent(frame=64 * k, displacement_px=np.full((64, 2), 0.1 * k)))
            pause.wait(max(0.0, begun_s + (k + 1) / _IMAGES_HZ - time.time()))
        spent_s = time.process_time() - spent_s
        pause.wait(0.3)
        seen = tab.evaluate("kinopix.seen")
    middle, late, latest = np.percentile(seen["delays_ms"], [50, 95, 100])
    print(f"images painted: {len(seen['delays_ms']) / seconds:.1f} a second of {_IMAGES_HZ}")
    print(f"from send to paint: median {middle:.1f} ms, 95 % {late:.1f} ms, at most {latest:.1f} ms")
    print(f"the server's process used {spent_s / seconds:.2f} cores")


def _print(seen: dict[str, Any], first_edge_s: float, end_s: float, frame_s: float) -> None:
    lags = np.array(seen["lags"])
    during = lags[:, 1] < end_s + 0.1
    delays_ms = np.array(seen["delays_ms"])[during]
    lag_ms = 1e3 * (lags[during, 1] - first_edge_s - lags[during, 0] * frame_s)
    rate = float(during.sum()) / (end_s + 0.1 - float(lags[0, 1]))
    middle, late, latest = np.percentile(delays_ms, [50, 95, 100])
    print(f"images painted: {rate:.1f} a second; missed {seen['skipped']} in the server, {seen['dropped']} in the page")
    print(f"from send to paint: median {middle:.1f} ms, 95 % {late:.1f} ms, at most {latest:.1f} ms")
    print(f"from photon to paint: median {np.median(lag_ms):.0f} ms, 95 % {np.percentile(lag_ms, 95):.0f} ms")


def _analysed(folder: Path) -> Path:
    """Analyse the simulated run, draw its pictures, and give the folder."""
    recording = open_recording(folder / "before.h5")
    analysis = analyse(recording)
    store(folder / "before.h5", recording, analysis)
    write_pictures(analysis, folder, "before")
    return folder


def _simulated(folder: Path, plan: Plan) -> Floats:
    """Counts of every pattern, the guard picture's last."""
    bench = folder / "before.toml"
    write_calibration(folder / "mine.toml", Calibration(bench=_DEVICES, displacement=_SCALE))
    bench.write_text(bench_text(*_SCENE, calibration="mine.toml"))
    with Instrument.from_toml(bench) as instrument:
        scene: Any = instrument.devices.scene
        instrument.run(plan, folder / "before.h5")
        counts: Floats = scene.counts(0, plan.patterns)
    recorded = open_recording(folder / "before.h5").values.ravel()
    assert np.array_equal(counts, recorded)  # noqa: S101 - the benchmark's own premise
    return np.append(counts, 0.0)


def _first_edge_s(scene: Any) -> float:
    return float(scene.edges(0, scene.clock.now_s()).time_s[0])


def _frozen(port: int) -> socket.socket:
    """Open a websocket that takes nothing."""
    line = socket.create_connection(("127.0.0.1", port))
    line.sendall(
        f"GET /live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    return line


if __name__ == "__main__":
    main()
