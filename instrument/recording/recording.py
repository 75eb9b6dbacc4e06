"""A recording as analysis sees it, without file or device: values, their times, and which frames are valid."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from instrument.config import NOTHING_KNOWN, Calibration, LightTable
from instrument.frame_times import frame_middle_s
from instrument.plan import ABOUT_THE_RUN, Plan
from instrument.recording.stage_log import StageLog
from instrument.recording.timing import TimingReport
from instrument.shown import card, curves, line
from instrument.tables import data_set
from protocols import Floats, InputError, Mask, Truth
from protocols.field_docs import with_fields


@with_fields
@dataclass(frozen=True, eq=False)
class Recording:
    """One run. A run that broke is a shorter recording with a mask."""

    plan: Plan
    """What was asked for. ``plan.frames`` may be more than ``len(values)``."""

    values: Floats
    """``(frames, patterns_per_frame)``: single-pixel values in play order; NaN where no value was measured."""

    frame_valid: Mask
    """``(frames,)``: whether every pattern of the frame was counted in its own bin."""

    picture_time_s: float
    """Time from one pattern to the next, as read back from the modulator."""

    edge_time_s: Floats | None = None
    """As ``values``: hardware time of each pattern's opening edge from the first one on; NaN where missing."""

    photon_counts: bool = False
    """Whether values are photon counts (Poisson) or of a detector that does not count."""

    dead_time_s: float = 0.0
    """Dead time of detector and counter; ``light`` says of which kind."""

    dark_rate_hz: float = 0.0
    """Dark counts a second."""

    light: LightTable = NOTHING_KNOWN
    """What bench.toml says of how the bench differs from an ideal one."""

    calibration: Calibration | None = None
    """What was measured of the bench before the run; None where nothing was."""

    stage: StageLog | None = None
    """Where the stage was, as its controller told; None in recordings of older programs."""

    background: Floats | None = None
    """As ``values``: what stands still beside the object, measured without it by the same patterns; still in ``values``."""

    truth: Truth | None = None
    """Simulated runs only: what really was there."""

    timing: TimingReport | None = None
    """The timing audit; None where a run was cut off before it."""

    path: Path | None = None
    """The file it came from."""

    def __post_init__(self) -> None:
        """Refuse arrays that do not go with the plan and with each other.

        Raises:
            InputError: names the array, its shape, and the one expected.
        """
        frames, patterns = len(self.values), self.plan.patterns_per_frame
        expected = {"values": (frames, patterns), "frame_valid": (frames,)}
        expected |= dict.fromkeys(("edge_time_s", "background"), (frames, patterns))
        for name, shape in expected.items():
            array = getattr(self, name)
            if array is not None and np.shape(array) != shape:
                raise InputError(
                    saw=f"{name} of shape {np.shape(array)}",
                    expected=f"{shape}: {frames} frames of the scheme {self.plan.scheme.name}",
                    remedy="give the arrays of one run, with its plan",
                )
        if frames > self.plan.frames:
            raise InputError(
                saw=f"{frames} frames of values by a plan of {self.plan.frames}",
                expected="no more frames than were planned",
                remedy="give the plan that the values were recorded by",
            )
        if not 0 < self.picture_time_s < np.inf:
            raise InputError(
                saw=f"a picture time of {self.picture_time_s:g} s",
                expected="more than 0 s",
                remedy="give the time from one pattern to the next, in seconds",
            )

    def __len__(self) -> int:
        """Give the number of frames recorded."""
        return len(self.values)

    def __repr__(self) -> str:
        """Say in one line what it is."""
        return line("Recording", *self._facts().values())

    def _repr_html_(self) -> str:
        """Show in a notebook what it is, and its light over time."""
        time_s = frame_middle_s(len(self), self.frame_time_s)
        light = np.nansum(self.values, axis=1, keepdims=True) / self.plan.patterns_per_frame
        drawn = curves(time_s, light, None, "mean value of each frame", "mean value of a frame") if len(self) else ""
        return card("Recording", self._facts(), drawn)

    def _facts(self) -> dict[str, str]:
        plan, masked = self.plan, int(np.count_nonzero(~self.frame_valid))
        facts = {
            "frames": f"{len(self)} of {plan.frames} frames" + (f", {masked} masked" if masked else ""),
            "scheme": f"{plan.scheme.name}, {plan.image_size} x {plan.image_size} px",
            "rate": f"{1 / self.picture_time_s:g} patterns/s",
            "motion": "at rest" if plan.motion is None else f"{plan.motion.velocity_mm_s:g} mm/s",
            "timing": "" if self.timing is None else f"timing {self.timing.verdict}",
            "file": "" if self.path is None else self.path.name,
        }
        return {name: text for name, text in facts.items() if text}

    def to_xarray(self) -> Any:
        """Give the values with their times as an ``xarray.Dataset`` of the dimensions ``frame`` and ``pattern``.

        Raises:
            InputError: xarray is not installed.
        """
        both = ("frame", "pattern")
        variables: dict[str, tuple[tuple[str, ...], Floats | Mask]] = {"values": (both, self.values)}
        variables["frame_valid"] = (("frame",), self.frame_valid)
        if self.edge_time_s is not None:
            variables["edge_time_s"] = (both, self.edge_time_s)
        coordinates = {
            "time_s": (("frame",), frame_middle_s(len(self), self.frame_time_s)),
            "pattern_time_s": (both, self.pattern_time_s),
        }
        of_values = "counts" if self.photon_counts else "lit pixels"
        units = {"time_s": "s", "pattern_time_s": "s", "edge_time_s": "s", "values": of_values}
        attributes: dict[str, str | float] = {
            "plan": self.plan.model_dump_json(),
            "picture_time_s": self.picture_time_s,
        }
        return data_set(variables, coordinates, attributes, units)

    @property
    def px_per_mm(self) -> float | None:
        """Image pixels a millimetre of the stage, by the calibration; None where the bench was not calibrated."""
        known = None if self.calibration is None else self.calibration.displacement
        return None if known is None else known.px_per_mm

    @property
    def axis_angle_deg(self) -> float | None:
        """Direction of positive travel in the image, from x (right) towards y (down), by the calibration; None likewise."""
        known = None if self.calibration is None else self.calibration.displacement
        return None if known is None else known.axis_angle_deg

    @property
    def frame_time_s(self) -> float:
        """Time from one frame to the next."""
        patterns: int = self.values.shape[1]
        return self.picture_time_s * patterns

    @property
    def pattern_time_s(self) -> Floats:
        """``(frames, patterns_per_frame)``: middle of each pattern, from the first edge on, by the nominal picture time."""
        index = np.arange(self.values.size, dtype=np.float64).reshape(self.values.shape)
        return (index + 0.5) * self.picture_time_s

    def first(self, frames: int) -> Self:
        """Give the same run, ended after so many frames."""
        return self._cut(slice(0, frames))

    def part(self, first: int, end: int) -> Self:
        """Give some frames of a run as a run of its own, whose first frame is the first of them.

        Where its Hadamard patterns are used, ``first`` must be a frame that shows the first of them: a multiple of the pattern
        pixels of the field, after which they repeat. The stage's log is left out.

        Args:
            first: first frame.
            end: frame after the last one.

        Raises:
            InputError: there are no such frames.
        """
        if not 0 <= first < end <= len(self):
            raise InputError(
                saw=f"frames {first} to {end}",
                expected=f"frames from 0 on, before {len(self)}",
                remedy="ask for frames that the recording has",
            )
        timing = None if self.timing is None else self.timing.part(first, end)
        return replace(self._cut(slice(first, end)), timing=timing, stage=self.stage if first == 0 else None)

    def _cut(self, rows: slice) -> Self:
        truth = self.truth
        if truth is not None:
            truth = replace(truth, displacement_px=truth.displacement_px[rows])
        return replace(
            self,
            values=self.values[rows],
            frame_valid=self.frame_valid[rows],
            edge_time_s=None if self.edge_time_s is None else self.edge_time_s[rows],
            background=None if self.background is None else self.background[rows],
            truth=truth,
        )

    def minus(self, background: "Recording") -> Self:
        """Give the same run with a stationary background to be subtracted, recorded with the same patterns and no object.

        The values stay as they were counted: dead time bends both, so the light of each is found first, then subtracted.

        Raises:
            InputError: the background was recorded with other patterns or another detector, or is too short.
        """
        ours, theirs = self.plan, background.plan
        others = {"motion": None, "frames": 1, **dict.fromkeys(ABOUT_THE_RUN)}
        same = ours.model_copy(update=others) == theirs.model_copy(update=others)
        if not same or len(background) < len(self):
            raise InputError(
                saw=f"a background of {len(background)} frames by the plan {theirs.model_dump_json()}",
                expected=f"at least {len(self)} frames by the plan {ours.model_dump_json()}",
                remedy="record the background with the same plan.toml, without [motion] and without the object",
            )
        if self.photon_counts != background.photon_counts or self.background is not None:
            raise InputError(
                saw="a second background"
                if self.background is not None
                else "one recording of photon counts and one of none",
                expected="one background by the same detector",
                remedy="record it with the same bench.toml and subtract it once",
            )
        return replace(
            self,
            background=background.values[: len(self)],
            frame_valid=self.frame_valid & background.frame_valid[: len(self)],
        )
