"""The one place where millimetres become pulses and back."""

from dataclasses import dataclass

from protocols import MotionProfile


@dataclass(frozen=True)
class Speeds:
    """A motion profile in the controller's own unit."""

    velocity: int
    """Velocity between the ramps, in pulses a second."""

    acceleration: int
    """Acceleration of both ramps, in pulses a second squared."""

    initial: int
    """Velocity at the start and at the end, in pulses a second."""


@dataclass(frozen=True)
class Scale:
    """Pulses a millimetre: full steps a turn x microsteps / lead (fact sheet, section 2)."""

    pulses_per_mm: float
    """Number of pulses that move the stage by one millimetre."""

    @property
    def tolerance_mm(self) -> float:
        """Difference up to which two positions are the same, in millimetres: one and a half pulses."""
        return 1.5 / self.pulses_per_mm

    def pulses(self, mm: float) -> int:
        """Give the whole pulse nearest to ``mm``, a position, distance, speed or acceleration."""
        return round(mm * self.pulses_per_mm)

    def mm(self, pulses: float) -> float:
        """Give the position or distance of so many pulses, in millimetres."""
        return pulses / self.pulses_per_mm

    def speeds(self, profile: MotionProfile) -> Speeds:
        """Give the whole pulses nearest to ``profile``."""
        return Speeds(
            velocity=self.pulses(profile.velocity_mm_s),
            acceleration=self.pulses(profile.acceleration_mm_s2),
            initial=self.pulses(profile.initial_velocity_mm_s),
        )

    def profile(self, speeds: Speeds) -> MotionProfile:
        """Give the profile that the controller really runs."""
        return MotionProfile(
            velocity_mm_s=self.mm(speeds.velocity),
            acceleration_mm_s2=self.mm(speeds.acceleration),
            initial_velocity_mm_s=self.mm(speeds.initial),
        )
