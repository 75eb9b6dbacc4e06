"""A plan carried out on the simulated bench, from a script, with nothing left on the disk."""

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, cast

import numpy as np

from instrument.config import bench_of_tables
from instrument.plan import Plan, refuse_no_plan
from instrument.recording import Recording
from instrument.roles import ROLES
from instrument.session.instrument import Instrument
from protocols import Floats, InputError

_TITLE: Final = "simulate()"
"""What messages call the bench, which has no file."""


def simulate(
    plan: Plan,
    scene: Mapping[str, Any] | None = None,
    *,
    image: Floats | None = None,
    path: Callable[[Floats], Floats] | None = None,
) -> Recording:
    """Carry out a plan on the simulated bench and give its recording, with the truth in it.

    The simulated devices and the optical bench are found by entry point and run in virtual time, as from a bench.toml that names
    them. Every check of a plan holds. Files are kept in a temporary folder that is gone when this returns.

    Args:
        plan: what is shown. Its motion, if it has one, moves the stage, and the stage carries the object.
        scene: what stands under ``[scene]`` in bench.toml, such as ``{"object": "letter-B", "noise": {"kind": "pixel", "sigma":
            0.1, "seed": 1}}``. Relative paths start at the working folder. None takes every default: no noise.
        image: ``(m, m)`` transmission, 0 to 1, of the object where it is not displaced, pixel for pixel on the plan's image
            grid, row = y (down). It takes the place of ``object`` in ``scene``. Outside of it there is no light.
        path: seconds ``(n,)`` after the first sync edge to displacement ``(n, 2)``, x and y in image pixels. It takes the place
            of ``trajectory`` in ``scene``, and so of the stage's motion. The bench reads it in the middle of every pattern and of
            every frame; it is sampled at exactly these times, to a billionth of a pixel, so that a path with corners or
            jumps is simulated as truly as a smooth one.

    Returns:
        The recording. Its ``path`` is None, and ``truth`` is what really was there.

    Raises:
        ConfigError: every mistake in ``scene`` at once.
        InputError: no plan; an ``image`` of another size, or not of transmissions; a ``path`` that gives something else than
            finite places; a key of ``scene`` that says the same; an object that lets no light through.
        PlanError: the bench cannot carry out the plan.
        TimingFault: ``scene`` has faults that break the run.
    """
    refuse_no_plan(plan)
    table = _as_toml(scene or {})
    with TemporaryDirectory(prefix="kinopix-") as name:
        folder = Path(name)
        if image is not None:
            _refuse_both(table, "image", ("object", "object_height_px", "start_px"))
            np.save(folder / "object.npy", _transmission(image, plan.image_size))
            table["object"] = str(folder / "object.npy")
        if path is not None:
            _refuse_both(table, "path", ("trajectory",))
            table["trajectory"] = str(_sampled(path, plan, folder / "trajectory.csv"))
        devices: dict[str, Any] = {role.name: {"driver": "simulated"} for role in ROLES if role.needed}
        with Instrument.from_config(bench_of_tables({**devices, "scene": table}, _TITLE)) as bench:
            recording = bench.run(plan, folder / "run.h5")
    return replace(recording, path=None)


def _as_toml(scene: Mapping[str, Any]) -> dict[str, Any]:
    """The same table in the types that a TOML file has: numbers of numpy, tuples and paths become plain."""

    def plain(value: object) -> object:
        return cast("object", value.tolist()) if isinstance(value, np.generic | np.ndarray) else str(value)

    table: dict[str, Any] = json.loads(json.dumps(dict(scene), default=plain))
    return table


def _refuse_both(table: Mapping[str, Any], argument: str, keys: tuple[str, ...]) -> None:
    """Refuse a scene that says what an argument of ``simulate`` says too."""
    for key in keys:
        if key in table:
            raise InputError(
                saw=f"{key} = {table[key]!r} in the scene, and {argument} beside it",
                expected=f"one of them: {argument} says what {key} would",
                remedy=f"leave out {key}, or {argument}",
            )


def _transmission(image: Floats, image_size: int) -> Floats:
    """The image as float64, if it can stand on the grid pixel for pixel."""
    cells = np.asarray(image, np.float64)
    if cells.shape != (image_size, image_size) or not ((cells >= 0) & (cells <= 1)).all():
        span = f" from {cells.min():g} to {cells.max():g}" if cells.size else ""
        raise InputError(
            saw=f"an image of shape {cells.shape} with values{span}",
            expected=f"shape ({image_size}, {image_size}), the plan's image_size, and transmissions from 0 to 1",
            remedy="scale the image, or name a picture as object in the scene: it may have any size",
        )
    return cells


def _sampled(path: Callable[[Floats], Floats], plan: Plan, csv: Path) -> Path:
    """Write a trajectory with a row every half picture time, among which are the middles of all patterns and all frames."""
    half_us = np.arange(2 * plan.patterns + 3, dtype=np.float64) * (
        plan.picture_time_us / 2
    )  # up to the end of the guard picture
    time_s = half_us * 1e-6
    places_px = np.asarray(path(time_s), np.float64)
    if places_px.shape != (len(time_s), 2) or not np.isfinite(places_px).all():
        raise InputError(
            saw=f"a path that gives shape {places_px.shape} for {len(time_s)} times"
            + ("" if np.isfinite(places_px).all() else ", not all of it finite"),
            expected=f"finite displacements x, y in pixels, shape ({len(time_s)}, 2)",
            remedy="let path return np.stack([x_px, y_px], axis=1) for any array of times in seconds",
        )
    rows = zip(time_s.tolist(), *places_px.T.tolist(), strict=True)
    csv.write_text("t_s,x_px,y_px\n" + "".join(f"{t:.7f},{x:.9f},{y:.9f}\n" for t, x, y in rows), encoding="utf-8")
    return csv
