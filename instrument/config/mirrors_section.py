"""The ``[mirrors]`` section of a calibration file: what mirrors that turn, and the borders between them, do to light."""

from typing import Annotated

from pydantic import Field

from instrument.config.calibration_section import Section
from instrument.config.detector_section import Measured


class MirrorsSection(Section):
    """Leak of one picture into the next, loss at borders, and the delay between the sync edge and its light."""

    picture_time_s: Annotated[float, Field(gt=0)]
    """Picture time at which it was measured. At another one the leak is another: its time, ``late_s``, stays."""

    leak: Measured
    """Share of the picture before in the light of a picture."""

    early: Measured
    """Share of the picture after it: above 0 where light comes before its edge."""

    edge_loss: Measured
    """Share of a lit mirror's light that is lost at each of its sides that borders a dark mirror."""

    late_s: Measured
    """Mean delay of the light after its sync edge, half of the mirrors' transition included."""

    whole_pictures_late: int = 0
    """Whole picture times by which patterns come late after their edges; on a bench that is well 0."""

    def leak_at(self, picture_time_s: float) -> Measured:
        """Give the leak at another picture time: the mirrors take the same time to turn."""
        factor = self.picture_time_s / picture_time_s
        return Measured(value=self.leak.value * factor, sigma=self.leak.sigma * factor)
