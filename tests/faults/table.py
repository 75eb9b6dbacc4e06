"""All rows, by device."""

from collections.abc import Mapping, Sequence

from tests.faults import alp, dlpc900, grbl, ni, ni_analog, scene, serial_counter, simulated, usb_ctr, zaber, zolix
from tests.faults.row import Row

TABLE: Mapping[str, Sequence[Row]] = {
    "Sync line": scene.ROWS,
    "Simulated counter": simulated.ROWS,
    "DLP7000 on ALP-4": alp.ROWS,
    "DLPC900": dlpc900.ROWS,
    "H10682 on NI-DAQmx": ni.ROWS,
    "H10682 on USB-CTR": usb_ctr.ROWS,
    "NI analogue inputs": ni_analog.ROWS,
    "Serial counter": serial_counter.ROWS,
    "KA400Z on MC600": zolix.mc600_rows(),
    "KA400Z on SC300": zolix.sc300_rows(),
    "Zaber": zaber.ROWS,
    "GRBL": grbl.ROWS,
}
"""Device as the page's headings have it -> its faults."""
