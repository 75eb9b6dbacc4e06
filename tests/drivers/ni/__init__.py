"""Tests of the NI driver: its tasks on a scripted NI-DAQmx, its runs on scripted samples."""
