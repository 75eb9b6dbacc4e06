"""Recordings as NeXus HDF5 files: written as the counts come, readable with h5py alone."""

from instrument.storage.analysed import StoredAnalysis, stored_analysis
from instrument.storage.edit import put_back, refuse_unchangeable
from instrument.storage.failure import StorageFailed
from instrument.storage.hdf5_failure import hdf5_has_failed
from instrument.storage.in_use import refuse_while_written
from instrument.storage.info import AnalysisInfo, RecordingInfo, RecordingState, recording_info
from instrument.storage.json_text import json_text
from instrument.storage.keeper import Keeper
from instrument.storage.made_in_time import made_in_time
from instrument.storage.part import remains_of
from instrument.storage.place import needed_on_disk, refuse_existing, refuse_full_disk
from instrument.storage.provenance import program
from instrument.storage.reader import RawCounts, open_recording, raw_counts
from instrument.storage.recover import Recovered, recover
from instrument.storage.rescue import Rescue
from instrument.storage.results import write_analysis
from instrument.storage.writer import RecordingWriter

__all__ = [
    "AnalysisInfo",
    "Keeper",
    "RawCounts",
    "RecordingInfo",
    "RecordingState",
    "RecordingWriter",
    "Recovered",
    "Rescue",
    "StorageFailed",
    "StoredAnalysis",
    "hdf5_has_failed",
    "json_text",
    "made_in_time",
    "needed_on_disk",
    "open_recording",
    "program",
    "put_back",
    "raw_counts",
    "recording_info",
    "recover",
    "refuse_existing",
    "refuse_full_disk",
    "refuse_unchangeable",
    "refuse_while_written",
    "remains_of",
    "stored_analysis",
    "write_analysis",
]
