"""ViALUX ALP-4 boards, through the vendor's C library, driving a DLP7000 micromirror array."""

from drivers.alp.driver import Dlp7000
from drivers.alp.settings import Dlp7000Settings

__all__ = ["Dlp7000", "Dlp7000Settings"]
