"""A new bench's devices measured one after another, and a report that a laboratory can send back."""

from instrument.commissioning.commission import Consent, Effect, commission
from instrument.commissioning.report import AskedQuestion, CommissioningReport, DeviceReport, Finding

__all__ = [
    "AskedQuestion",
    "CommissioningReport",
    "Consent",
    "DeviceReport",
    "Effect",
    "Finding",
    "commission",
]
