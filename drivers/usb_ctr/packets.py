"""How the samples of a run come over USB: one in a packet, or full packets.

One sample in a packet loses nothing, even of a run that is cut short, and shows every surplus edge. It is one transfer a
pattern, of which ``pipe.IN_FLIGHT`` are queued: 20,000 a second take some 10 us of processor each (benchmarks/counter_reads.py).
What does not keep up waits on the board, which holds 8,192 samples, and then overruns: an error, never a loss in silence.

Full packets of 256 words are 78 transfers a second at 20 kHz, and a tenth of the processor's time. The board sends the last,
partial one only when a scan completes (wjasper/Linux_Drivers #35), so the scan has the samples of the run and no more: edges
beyond it make no sample, and a run that lacks an edge keeps its last packet back. So full packets are for benches on which a
counter counts the sync itself.
"""

from dataclasses import dataclass

from drivers.usb_ctr.codec import BLOCK_WORDS, Scan
from drivers.usb_ctr.settings import UsbCtrSettings
from protocols import CounterRun

SINGLE_PACKETS_HZ = 4000.0
"""Rate of sync edges up to which each sample comes alone in any case: it costs little then."""


@dataclass(frozen=True)
class Packets:
    """What SCAN_START is told."""

    words: int
    """16-bit words of a packet."""

    samples: int
    """Samples of the scan; 0: until it is stopped, so that every surplus edge gives one too."""

    @property
    def complete(self) -> bool:
        """Whether the scan ends with the run."""
        return self.samples > 0


def packets_of(run: CounterRun, scan: Scan, settings: UsbCtrSettings) -> Packets:
    """Choose full packets where the run is fast and a counter counts its edges, single samples elsewhere."""
    if settings.sync_counter is not None and run.period_s * SINGLE_PACKETS_HZ < 1:
        return Packets(BLOCK_WORDS, settings.first_samples + (run.n_expected or run.n_bins))
    return Packets(scan.words_per_scan, 0)
