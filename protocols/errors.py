"""One error tree for the whole product.

Every error is a sentence a person at the bench can act on: on which device, what was seen, what was expected,
what to do. ``exit_code`` is what the command returns for it: 2 for a wrong input, 3 for a device or timing fault.
"""

from typing import ClassVar


class KinopixError(Exception):
    """Root of every error that Kinopix raises on purpose."""

    exit_code: ClassVar[int] = 3

    def __init__(self, *, saw: str, expected: str, remedy: str, device: str | None = None) -> None:
        """Build the message from its parts, and keep the parts.

        Args:
            saw: what was there ("a picture time of 40 us").
            expected: what should have been there ("at least 44 us").
            remedy: what the reader does now, in the imperative.
            device: the device's name, or None where no device is involved.
        """
        self.device = device
        self.saw = saw
        self.expected = expected
        self.remedy = remedy
        where = f"{device}: " if device else ""
        super().__init__(f"{where}saw {saw}; expected {expected}. To do: {remedy}.")


class InputError(KinopixError):
    """What the user gave cannot be used. Nothing has moved."""

    exit_code = 2


class PlanError(InputError):
    """A plan that this bench cannot carry out."""


class PictureTimeTooShort(PlanError):
    """The modulator cannot change pictures that fast."""

    def __init__(self, device: str, asked_us: float, shortest_us: int) -> None:
        """Name both times, and the rate that would do."""
        super().__init__(
            device=device,
            saw=f"a picture time of {asked_us:g} us",
            expected=f"at least {shortest_us} us",
            remedy=f"lower pattern_rate_hz to {1e6 / shortest_us:.0f} or less",
        )


class PatternMemoryFull(PlanError):
    """More unique patterns (or a longer play order) than the modulator holds."""

    def __init__(self, device: str, asked: int, available: int, what: str = "unique patterns") -> None:
        """Name both numbers."""
        super().__init__(
            device=device,
            saw=f"{asked} {what}",
            expected=f"at most {available}",
            remedy="record fewer frames a run",
        )


class TravelExceeded(PlanError):
    """A target outside the stage's travel. No byte was sent."""

    def __init__(self, device: str, target_mm: float, travel_mm: tuple[float, float]) -> None:
        """Name the target and both ends of the travel."""
        low, high = travel_mm
        super().__init__(
            device=device,
            saw=f"a target of {target_mm:g} mm",
            expected=f"{low:g} to {high:g} mm",
            remedy="change start_mm, velocity_mm_s or the number of frames, or the stage's limits in bench.toml",
        )


class MotionTooFast(PlanError):
    """A velocity or an acceleration that the stage does not allow."""

    def __init__(self, device: str, what: str, asked: float, highest: float, unit: str) -> None:
        """Name what was asked and the most that is allowed."""
        super().__init__(
            device=device,
            saw=f"{what} of {asked:g} {unit}",
            expected=f"more than 0 and at most {highest:g} {unit}",
            remedy=f"lower the {what} in plan.toml",
        )


class DeviceError(KinopixError):
    """A device did not do what it should."""


class DriverUnavailable(DeviceError):
    """The driver is installed, but what it stands on (a vendor library, a port, a device) is not there."""


class DeviceDisconnected(DeviceError):
    """The device was there and is gone."""


class DeviceBusy(DeviceError):
    """Somebody else holds the device, or it is still at work on the last task."""


class DeviceTimeout(DeviceError):
    """The device did not answer, or did not finish, in the time that its own figures allow."""

    def __init__(self, device: str, *, awaited: str, waited_s: float, progress: str, remedy: str) -> None:
        """Name what was awaited, for how long, and how far it had come."""
        super().__init__(
            device=device,
            saw=f"{progress} after {waited_s:.3g} s",
            expected=awaited,
            remedy=remedy,
        )


class DeviceRefused(DeviceError):
    """The device answered with an error of its own. ``code`` is that answer, as the device gave it."""

    def __init__(self, device: str, *, code: str, saw: str, expected: str, remedy: str) -> None:
        """Keep the device's code beside the sentence."""
        self.code = code
        super().__init__(device=device, saw=f"{saw} (code {code})", expected=expected, remedy=remedy)


class ProtocolViolation(DeviceError):
    """The device sent what its protocol does not allow."""


class WrongState(DeviceError):
    """A call that the device's life cycle does not allow now."""


class TimingFault(KinopixError):
    """The hardware's own timing broke: missing, surplus or irregular edges."""


class TriggerMissed(TimingFault):
    """Fewer sync edges than the play order calls for."""

    def __init__(self, device: str, *, bins_read: int, bins_expected: int, waited_s: float) -> None:
        """Name the bins counted and the bins expected."""
        self.bins_read = bins_read
        self.bins_expected = bins_expected
        super().__init__(
            device=device,
            saw=f"{bins_read} of {bins_expected} patterns counted, then no sync edge for {waited_s:.3g} s",
            expected=f"{bins_expected + 1} sync edges",
            remedy="check the sync cable, its level and its width against the counter's input filter",
        )


class CounterOverrun(TimingFault):
    """Counts were lost inside the counter or on their way to the host. Those read before are good."""


class SafeStateFailed(DeviceError):
    """One or more devices could not be made safe, or did not tell that they are. The others were, and did."""

    def __init__(self, failures: dict[str, BaseException], *, stands_in_s: float | None = None) -> None:
        """Name each device that may still be moving, showing or counting, with its own error.

        Args:
            failures: by device.
            stands_in_s: for a stage among them: seconds from now by which its motion is over, even if no stop is obeyed.
        """
        self.failures = failures
        self.stands_in_s = stands_in_s
        super().__init__(
            device=", ".join(failures),
            saw="; ".join(_named(name, str(error)) for name, error in failures.items()),
            expected="stage stopped, modulator halted, counter disarmed",
            remedy=f"look at the bench and switch off by hand what is named here{_and_wait(stands_in_s)}",
        )


def _named(device: str, error: str) -> str:
    return error if error.startswith(f"{device}:") else f"{device}: {error}"


def _and_wait(stands_in_s: float | None) -> str:
    if stands_in_s is None:
        return ""
    if stands_in_s <= 0:
        return "; by what it was commanded, the stage has stood for some time"
    return f"; by what it was commanded, the stage moves for another {stands_in_s:.1f} s at most: stay clear until then"
