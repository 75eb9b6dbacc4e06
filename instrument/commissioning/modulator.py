"""What can be measured of a modulator by itself."""

from typing import Final

import numpy as np

from instrument.commissioning.showing import DARK, PATIENCE_S, SAMPLES, picture_time, sequence_of
from protocols import Answer, Clock, DeviceTimeout, PatternModulator

PICTURES: Final = 1000
"""Pictures of the play order, where it has room for them."""

UPLOADED: Final = 24
"""Random patterns that are stored."""

_LOOK_S: Final = 0.001
"""Time between two looks at a modulator that was halted."""

_LONG_S: Final = 10.0
"""Length of the run that is halted."""

_MID_RUN_S: Final = 0.1
"""Time from its start to the halt."""

_TOO_SLOW: Final = 1.2
"""Upload of a pattern over the longest that is promised, from which on it is doubted."""

_LATE_S: Final = 0.05
_LATE: Final = 0.02
"""Difference of a run from its expected length, and share of that length, that are allowed together."""


def upload(modulator: PatternModulator, clock: Clock) -> Answer:
    """How long random patterns take to be stored. Nothing is shown."""
    limits = modulator.limits
    unique = min(UPLOADED, limits.unique_patterns - 1)
    random = np.random.default_rng(1).integers(0, 2, (unique, SAMPLES, SAMPLES), dtype=np.uint8)
    sequence, timing = sequence_of(limits, list(random), range(unique)), picture_time(limits, 10_000)
    began_s = clock.now_s()
    kept = modulator.load(sequence, timing)
    took_s = clock.now_s() - began_s
    each_s = took_s / (unique + 1)
    doubts: list[str] = []
    if limits.longest_upload_s and each_s > _TOO_SLOW * limits.longest_upload_s:
        doubts.append(f"a pattern takes {each_s:.3g} s, and {limits.longest_upload_s:.3g} s at most are promised")
    if kept.picture_time_us != timing.picture_time_us:
        doubts.append(f"a picture time of {timing.picture_time_us} us was asked, {kept.picture_time_us} us are kept")
    return Answer(
        said=f"{unique + 1} patterns stored in {took_s:.3g} s; sync {kept.sync_delay_us} us before its picture, "
        f"{kept.sync_width_us} us long",
        figures={"patterns": unique + 1, "upload_s": took_s, "upload_s_per_pattern": each_s, **kept.model_dump()},
        doubts=tuple(doubts),
    )


def playing(modulator: PatternModulator, clock: Clock) -> Answer:
    """Start, end and halt of dark pictures at the highest rate."""
    limits = modulator.limits
    n = min(PICTURES, limits.play_order_entries - 1)
    kept = modulator.load(sequence_of(limits, [DARK], [0] * n), picture_time(limits, 0))
    expected_s = (n + 1) * kept.picture_time_us * 1e-6
    modulator.start()
    began_s = clock.now_s()
    at_once = modulator.running
    modulator.wait(expected_s + PATIENCE_S)
    took_s = clock.now_s() - began_s
    after = modulator.running
    modulator.load(sequence_of(limits, [DARK], [0] * n), picture_time(limits, _LONG_S * 1e6 / n))
    modulator.start()
    clock.sleep_s(_MID_RUN_S)
    between = modulator.running
    halt_s = _halted(modulator, clock)
    other_length = abs(took_s - expected_s) > _LATE_S + _LATE * expected_s
    doubts = {
        "it does not say that it plays at once after the start": not at_once,
        "it says that it plays after its end": after,
        "it does not say that it plays in mid-run": not between,
        "the run's length is not pictures times picture time": other_length,
    }
    return Answer(
        said=f"{n + 1} pictures of {kept.picture_time_us} us: over {took_s:.4g} s after the start, {expected_s:.4g} s expected; "
        f"a halt in mid-run is obeyed within {halt_s:.2g} s",
        figures={
            "pictures": n + 1,
            "picture_time_us": kept.picture_time_us,
            "run_s": took_s,
            "expected_s": expected_s,
            "runs_at_once": at_once,
            "halt_s": halt_s,
        },
        doubts=tuple(text for text, is_so in doubts.items() if is_so),
    )


def _halted(modulator: PatternModulator, clock: Clock) -> float:
    """Halt it, and give the time until it is at rest.

    Raises:
        DeviceTimeout: it plays on.
    """
    began_s = clock.now_s()
    modulator.halt()
    while modulator.running:
        if clock.now_s() > began_s + PATIENCE_S:
            raise DeviceTimeout(
                modulator.identity.name,
                awaited="a modulator at rest",
                waited_s=PATIENCE_S,
                progress="one that plays, halted",
                remedy="switch it off by hand",
            )
        clock.sleep_s(_LOOK_S)
    return clock.now_s() - began_s
