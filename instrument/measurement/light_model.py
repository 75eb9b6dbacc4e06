"""What a bench does to the light on its way from the object to a count, as a value with the source of each number."""

from typing import Any, Final, Literal, TypeAlias

import numpy as np
from pydantic import NonNegativeFloat

from instrument.config import Calibration, Grid, LightTable, Stated, StatedProfile
from instrument.measurement.profile import Profile
from instrument.measurement.ripple import Ripple
from instrument.plan import Plan
from protocols import Frozen

Source: TypeAlias = Literal["assumed", "given", "calibrated", "fitted"]
"""Where a number comes from: nobody said anything, bench.toml, a recording made for it, or the run itself."""


class Parameter(Frozen):
    """A number of the light model."""

    value: float
    """The number."""

    sigma: NonNegativeFloat | None = None
    """Its standard deviation; None where nobody stated one."""

    source: Source = "assumed"
    """Where it comes from."""

    @property
    def free(self) -> bool:
        """Whether the run itself may say what it is: a number that was given or calibrated stays."""
        return self.source in {"assumed", "fitted"}


class LightModel(Frozen):
    """How the bench differs from an ideal one. The ideal one is the default.

    With v_k the light that pattern k lets through, as it acts, what arrives in its picture time is

        y_k = (1 - c) v_k + c v_(k-1),

    c being the leak of the picture before, whose mirrors are still turning. A pattern acts as if each side of a lit mirror that
    borders a dark one took the share e of that mirror's light. Light that does not come by way of the moving object, or that
    the patterns' edges lose, adds to each position pattern the same share of the total light: its offset.

    References:
        P. L. M. Heydemann, Appl. Opt. 20 (1981) 3382: offsets as the centre of the circle that a phase goes round.
    """

    leak: Parameter = Parameter(value=0.0)
    """c: share of the picture before in the light of a picture, 0 to 1/2."""

    edge_loss: Parameter = Parameter(value=0.0)
    """e: share of a lit mirror's light that is lost at each of its sides that borders a dark mirror."""

    profile: Profile | None = None
    """How bright the modulator's field is lit; None for evenly."""

    ripples: tuple[Ripple, ...] = ()
    """Periodic changes of lamp and ambient light, fitted to the run."""

    offsets: tuple[Parameter, ...] = ()
    """Offset of each pattern that measures position, in the order of their columns, as a share of the total light; none for 0."""

    @classmethod
    def of(cls, table: LightTable, calibration: Calibration | None = None, plan: Plan | None = None) -> "LightModel":
        """Give the light model that ``[light]`` states, or else the calibration; what neither states is assumed to be 0.

        Args:
            table: of bench.toml.
            calibration: of the bench; None where it was not calibrated.
            plan: of the run, where there is a calibration: mirrors that take their time leak more in a shorter picture, and a
                profile holds for the field that it was measured on.
        """
        stated = {"leak": table.leak, "edge_loss": table.edge_loss}
        known: dict[str, Any] = {name: _parameter(value) for name, value in stated.items() if value is not None}
        if table.profile is not None:
            known["profile"] = _profile(table.profile)
        return cls.model_validate(
            known if calibration is None or plan is None else _calibrated(calibration, plan) | known
        )


def _calibrated(calibration: Calibration, plan: Plan) -> dict[str, Any]:
    """Give what the calibration says of a run."""
    mirrors, light = calibration.mirrors, calibration.light
    measured = {} if mirrors is None else {"leak": mirrors.leak_at(plan.picture_time_s), "edge_loss": mirrors.edge_loss}
    known: dict[str, Any] = {
        name: Parameter(value=max(0.0, number.value), sigma=number.sigma, source="calibrated")
        for name, number in measured.items()
    }
    if light is not None and light.field_mirrors == plan.image_size * plan.superpixel:
        known["profile"] = Profile.of_blocks(np.array(light.profile), np.array(light.profile_sigma))
    return known


def _parameter(stated: float | Stated) -> Parameter:
    """Give a number of the table as one of the model."""
    if isinstance(stated, Stated):
        return Parameter(value=stated.value, sigma=stated.sigma, source=stated.source)
    return Parameter(value=stated, source="given")


def _profile(stated: Grid | StatedProfile) -> Profile:
    """Give a profile of the table as one of the model."""
    if isinstance(stated, StatedProfile):
        return Profile(values=stated.values, sigma=stated.sigma, source=stated.source)
    return Profile(values=stated)


IDEAL: Final = LightModel()
"""The bench that does nothing to the light."""
