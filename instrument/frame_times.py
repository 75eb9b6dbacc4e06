"""When a frame is, said once for everybody."""

import numpy as np

from protocols import Floats


def frame_middle_s(frames: int, frame_time_s: float) -> Floats:
    """``(frames,)``: middle of each frame in seconds after the first sync edge, by the nominal frame time."""
    return (np.arange(frames, dtype=np.float64) + 0.5) * frame_time_s
