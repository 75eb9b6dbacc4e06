"""Tests of the DLP7000 driver, on a scripted ALP function table."""
