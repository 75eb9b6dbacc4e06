"""Which frames to trust: what the timing audit finds, which it knows at the end of a run."""

from collections.abc import Callable, Iterator

from bluesky.protocols import Collectable, StreamAsset, WritesStreamAssets
from event_model.documents import DataKey

from instrument.bluesky_devices.documents import Rows, valid_key
from instrument.bluesky_devices.named import Named
from instrument.session import Run


class KinopixAudit(Named, Collectable, WritesStreamAssets):
    """The part of a detector that tells whether each frame is valid, in a stream of its own: only at the end of a run."""

    def __init__(self, detector: Named, run: Callable[[], Run | None]) -> None:
        """Take the detector.

        Args:
            detector: that it is part of.
            run: gives the run that goes on, or the last one.
        """
        super().__init__(f"{detector.name}-audit", detector)
        self._key = f"{detector.name}-frame_valid"
        self._run = run
        self._told: tuple[Run, Rows] | None = None

    def describe_collect(self) -> dict[str, DataKey]:
        """Say what ``collect`` tells of."""
        return valid_key(self._key)

    def get_index(self) -> int:
        """Give the number of frames of the run, when its file is closed; 0 before."""
        run = self._run()
        if run is None or not run.done or run.recording is None:
            return 0
        return len(run.recording)

    def collect_asset_docs(self, index: int | None = None) -> Iterator[StreamAsset]:
        """Tell of the frames of a run that is over, once; nothing before.

        Args:
            index: frames that all detectors of a stream have; None for all.
        """
        run, frames = self._run(), self.get_index()
        if run is None or not frames or run.recording is None or run.recording.path is None:
            return
        if self._told is None or self._told[0] is not run:
            self._told = run, Rows.of_valid(self._key, run.recording.path)
        yield from self._told[1].up_to(frames if index is None else min(index, frames))
