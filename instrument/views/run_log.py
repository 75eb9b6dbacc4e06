"""A run in the log: a listener that writes down what it is told, one line an event."""

import logging

from instrument.session import BlockEvent, Event, FinishedEvent, ImageEvent, TrackingEvent, UploadEvent
from instrument.views.terminal import LOG


def log_events(event: Event) -> None:
    """Log an event: what comes many times a second at the level of debugging, findings as warnings, ends by their outcome."""
    level = logging.INFO
    match event:
        case BlockEvent():
            level, text = logging.DEBUG, f"patterns {event.first_pattern} to {event.first_pattern + event.patterns - 1}"
        case UploadEvent():
            level, text = logging.DEBUG, f"{event.stored} of {event.total} patterns stored"
        case TrackingEvent() | ImageEvent():
            level, text = logging.DEBUG, f"{event.kind} at frame {event.frame}"
        case FinishedEvent():
            level = logging.INFO if event.outcome == "done" else logging.ERROR
            text = "; ".join([f"the run is {event.outcome}", *([event.error] if event.error else []), *event.notes])
        case _:
            level = logging.WARNING if event.kind == "finding" else logging.INFO
            text = event.message if event.kind == "finding" else event.phase
    LOG.log(level, "run: %s", text)
