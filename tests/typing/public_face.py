"""What the public functions give, as a type checker sees it. mypy and pyright read this file; it is never run."""

from pathlib import Path
from typing import assert_type

import instrument
import kinopix
from protocols import Floats


def a_run(bench: Path, plan_file: Path, out: Path) -> None:
    """Acquisition."""
    plan = instrument.Plan.from_toml(plan_file)
    assert_type(plan, instrument.Plan)
    assert_type(instrument.scheme_of(plan), instrument.Scheme)
    with instrument.Instrument.from_toml(bench) as session:
        assert_type(session, instrument.Instrument)
        assert_type(session.run(plan, out), instrument.Recording)
    assert_type(instrument.Instrument.from_toml(bench).run(plan, out), instrument.Recording)


def an_analysis(path: Path) -> None:
    """Analysis of a file, in one step and step by step."""
    recording = instrument.open_recording(path)
    assert_type(recording, instrument.Recording)
    assert_type(recording.timing, instrument.TimingReport | None)
    assert_type(instrument.analyse_path(path), instrument.Figures)
    assert_type(instrument.analyse(recording), instrument.Analysis)
    assert_type(instrument.Measurement.of(recording), instrument.Measurement)
    trajectory = instrument.track(recording)
    assert_type(trajectory, instrument.Trajectory)
    assert_type(trajectory.displacement_px, Floats)
    reconstruction = instrument.reconstruct(recording, trajectory)
    assert_type(reconstruction, instrument.Reconstruction)
    assert_type(reconstruction.image, Floats)
    refined = instrument.refine(recording, trajectory)
    assert_type(refined, instrument.Refined)
    assert_type(refined.image, instrument.Reconstruction)
    assert_type(instrument.StreamingTracker(recording.plan).push(recording.values), Floats)


def the_same_names_through_kinopix(bench: Path, plan_file: Path, path: Path) -> None:
    """Kinopix gives the names of ``instrument`` with their types."""
    plan = kinopix.Plan.from_toml(plan_file)
    assert_type(plan, instrument.Plan)
    assert_type(kinopix.scheme_of(plan), instrument.Scheme)
    assert_type(kinopix.Instrument.from_toml(bench).run(plan, path), instrument.Recording)
    recording = kinopix.open_recording(path)
    assert_type(recording, instrument.Recording)
    assert_type(kinopix.track(recording), instrument.Trajectory)
    assert_type(kinopix.reconstruct(recording, None), instrument.Reconstruction)
    assert_type(kinopix.analyse(recording), instrument.Analysis)
    assert_type(kinopix.analyse_path(path), instrument.Figures)
    assert_type(kinopix.refine(recording, kinopix.track(recording)), instrument.Refined)
