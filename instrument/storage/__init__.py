"""Recordings as NeXus HDF5 files: written as the counts come, readable with h5py alone."""

from instrument.storage.info import AnalysisInfo, RecordingInfo, RecordingState, recording_info
from instrument.storage.json_text import json_text
from instrument.storage.reader import open_recording
from instrument.storage.results import write_analysis
from instrument.storage.writer import RecordingWriter, refuse_existing, refuse_full_disk

__all__ = [
    "AnalysisInfo",
    "RecordingInfo",
    "RecordingState",
    "RecordingWriter",
    "json_text",
    "open_recording",
    "recording_info",
    "refuse_existing",
    "refuse_full_disk",
    "write_analysis",
]
