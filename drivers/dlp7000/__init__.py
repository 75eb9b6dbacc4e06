"""DLP7000 micromirror array on a ViALUX V-7000 board, driven through the vendor's ALP-4 C library."""

from drivers.dlp7000.driver import Dlp7000
from drivers.dlp7000.settings import Dlp7000Settings

__all__ = ["Dlp7000", "Dlp7000Settings"]
