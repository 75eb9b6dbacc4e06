"""What a bench does to the light on its way from the object to a count, as a value with the source of each number."""

from typing import Final, Literal, TypeAlias

from pydantic import NonNegativeFloat

from instrument.config import LightTable, MirrorsSection
from instrument.measurement.ripple import Ripple
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

    ripples: tuple[Ripple, ...] = ()
    """Periodic changes of lamp and ambient light, fitted to the run."""

    offsets: tuple[Parameter, ...] = ()
    """Offset of each pattern that measures position, in the order of their columns, as a share of the total light; none for 0."""

    @classmethod
    def of(
        cls, table: LightTable, mirrors: MirrorsSection | None = None, picture_time_s: float = 50e-6
    ) -> "LightModel":
        """Give the light model that ``[light]`` states, or else the calibration; what neither states is assumed to be 0.

        Args:
            table: of bench.toml.
            mirrors: the calibration's section; None where the mirrors were not measured.
            picture_time_s: of the run: mirrors that take their time leak more in a shorter picture.
        """
        stated = {"leak": table.leak, "edge_loss": table.edge_loss}
        given = {name: Parameter(value=value, source="given") for name, value in stated.items() if value is not None}
        if mirrors is not None:
            leak = mirrors.leak_at(picture_time_s)
            measured = {"leak": leak, "edge_loss": mirrors.edge_loss}
            given = {
                name: Parameter(value=max(0.0, number.value), sigma=number.sigma, source="calibrated")
                for name, number in measured.items()
            } | given
        return cls.model_validate(given)


IDEAL: Final = LightModel()
"""The bench that does nothing to the light."""
