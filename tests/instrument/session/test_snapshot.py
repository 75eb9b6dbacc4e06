"""Where a run stands after any events, and events as text."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydantic import ValidationError

from instrument.acquisition import AlignedBlock, Phase
from instrument.session import (
    BlockEvent,
    Event,
    FindingEvent,
    FinishedEvent,
    ImageEvent,
    PhaseEvent,
    RunState,
    Snapshot,
    TrackingEvent,
    UploadEvent,
    event_from_json,
)
from protocols import Floats

START = Snapshot(patterns_total=84, path="run.h5")
STATES: dict[Phase, RunState] = {
    "uploading": "preparing",
    "positioning": "preparing",
    "arming": "running",
    "running up": "running",
    "counting": "running",
    "coming to rest": "running",
    "making safe": "finishing",
    "storing": "finishing",
}
_COUNT = st.integers(0, 2**63 - 1)
_TEXT = st.text(max_size=20)
_NUMBERS = st.floats(allow_infinity=False)
PLAIN_EVENTS: st.SearchStrategy[Event] = st.one_of(
    st.builds(PhaseEvent, phase=st.sampled_from(list(STATES))),
    st.builds(UploadEvent, stored=_COUNT, total=_COUNT),
    st.builds(BlockEvent, first_pattern=_COUNT, patterns=_COUNT, block=st.none()),
    st.builds(FindingEvent, message=_TEXT),
    st.builds(
        FinishedEvent,
        outcome=st.sampled_from(["done", "failed", "aborted"]),
        path=st.none() | _TEXT,
        verdict=st.sampled_from([None, "good", "flagged", "failed"]),
        error=st.none() | _TEXT,
        notes=st.lists(_TEXT, max_size=3).map(tuple),
    ),
)


@settings(deadline=None)
@given(event=PLAIN_EVENTS)
def test_an_event_of_any_content_comes_back_from_json(event: Event) -> None:
    assert event_from_json(event.model_dump_json()) == event
    assert event_from_json(event.model_dump_json().encode()) == event


@settings(deadline=None)
@given(
    way=st.integers(1, 5).flatmap(lambda n: arrays(np.float64, (n, 2), elements=_NUMBERS)),
    counts=st.tuples(_COUNT, _COUNT, _COUNT, _COUNT),
    final=st.booleans(),
)
def test_tracking_comes_back_from_json_to_the_bit(
    way: Floats, counts: tuple[int, int, int, int], *, final: bool
) -> None:
    frame, dropped, images, skipped = counts
    event = TrackingEvent(
        frame=frame, displacement_px=way, frames_dropped=dropped, images=images, images_skipped=skipped, final=final
    )
    again = event_from_json(event.model_dump_json())
    assert isinstance(again, TrackingEvent)
    np.testing.assert_array_equal(again.displacement_px, way)
    assert again.model_dump(exclude={"displacement_px"}) == event.model_dump(exclude={"displacement_px"})


@settings(deadline=None)
@given(image=arrays(np.float64, st.tuples(st.integers(1, 4), st.integers(1, 4)), elements=_NUMBERS))
def test_an_image_is_a_copy_that_nobody_can_write_to(image: Floats) -> None:
    before = image.copy()
    event = ImageEvent(frame=3, image=image)
    image[:] = 7.0
    np.testing.assert_array_equal(event.image, before)
    again = event_from_json(event.model_dump_json())
    assert isinstance(again, ImageEvent)
    assert not event.image.flags.writeable
    assert not again.image.flags.writeable
    np.testing.assert_array_equal(again.image, before)


def test_every_array_of_a_block_is_copied_and_locked() -> None:
    buffers: dict[str, Any] = {
        "values": np.ones(3),
        "valid": np.ones(3, np.bool_),
        "edge_time_s": np.ones(3),
        "gaps": np.ones(1, np.int64),
        "doubles": np.ones(1, np.int64),
        "irregular": np.ones(1, np.int64),
    }
    event = BlockEvent.of(AlignedBlock(first_pattern=4, beyond=2, **buffers))
    assert (event.first_pattern, event.patterns) == (4, 3)
    assert event.block is not None
    assert event.block.beyond == 2
    for name, buffer in buffers.items():
        buffer[:] = 0
        kept = getattr(event.block, name)
        assert kept.all(), name
        assert not kept.flags.writeable, name


@pytest.mark.parametrize(
    "text",
    [
        '{"kind": "upload", "stored": -1, "total": 3}',
        '{"kind": "block", "first_pattern": 0, "patterns": 6, "block": 1}',
        '{"kind": "finding", "message": "x", "colour": 1}',
        '{"kind": "finished", "outcome": "well"}',
        '{"message": "no kind"}',
        "[]",
    ],
)
def test_what_is_nearly_an_event_is_refused(text: str) -> None:
    with pytest.raises(ValidationError):
        event_from_json(text)


@pytest.mark.parametrize("phase", STATES)
def test_each_phase_belongs_to_one_state(phase: Phase) -> None:
    now = START.after(PhaseEvent(phase=phase))
    assert (now.phase, now.state) == (phase, STATES[phase])
    assert now == START.model_copy(update={"phase": phase, "state": STATES[phase]})


@settings(deadline=None)
@given(events=st.lists(PLAIN_EVENTS, max_size=12))
def test_a_snapshot_is_made_of_the_last_event_of_each_kind_and_of_all_findings(events: list[Event]) -> None:
    now = START
    for event in events:
        now = now.after(event)

    def last(kind: type[Any]) -> Any:
        return next((event for event in reversed(events) if isinstance(event, kind)), None)

    upload, block, end, phase = (last(kind) for kind in (UploadEvent, BlockEvent, FinishedEvent, PhaseEvent))
    expected: dict[str, Any] = {"findings": tuple(e.message for e in events if isinstance(e, FindingEvent))}
    if upload is not None:
        expected |= {"upload_done": upload.stored, "upload_total": upload.total}
    if block is not None:
        expected |= {"patterns_done": block.first_pattern + block.patterns}
    if end is not None:
        expected |= {"finished": end, "error": end.error}
    if phase is not None:
        expected |= {"phase": phase.phase}
    last_word = next((event for event in reversed(events) if isinstance(event, PhaseEvent | FinishedEvent)), None)
    if last_word is not None:
        expected |= {"state": STATES[last_word.phase] if isinstance(last_word, PhaseEvent) else last_word.outcome}
    assert now == START.model_copy(update=expected)
    assert Snapshot.model_validate_json(now.model_dump_json()) == now


def test_of_endless_findings_the_first_thousand_are_kept() -> None:
    now = START.model_copy(update={"findings": tuple(str(k) for k in range(999))})
    for k in range(999, 1002):
        now = now.after(FindingEvent(message=str(k)))
    assert now.findings == tuple(str(k) for k in range(1000))


def test_what_the_live_analysis_tells_changes_nothing() -> None:
    assert START.after(TrackingEvent(frame=9, displacement_px=np.ones((1, 2)), final=True)) is START
    assert START.after(ImageEvent(frame=9, image=np.eye(2), final=True)) is START
