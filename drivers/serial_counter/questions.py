"""What a bench with this counter has to answer."""

from typing import Final

from drivers.serial_counter.settings import SerialCounterSettings
from protocols import BenchQuestion

QUESTIONS: Final[tuple[BenchQuestion[SerialCounterSettings], ...]] = (
    BenchQuestion("Which board and firmware, which clock (`id`)?", measured="identity"),
    BenchQuestion(
        "Highest sync rate over USB for a run of 10,000 bins, five times in a row?",
        measured="pulses",
        by_hand="five runs of 1,000 at max_sync_rate_hz are above; raise it in bench.toml until they fail",
    ),
    BenchQuestion(
        "Shortest pulse that is counted; pulses of which distance merge?",
        measured="dead time",
        by_hand="a pulse generator of known width and distance",
    ),
    BenchQuestion("Do bins without pulses arrive?", measured="pulses", by_hand="repeat with the shutter closed"),
    BenchQuestion("Does the sum of ticks agree with the modulator's own time to 100 ppm?", measured="edges"),
    BenchQuestion("Is the edge that comes first after `armed` the one that opens bin 0?", measured="order"),
)
"""In the order of the how-to."""
