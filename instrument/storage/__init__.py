"""Recordings as NeXus HDF5 files: written as the counts come, readable with h5py alone."""

from instrument.storage.json_text import json_text
from instrument.storage.reader import open_recording
from instrument.storage.results import write_analysis
from instrument.storage.writer import RecordingWriter, refuse_existing, refuse_full_disk

__all__ = [
    "RecordingWriter",
    "json_text",
    "open_recording",
    "refuse_existing",
    "refuse_full_disk",
    "write_analysis",
]
