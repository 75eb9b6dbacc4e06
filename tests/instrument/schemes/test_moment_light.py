"""Light that is not the object's draws a centroid to itself, and no run of moments can tell: the analysis says so."""

from dataclasses import replace

import numpy as np
import pytest

from instrument.analysis import analyse
from instrument.plan import Plan
from instrument.schemes import scheme_of
from kinopix import simulate


@pytest.mark.parametrize("name", ["moment", "moment-hadamard"])
def test_ambient_light_as_strong_as_the_object_halves_the_travel_and_is_doubted_until_it_is_taken_off(
    name: str,
) -> None:
    plan = Plan.model_validate({"frames": 200, "image_size": 32, "superpixel": 2, "scheme": {"name": name}})
    recording = simulate(
        plan,
        {"object": "letter-B", "object_height_px": 12, "start_px": (12.0, 12.0), "noise": {"kind": "none"}},
        path=lambda time_s: np.stack([8 * time_s / (200 * plan.patterns_per_frame * 50e-6), 0 * time_s], axis=1),
    )
    scheme = scheme_of(plan)
    total = float((recording.values @ scheme.light_weights).mean())
    lit = np.array([0.5] * plan.patterns_per_frame)  # ramps, and half-lit pairs, see half of an even light
    if name == "moment":
        lit[0] = 1.0
    ambient = replace(recording, values=recording.values + total * lit)
    told = analyse(ambient, tracking="smooth")
    assert told.trajectory is not None
    assert told.trajectory.displacement_px[-1, 0] == pytest.approx(4.0, abs=0.25)
    assert any("moments take all light for the object's" in doubt for doubt in told.figures.doubts)
    known = replace(ambient, background=np.broadcast_to(total * lit, ambient.values.shape).copy())
    mended = analyse(known, tracking="smooth")
    assert mended.trajectory is not None
    assert mended.trajectory.displacement_px[-1, 0] == pytest.approx(8.0, abs=0.25)
    assert not any("moments" in doubt for doubt in mended.figures.doubts)
