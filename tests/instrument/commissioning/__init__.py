"""The commissioning of a bench."""
