"""Where things are in a recording, below ``/entry``. The reference is docs/reference/recording.md."""

from typing import Final

import numpy as np

from protocols import Floats, InputError, Mask

DEFINITION: Final = "kinopix-recording"
"""Value of ``definition``: how a recording is told from other HDF5 files."""

VERSION: Final = "1.3"
"""Version of this layout, in ``definition/@version``. The number before the point changes when old readers would go wrong."""

PLAN: Final = "plan"
BENCH: Final = "bench"
VALUES: Final = "data/values"
EDGE_TIME_S: Final = "data/edge_time_s"
PICTURE_TIME_S: Final = "instrument/modulator/picture_time_s"
DEAD_TIME_S: Final = "instrument/counter/dead_time_s"
DARK_RATE_HZ: Final = "instrument/counter/dark_rate_hz"
PHOTON_COUNTS: Final = "instrument/counter/photon_counts"
RAW_COUNTS: Final = "instrument/counter/raw_counts"
RAW_EDGE_TIME_S: Final = "instrument/counter/raw_edge_time_s"
STAGE_POSITIONS: Final = "instrument/stage/positions"
PROGRAM_NAME: Final = "program_name"
START_TIME: Final = "start_time"
END_TIME: Final = "end_time"
FILE_BYTES: Final = "file_bytes"
USER_NAME: Final = "user/name"
SAMPLE_NAME: Final = "sample/name"
NOTES: Final = "notes/data"
NOTES_TYPE: Final = "notes/type"
INTERRUPTED: Final = "interrupted"
FRAME_VALID: Final = "timing/frame_valid"
TIMING_REPORT: Final = "timing/report"
CHECKSUM_VALUES: Final = "checksum/values"
CHECKSUM_EDGES: Final = "checksum/edges"
TRUTH_DISPLACEMENT_PX: Final = "truth/displacement_px"
TRUTH_IMAGE: Final = "truth/image"
TRUTH_BACKGROUND: Final = "truth/background"


def unusable(path: object, saw: str, remedy: str) -> InputError:
    """A file that is no readable recording."""
    return InputError(saw=f"{saw}: {path}", expected="a recording by `kinopix run`", remedy=remedy)


def measured_frames(values: Floats) -> Mask:
    """``(frames,)``: the frames in which every pattern has a value."""
    return np.asarray(np.isfinite(values).all(axis=1))
