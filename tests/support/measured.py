"""Where measured data of others are looked for. Tests that need them skip where they are not."""

import os
from pathlib import Path

MEASURED = Path(os.environ.get("KINOPIX_DATA", Path(__file__).parents[3] / "shared" / "data"))
"""Folder with one subfolder for each data set: ``KINOPIX_DATA``, or ``shared/data`` beside the repository."""
