"""Where the maker's FPGA image is, which every USB-CTR needs after each power-up. It is the maker's and not part of Kinopix."""

from pathlib import Path

MAKER_FOLDER = Path("/usr/share/uldaq/fpga")
"""Where the maker's library for Linux (mccdaq/uldaq) puts its images."""


def maker_image(folder: Path = MAKER_FOLDER) -> Path | None:
    """Give the image of this family that the maker's library has installed, or None."""
    return next((path for path in sorted(folder.glob("*.rbf")) if "ctr" in path.name.lower()), None)
