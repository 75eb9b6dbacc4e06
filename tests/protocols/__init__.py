"""Tests of the values that all devices share: what they refuse, and what their errors say."""
