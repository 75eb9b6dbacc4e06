"""Leak, edge loss, and the delay of the light after its sync edge.

**Leak.** White and black pictures follow one another in an order in which no stretch looks like another. The light of
picture k is

    y_k = b + sum over j of h_j w_(k-j),

w being 1 for white and 0 for black: h_0 is what a picture gives in its own time, h_1 what is left of it in the next one,
h_-1 what came too early. The least-squares h gives the leak h_1 / sum h, and sum j h_j / sum h picture times is the mean
delay of the light.

**Edge loss.** Of a chessboard and its complement each mirror is lit once. Cells of n mirrors a side give a mirror 4 / n dark
neighbours in the mean (exactly 2 for each mirror where n = 2, whatever the object is), so that both together lack the share
4 e / n of the white picture's light.
"""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

import numpy as np

from instrument.calibration.pictures import PictureField, counts_of
from instrument.config import DeadTimeKind, Measured, MirrorsSection
from instrument.measurement import Detector
from instrument.recording import Recording
from instrument.session import Instrument
from protocols import Floats, InputError

LONGEST_LATE: Final = 3
"""Picture times by which light is looked for before and after its edge."""

_CODE: Final = "1101001000010111011000111110011"
"""A maximum-length sequence of 31: shifted by any number of places it agrees with itself in 15 of 31."""

_EACH: Final = 16
_SETTLE: Final = 4
_BOARDS: Final = ("white", "checker:1", "not checker:1", "checker:2", "not checker:2", "black")
_CERTAIN: Final = 5.0


@dataclass(frozen=True)
class MirrorsResult:
    """What was found."""

    section: MirrorsSection
    """For the calibration file."""

    loss_by_cell: tuple[Measured, Measured]
    """Edge loss by chessboards of cells of one pixel, and of two: the same, where loss goes with the length of the borders."""

    doubts: tuple[str, ...] = ()
    """What a person should know before trusting it."""


def calibrate_mirrors(
    bench: Instrument,
    field: PictureField,
    *,
    pattern_rate_hz: float = 20_000.0,
    seconds: float = 4.0,
    dead_time_s: float | None = None,
    dead_time_kind: DeadTimeKind = "non-paralyzable",
) -> MirrorsResult:
    """Measure the mirrors at the rate of the runs to come.

    Args:
        bench: open, with modulator and counter.
        field: of the pictures, and where the runs are kept.
        pattern_rate_hz: of the runs to come.
        seconds: how long, of each of the two runs.
        dead_time_s: of the detector, as calibrated; None takes what the counter states.
        dead_time_kind: of which kind.

    Raises:
        InputError: there is no light, or it is too dim to tell.
        KinopixError: as ``Instrument.run``.
    """
    code = ["white" if lit == "1" else "black" for lit in _CODE]
    switched = field.record(bench, "mirrors-switched", code, seconds=seconds, pattern_rate_hz=pattern_rate_hz)
    boards = field.record(
        bench, "mirrors-borders", _BOARDS, seconds=seconds, pattern_rate_hz=pattern_rate_hz, each=_EACH
    )
    tau_s = switched.dead_time_s if dead_time_s is None else dead_time_s
    detector = Detector(switched.picture_time_s, tau_s, 0.0, dead_time_kind)
    share, covariance = response(switched, detector)
    lags = np.arange(-LONGEST_LATE, LONGEST_LATE + 1)
    whole = int(lags[int(np.argmax(share))])
    around = {lag: _share(share, covariance, LONGEST_LATE + whole + lag) for lag in (-1, 1)}
    late = Measured(
        value=float(lags @ share) * switched.picture_time_s,
        sigma=float(lags @ covariance @ lags) ** 0.5 * switched.picture_time_s,
    )
    losses = _edge_losses(boards, detector, field.superpixel)
    best = min(losses, key=lambda loss: loss.sigma)
    section = MirrorsSection(
        date=datetime.now(UTC),
        picture_time_s=switched.picture_time_s,
        leak=around[1],
        early=around[-1],
        edge_loss=best,
        late_s=late,
        whole_pictures_late=whole,
    )
    return MirrorsResult(section, losses, tuple(_doubts(section, losses)))


def response(recording: Recording, detector: Detector) -> tuple[Floats, Floats]:
    """Fit h to a run of the code.

    Args:
        recording: of white and black pictures.
        detector: turns counts into light.

    Returns:
        ``(2 LONGEST_LATE + 1,)`` h over its sum, from early to late, and its covariance.

    Raises:
        InputError: white and black pictures are alike.
    """
    counts = counts_of(recording, 1, 0)
    light, variance = detector.light(counts.mean)
    sigma = np.sqrt(variance / counts.number)
    lit = np.array([lit == "1" for lit in _CODE], np.float64)
    design = np.column_stack(
        [*(np.roll(lit, lag) for lag in range(-LONGEST_LATE, LONGEST_LATE + 1)), np.ones(len(lit))]
    )
    weighted = design / sigma[:, None]
    covariance = np.linalg.inv(weighted.T @ weighted)
    found = covariance @ weighted.T @ (light / sigma)
    h, total = found[:-1], float(found[:-1].sum())
    if not total > _CERTAIN * float(covariance[:-1, :-1].sum()) ** 0.5:
        raise InputError(
            device="counter",
            saw=f"white and black pictures that differ by {total:.3g} counts",
            expected="more light in white ones",
            remedy="switch the lamp on, open the shutter, and look with kinopix count",
        )
    jacobian = (np.eye(len(h)) - np.outer(h, np.ones(len(h))) / total) / total
    return h / total, jacobian @ covariance[:-1, :-1] @ jacobian.T


def _share(share: Floats, covariance: Floats, index: int) -> Measured:
    """One h; 0 where it lies beyond what was looked for."""
    if not 0 <= index < len(share):
        return Measured(value=0.0, sigma=0.0)
    return Measured(value=float(share[index]), sigma=float(covariance[index, index]) ** 0.5)


def _edge_losses(recording: Recording, detector: Detector, superpixel: int) -> tuple[Measured, Measured]:
    """Edge loss by chessboards of one and of two pixels."""
    counts = counts_of(recording, _EACH, _SETTLE, LONGEST_LATE)
    light, variance = detector.light(counts.mean)
    white, black = light[0] - light[5], light[5]
    noise = variance / counts.number

    def by(cell: int) -> Measured:
        lit, dark = 2 * cell - 1, 2 * cell
        share = (light[lit] + light[dark] - 2 * black) / white
        # d share: 1 / white for each board, -share / white for white, (share - 2) / white for black
        sigma = np.sqrt(noise[lit] + noise[dark] + share**2 * noise[0] + (share - 2) ** 2 * noise[5]) / white
        sides = 4 / (cell * superpixel)
        return Measured(value=float((1 - share) / sides), sigma=float(sigma / sides))

    return by(1), by(2)


def _doubts(section: MirrorsSection, losses: tuple[Measured, Measured]) -> list[str]:
    doubts: list[str] = []
    if section.whole_pictures_late:
        doubts.append(
            f"patterns come {section.whole_pictures_late} pictures after their sync edges: look at the edge and the delay that "
            "the counter triggers on"
        )
    if section.early.value > _CERTAIN * section.early.sigma:
        doubts.append(
            f"{100 * section.early.value:.2f} % of the light comes before its sync edge: shorten the sync delay"
        )
    between = abs(losses[0].value - losses[1].value)
    if between > _CERTAIN * np.hypot(losses[0].sigma, losses[1].sigma):
        doubts.append(
            f"chessboards of one and of two pixels tell {losses[0]} and {losses[1]}: what is lost goes not with borders alone"
        )
    return doubts
