"""What the live analysis reaches: ``python benchmarks/streaming.py [--minutes 10] [--seed 1] [--shuffle 0]``.

One run of the standard simulation (128 px, 1,666 frames at 20 kHz, noise of 0.1 on every pixel, letter of 36 px, 66 px of way,
patterns in TV order, not shuffled) is played in real time, a block every 20 ms, to the live analysis on its thread. Then a
stream at 22.7 kHz goes through it as fast as it can. On two cores set OPENBLAS_NUM_THREADS=1.
"""

import argparse
import os
import resource
import time
from dataclasses import dataclass, field

import numpy as np

from benchmarks.scenes import FRAMES, letter_b, recorded
from instrument.acquisition import AlignedBlock
from instrument.live import LiveAnalysis, LiveLine
from instrument.numerics import psnr
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.schemes import FourierHadamardSettings
from instrument.session import BlockEvent, Channel, Event, FinishedEvent, ImageEvent, TrackingEvent
from instrument.tracking import StreamingTracker
from protocols import Floats, MonotonicClock

BLOCK_S = 0.02
_NONE = np.zeros(0, np.int64)


def main() -> None:
    """Print one line a figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0, help="of the long stream")
    parser.add_argument("--seed", type=int, default=1, help="of the noise")
    parser.add_argument("--shuffle", type=int, default=None, help="shuffle_seed of the plan; none keeps TV order")
    arguments = parser.parse_args()
    print(
        f"cores {os.cpu_count()}, load {os.getloadavg()[0]:.1f}, BLAS threads {os.environ.get('OPENBLAS_NUM_THREADS', 'all')}"
    )
    recording = standard_run(arguments.seed, arguments.shuffle)
    tracking(recording)
    real_time(recording)
    long_stream(arguments.minutes)
    hurried(recording)


def standard_run(seed: int, shuffle_seed: int | None) -> Recording:
    """The run that all figures are stated for."""
    plan = Plan(frames=FRAMES, scheme=FourierHadamardSettings(shuffle_seed=shuffle_seed))

    def path(time_s: Floats) -> Floats:
        way = (time_s + time_s**2) / 0.75
        return np.stack([66 * way, 63 * way], axis=1)

    return recorded(plan, letter_b(12, 14), path, sigma=0.1, seed=seed)


def tracking(recording: Recording) -> None:
    """Time a frame takes, the median of five."""
    for frames in (1, 16, 67, 167):
        took_s: list[float] = []
        for _ in range(5):
            tracker = StreamingTracker(recording.plan)
            start_s = time.perf_counter()
            for first in range(0, len(recording), frames):
                tracker.push(recording.values[first : first + frames])
            took_s.append(time.perf_counter() - start_s)
        print(f"tracking, {frames} frames at a time: {np.median(took_s) / len(recording) * 1e6:.1f} us a frame")


@dataclass
class Watch:
    """Notes when the live analysis tells something."""

    heard: list[tuple[float, Event]] = field(default_factory=list[tuple[float, Event]])

    def __call__(self, event: Event) -> None:
        """Note what the live analysis tells."""
        if isinstance(event, TrackingEvent | ImageEvent):
            self.heard.append((time.perf_counter(), event))


def real_time(recording: Recording) -> None:
    """Images a second and their quality while the run goes on at its own pace."""
    truth, watch, clock = recording.truth, Watch(), MonotonicClock()
    assert truth is not None  # noqa: S101  (simulated)
    values = recording.values.ravel()
    patterns = round(BLOCK_S / recording.picture_time_s)
    live, channel = LiveAnalysis(recording.plan), Channel()
    channel.subscribe(watch)
    channel.subscribe(live)
    clock.sleep_s(0.1)
    start_s = time.perf_counter()
    for first in range(0, len(values), patterns):
        part = values[first : first + patterns]
        clock.sleep_s(start_s + (first + len(part)) * recording.picture_time_s - time.perf_counter())
        channel.publish(BlockEvent.of(block(first, part)))
    ended_s = time.perf_counter()
    channel.publish(FinishedEvent(outcome="done"))
    channel.join()
    made = [(at_s - start_s, event.image) for at_s, event in watch.heard if isinstance(event, ImageEvent)]
    counters, run_s = live.counters, recording.plan.run_time_s
    print(f"live images: {counters.images / run_s:.0f} a second; skipped {counters.images_skipped}")
    print(f"frames followed: {counters.frames} of {len(recording)}; dropped {counters.frames_dropped}")
    for moment_s in (0.1, 0.2, 0.5):
        latest = [image for at_s, image in made if at_s <= moment_s]
        if latest:
            print(f"PSNR of the image on show after {moment_s} s: {psnr(latest[-1], truth.image):.1f} dB")
    if made:
        last_s, last = made[-1]
        late_ms = (last_s - (ended_s - start_s)) * 1e3
        print(f"polished image: {psnr(last, truth.image):.1f} dB, {late_ms:.0f} ms after the last frame")


def long_stream(minutes: float) -> None:
    """Memory over a stream of minutes at 22.7 kHz, an image every ten seconds of it."""
    plan = Plan(frames=round(minutes * 60 * 22_700 / 6), pattern_rate_hz=22_700)
    line = LiveLine(plan, image_interval_s=10.0)
    patterns = round(0.05 / plan.picture_time_s)
    rng = np.random.default_rng(0)
    start_s, early_mb, early_s = time.perf_counter(), 0.0, 20.0
    for first in range(0, 6 * plan.frames, patterns):
        size = min(patterns, 6 * plan.frames - first)
        line.take([block(first, rng.normal(450, 9, size))])
        if line.images_due:
            line.improve()
        if early_mb == 0.0 and first * plan.picture_time_s > early_s:
            early_mb = peak_mb()
    line.finish()
    took_s = time.perf_counter() - start_s
    share = took_s / minutes / 60
    print(f"{minutes:g} minutes at 22.7 kHz: {line.counters.frames} frames in {took_s:.0f} s, {share:.1%} of real time")
    print(f"peak memory of the process: {early_mb:.1f} MB after {early_s:g} s of stream, {peak_mb():.1f} MB at its end")


def hurried(recording: Recording) -> None:
    """What is dropped when thirty runs' worth of blocks come at once: all is counted."""
    plan = recording.plan.model_copy(update={"frames": 30 * len(recording)})
    values = recording.values.ravel()
    live, channel = LiveAnalysis(plan), Channel()
    listening = channel.subscribe(live)
    for turn in range(30):
        channel.publish(BlockEvent.of(block(turn * len(values), values)))
    channel.publish(FinishedEvent(outcome="done"))
    channel.join()
    counters = live.counters
    print(
        f"{plan.frames} frames at once: {counters.frames_dropped} dropped in {listening.feed.blocks_dropped} blocks, "
        f"{counters.images_skipped} images skipped, error {listening.error}"
    )


def block(first_pattern: int, values: Floats) -> AlignedBlock:
    """A block in which all is well."""
    return AlignedBlock(first_pattern, values, np.ones(len(values), np.bool_), None, _NONE, _NONE, _NONE)


def peak_mb() -> float:
    """Largest resident memory so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    main()
