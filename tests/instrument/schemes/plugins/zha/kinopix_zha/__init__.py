"""Schemes by a third party, a good one and broken ones."""
