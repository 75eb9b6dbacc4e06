"""Tests of the tools beside the product that decide something."""
