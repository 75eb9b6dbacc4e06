"""The live view of every scheme: with path and image, with a path alone, with an image alone."""

import io

import numpy as np
import pytest
from rich.console import Console
from rich.progress import Progress

from instrument.live import LiveLine, LiveUpdate
from instrument.live.analysis import publish_update
from instrument.numerics import displacement_mse, psnr
from instrument.recording import Recording
from instrument.views.live import LiveView
from protocols import Floats, Truth
from tests.instrument.live.streams import blocks, letter
from tests.support.plans import plan_of
from tests.support.simulation import simulate

FRAMES = 600


def _simulated(scheme: str, *, moves: bool) -> tuple[Recording, Truth]:
    """21.6 and 32.4 px in the run, on a curve; or rest."""
    plan = plan_of(scheme, frames=FRAMES, image_size=64)

    def path(time_s: Floats) -> Floats:
        part = time_s / plan.run_time_s
        return moves * np.stack([21.6 * part, 32.4 * part + 16.2 * part * (part - 1)], axis=1)

    recording = simulate(plan, letter(), path, sigma=0.05, seed=1)
    assert recording.truth is not None
    return recording, recording.truth


def _played(recording: Recording) -> tuple[LiveLine, list[LiveUpdate]]:
    """Blocks of a tenth of the run, an image due with each."""
    line = LiveLine(recording.plan, image_interval_s=FRAMES // 10 * recording.plan.frame_time_s)
    updates: list[LiveUpdate] = []
    for piece in blocks(recording.values, [recording.plan.patterns // 10]):
        line.take([piece])
        updates += [line.improve() for _ in range(line.images_due)]
    return line, [*updates, line.finish()]


@pytest.mark.parametrize("scheme", ["fourier-hadamard", "moment-hadamard"])
def test_path_and_image_come_while_the_run_goes_on(scheme: str) -> None:
    recording, truth = _simulated(scheme, moves=True)
    line, updates = _played(recording)
    path_px = np.concatenate([update.displacement_px for update in updates])

    assert line.complete
    assert line.counters.images == 10
    assert displacement_mse(path_px, truth.displacement_px) < 0.4
    last = updates[-1].image
    assert last is not None
    assert psnr(last, truth.image) > 24


def test_a_scheme_that_only_tracks_gives_a_path_and_asks_for_no_image() -> None:
    recording, truth = _simulated("fourier-3step", moves=True)
    line, updates = _played(recording)

    assert line.complete
    assert line.images_due == 0
    assert (line.counters.frames, line.counters.images, line.counters.images_skipped) == (FRAMES, 0, 0)
    assert [update.final for update in updates] == [True]
    assert updates[0].image is None
    assert displacement_mse(updates[0].displacement_px, truth.displacement_px) < 0.05


def test_a_scheme_that_sees_no_position_gives_an_image_and_no_path() -> None:
    recording, truth = _simulated("hadamard", moves=False)
    line, updates = _played(recording)

    assert line.counters.images == 10
    assert all(update.displacement_px.shape == (0, 2) for update in updates)
    last = updates[-1].image
    assert last is not None
    assert psnr(last, truth.image) > 28


def test_the_view_shows_no_place_where_none_is_seen_and_no_image_where_there_is_none() -> None:
    for scheme, moves, place in (("hadamard", False, False), ("fourier-3step", True, True)):
        _, updates = _played(_simulated(scheme, moves=moves)[0])
        out = io.StringIO()
        with LiveView(Progress(), console=Console(file=out, width=100)) as view:
            publish_update(updates[-1], view)
        assert f"frame {FRAMES}: " in out.getvalue()
        assert ("px" in out.getvalue()) == place
