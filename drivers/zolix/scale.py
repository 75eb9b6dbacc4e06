"""The one place where millimetres become pulses and back."""

from dataclasses import dataclass

from protocols import MotionProfile


@dataclass(frozen=True)
class Speeds:
    """A motion profile in the controller's own unit."""

    velocity: int
    """Pulses a second."""

    acceleration: int
    """Pulses a second squared."""

    initial: int
    """Pulses a second."""


@dataclass(frozen=True)
class Scale:
    """Pulses a millimetre: full steps a turn x microsteps / lead (fact sheet, section 2)."""

    pulses_per_mm: float

    @property
    def tolerance_mm(self) -> float:
        """Two positions that differ by less are the same: one and a half pulses."""
        return 1.5 / self.pulses_per_mm

    def pulses(self, mm: float) -> int:
        """Nearest whole pulse."""
        return round(mm * self.pulses_per_mm)

    def mm(self, pulses: float) -> float:
        """Position or way of so many pulses."""
        return pulses / self.pulses_per_mm

    def speeds(self, profile: MotionProfile) -> Speeds:
        """Whole pulses nearest to ``profile``."""
        return Speeds(
            velocity=self.pulses(profile.velocity_mm_s),
            acceleration=self.pulses(profile.acceleration_mm_s2),
            initial=self.pulses(profile.initial_velocity_mm_s),
        )

    def profile(self, speeds: Speeds) -> MotionProfile:
        """The profile that the controller really runs."""
        return MotionProfile(
            velocity_mm_s=self.mm(speeds.velocity),
            acceleration_mm_s2=self.mm(speeds.acceleration),
            initial_velocity_mm_s=self.mm(speeds.initial),
        )
