"""Drivers by a third party, good and broken ones."""
