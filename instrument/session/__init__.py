"""The bench as one thing, and a run as a handle: started, watched, waited for, aborted, from any thread."""

from instrument.acquisition import Devices, Phase, check_recording
from instrument.session.channel import Channel, Follower, Listener, Publish, Subscription
from instrument.session.counting import Counting, count
from instrument.session.errors import RunAborted, RunNotOver, RunStopped
from instrument.session.events import (
    BlockEvent,
    Event,
    FindingEvent,
    FinishedEvent,
    ImageEvent,
    PhaseEvent,
    TrackingEvent,
    UploadEvent,
    event_from_json,
)
from instrument.session.feed import Feed
from instrument.session.holding import hold
from instrument.session.instrument import Instrument
from instrument.session.naming import next_name
from instrument.session.opening import open_devices, surroundings
from instrument.session.probing import Probed, probe_bench
from instrument.session.run import Run, Written
from instrument.session.safety import make_safe
from instrument.session.simulate import simulate
from instrument.session.snapshot import ListenerFailure, RunState, Snapshot

__all__ = [
    "BlockEvent",
    "Channel",
    "Counting",
    "Devices",
    "Event",
    "Feed",
    "FindingEvent",
    "FinishedEvent",
    "Follower",
    "ImageEvent",
    "Instrument",
    "Listener",
    "ListenerFailure",
    "Phase",
    "PhaseEvent",
    "Probed",
    "Publish",
    "Run",
    "RunAborted",
    "RunNotOver",
    "RunState",
    "RunStopped",
    "Snapshot",
    "Subscription",
    "TrackingEvent",
    "UploadEvent",
    "Written",
    "check_recording",
    "count",
    "event_from_json",
    "hold",
    "make_safe",
    "next_name",
    "open_devices",
    "probe_bench",
    "simulate",
    "surroundings",
]
