"""Recordings as NeXus HDF5 files: written as the counts come, readable with h5py alone."""

from instrument.storage.analysis import write_analysis
from instrument.storage.json_text import json_text
from instrument.storage.reader import open_recording
from instrument.storage.writer import DeviceName, RecordingWriter, refuse_existing

__all__ = ["DeviceName", "RecordingWriter", "json_text", "open_recording", "refuse_existing", "write_analysis"]
