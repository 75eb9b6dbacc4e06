"""Events are values: they can be stored and sent, and nobody can change them."""

import json

import numpy as np
import pytest
from pydantic import ValidationError

from instrument.session import (
    BlockEvent,
    Event,
    FindingEvent,
    FinishedEvent,
    ImageEvent,
    PhaseEvent,
    Snapshot,
    TrackingEvent,
    UploadEvent,
    event_from_json,
)
from tests.instrument.live.streams import block

EVENTS: list[Event] = [
    PhaseEvent(phase="counting"),
    UploadEvent(stored=3, total=84),
    FindingEvent(message="pattern 7: its sync edge is missing"),
    FinishedEvent(outcome="aborted", path="run.h5", verdict="failed", error="the test", notes=("kept",)),
    BlockEvent(first_pattern=6, patterns=12),
]


@pytest.mark.parametrize("event", EVENTS, ids=lambda event: event.kind)
def test_json_gives_the_same_event_again(event: Event) -> None:
    assert event_from_json(event.model_dump_json()) == event


def test_arrays_travel_as_lists_with_null_for_nan() -> None:
    event = TrackingEvent(frame=2, displacement_px=np.array([[0.5, np.nan], [1.0, -2.0]]), images=1)
    text = event.model_dump_json()
    assert json.loads(text)["displacement_px"] == [[0.5, None], [1.0, -2.0]]
    again = event_from_json(text)
    assert isinstance(again, TrackingEvent)
    np.testing.assert_array_equal(again.displacement_px, event.displacement_px)
    image = event_from_json(ImageEvent(frame=9, image=np.eye(2), final=True).model_dump_json())
    assert isinstance(image, ImageEvent)
    np.testing.assert_array_equal(image.image, np.eye(2))


def test_a_block_is_a_read_only_copy_and_its_arrays_stay_in_the_process() -> None:
    buffer = np.arange(6.0)
    event = BlockEvent.of(block(12, buffer))
    buffer[:] = 7
    assert event.block is not None
    assert event.block.values.tolist() == [0, 1, 2, 3, 4, 5]
    with pytest.raises(ValueError, match="read-only"):
        event.block.values[0] = 1
    assert json.loads(event.model_dump_json()) == {"kind": "block", "first_pattern": 12, "patterns": 6}


def test_what_is_no_event_is_refused() -> None:
    with pytest.raises(ValidationError):
        event_from_json('{"kind": "explosion"}')
    with pytest.raises(ValidationError):
        event_from_json('{"kind": "phase", "phase": "lunch"}')


def test_a_snapshot_follows_the_events() -> None:
    now = Snapshot(patterns_total=84, path="run.h5")
    for event in EVENTS:
        now = now.after(event)
    assert (now.state, now.phase, now.patterns_done) == ("aborted", "counting", 18)
    assert (now.upload_done, now.upload_total) == (3, 84)
    assert (now.findings, now.error) == (("pattern 7: its sync edge is missing",), "the test")


def test_a_tracking_event_that_says_no_more_has_made_and_lost_nothing() -> None:
    event = TrackingEvent(frame=2, displacement_px=np.zeros((1, 2)))
    assert (event.images, event.images_skipped, event.frames_dropped, event.final) == (0, 0, 0, False)
