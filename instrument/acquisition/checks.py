"""Every check that a plan can be given before anything moves."""

from collections.abc import Callable

import numpy as np

from instrument.acquisition.check_report import Check, CheckReport
from instrument.acquisition.memory import analysis_bytes, available_bytes, recording_bytes
from instrument.acquisition.whereabouts import Whereabouts, leaving, where_in_words, whereabouts
from instrument.config import Calibration, PluginBroken
from instrument.plan import Plan
from instrument.schemes import scheme_of
from instrument.storage import needed_on_disk
from protocols import (
    CounterLimits,
    KinopixError,
    LinearStage,
    ModulatorLimits,
    PatternSequence,
    PlanError,
    Scene,
)


def check_plan(
    plan: Plan,
    *,
    sequence: Callable[[], PatternSequence],
    modulator: ModulatorLimits,
    counter: CounterLimits,
    stage: LinearStage | None,
    calibration: Calibration | None = None,
    scene: Scene | None = None,
    memory_bytes: Callable[[], int | None] = available_bytes,
) -> CheckReport:
    """Ask every question at once, so that one look shows all that is wrong.

    Args:
        plan: the run.
        sequence: builds the patterns; called only if the field fits.
        modulator: limits as read from the device.
        counter: limits as read from the device.
        stage: asked by its own ``check``, which moves nothing; None where the bench has none, or it was not opened.
        calibration: what was measured of the bench.
        scene: the simulated bench, which knows where its object is; it moves nothing.
        memory_bytes: tells how much memory this computer has left.
    """
    memory = _computer_memory(plan, memory_bytes())
    # The patterns are made only where they fit: a system without memory ends programs without a word.
    built = _built(plan, modulator, sequence) if memory.outcome != "error" else None
    where = whereabouts(plan, plan.grid(modulator.columns, modulator.rows), calibration, scene)
    checks = [
        memory,
        _picture_time(plan, modulator),
        *(_memory(built, modulator) if isinstance(built, PatternSequence) else [built] if built is not None else []),
        _sync_rate(plan, counter),
        _count_rate(plan, counter),
        *_motion(plan, stage),
        *_calibration(plan, calibration),
        _displacement(plan, where),
        *_object(plan, where, None if stage is None else stage.limits.travel_mm),
        *([] if scene is not None else _wiring(plan, calibration)),
        _run_length(plan, counter),
        *_stop_rules(plan, counter),
        _disk(plan),
    ]
    return CheckReport(tuple(checks), built if isinstance(built, PatternSequence) else None)


def _good(name: str, message: str) -> Check:
    return Check(name, "good", message)


def _error(name: str, error: KinopixError) -> Check:
    return Check(name, "error", str(error), error)


def _picture_time(plan: Plan, limits: ModulatorLimits) -> Check:
    time_us, asked_us = plan.picture_time_us, 1e6 / plan.pattern_rate_hz
    try:
        limits.check_picture_time(time_us, "modulator")
    except PlanError as error:
        return _error("picture time", error)
    if abs(time_us - asked_us) > 1e-3:
        message = f"{time_us} us, {1e6 / time_us:.1f} patterns/s: boards keep whole microseconds, not {asked_us:.3f}"
        return Check("picture time", "warning", message)
    shortest_us = limits.shortest_picture_time_us
    return _good("picture time", f"{time_us} us, {1e6 / time_us:.0f} patterns/s; the modulator can do {shortest_us} us")


def _built(plan: Plan, limits: ModulatorLimits, sequence: Callable[[], PatternSequence]) -> PatternSequence | Check:
    """Give the patterns, or what forbids to build them."""
    grid = plan.grid(limits.columns, limits.rows)
    if not grid.fits:
        error = PlanError(
            device="modulator",
            saw=f"an image of {plan.image_size} px with {plan.superpixel} x {plan.superpixel} mirrors a pixel",
            expected=f"at most {min(limits.columns, limits.rows)} mirrors a side",
            remedy="lower image_size or superpixel",
        )
        return _error("field", error)
    try:  # asked before the patterns are made: they might not fit into this computer
        limits.check_play_order(plan.patterns + 1, "modulator")
    except PlanError as error:
        return _error("memory", error)
    built = sequence()
    pictures = plan.patterns + 1
    if len(built.play_order) != pictures:
        broken = PluginBroken(
            device=f"scheme plug-in {plan.scheme.name!r}",
            saw=f"a sequence of {len(built.play_order)} pictures",
            expected=f"{pictures}: {plan.frames} frames of {plan.patterns_per_frame} patterns, and the guard picture",
            remedy="repair the scheme's sequence, or choose another scheme",
        )
        return _error("patterns", broken)
    return built


def _memory(built: PatternSequence, limits: ModulatorLimits) -> list[Check]:
    grid = built.grid
    found = [_good("field", f"{grid.side_mirrors} x {grid.side_mirrors} of {grid.columns} x {grid.rows} mirrors")]
    for what, asked, room, check in (
        ("unique patterns", len(built.planes), limits.unique_patterns, limits.check_unique_patterns),
        ("pictures in the play order", len(built.play_order), limits.play_order_entries, limits.check_play_order),
    ):
        try:
            check(asked, "modulator")
        except PlanError as error:
            found.append(_error("memory", error))
        else:
            found.append(_good("memory", f"{asked} of {room} {what}"))
    if limits.longest_upload_s:
        longest_s = len(built.planes) * limits.longest_upload_s
        found.append(_good("upload", f"up to {longest_s:.3g} s, if the patterns do not compress"))
    return found


def _computer_memory(plan: Plan, available: int | None) -> Check:
    recorded, analysed = recording_bytes(plan), analysis_bytes(plan)
    message = f"{analysed / 1e6:.0f} MB for the run and its analysis"
    if available is None:
        return Check("computer memory", "warning", f"{message}; this system does not tell what it has")
    if recorded > available:
        error = PlanError(
            saw=f"a plan that takes {recorded / 1e6:.0f} MB to record",
            expected=f"at most the {available / 1e6:.0f} MB that this computer has left",
            remedy="lower frames or image_size, close other programs, or record on a computer with more memory",
        )
        return _error("computer memory", error)
    if analysed > available:
        at_once = (
            f"{analysed / 1e6:.0f} MB with its analysis at once, more than the {available / 1e6:.0f} MB that are left"
        )
        advice = "analyse it in windows (kinopix analyse --window 50000)"
        return Check("computer memory", "warning", f"{recorded / 1e6:.0f} MB for the run; {at_once}: {advice}")
    return _good("computer memory", f"{message}; {available / 1e6:.0f} MB are left")


def _sync_rate(plan: Plan, limits: CounterLimits) -> Check:
    rate_hz = 1 / plan.picture_time_s
    try:
        limits.check_sync_rate(plan.picture_time_s, "counter")
    except PlanError as error:
        return _error("sync rate", error)
    return _good("sync rate", f"{rate_hz:.0f} Hz; the counter can do {limits.max_sync_rate_hz:.3g} Hz")


def _count_rate(plan: Plan, limits: CounterLimits) -> Check:
    """Loss of a non-paralyzable counter: 1 - M/N = N tau / (1 + N tau) at the true rate N."""
    most = limits.max_count_rate_hz * plan.picture_time_s
    if plan.brightest_counts is None:
        return _good("count rate", f"linear up to {most:.0f} counts a pattern; brightest_counts is not stated")
    rate_hz = plan.brightest_counts / plan.picture_time_s
    loss = rate_hz * limits.dead_time_s  # M tau at the measured rate M
    message = f"{plan.brightest_counts:g} counts a pattern are {rate_hz:.3g}/s: {100 * loss:.1f} % lost in dead time"
    if rate_hz > limits.max_count_rate_hz:
        error = PlanError(
            device="counter",
            saw=message,
            expected=f"at most {limits.max_count_rate_hz:.3g}/s, {most:.0f} counts a pattern",
            remedy="put in a denser filter, or lower pattern_rate_hz and brightest_counts with it",
        )
        return _error("count rate", error)
    return Check("count rate", "warning" if loss > 0.05 else "good", message)


def _motion(plan: Plan, stage: LinearStage | None) -> list[Check]:
    motion = plan.motion
    if motion is None:
        return [_good("stage", "stays where it is")]
    if stage is None:
        error = PlanError(
            saw="a plan that moves the stage, on a bench that was opened without one",
            expected="a stage",
            remedy="open the whole bench, or leave out [motion]",
        )
        return [_error("stage", error)]
    end_mm = motion.end_mm(plan.run_time_s)
    found: list[Check] = []
    for what, target_mm in (("start", motion.start_mm), ("end", end_mm)):
        try:
            stage.check(target_mm, motion.profile)
        except KinopixError as error:
            found.append(_error(f"stage {what}", error))
    if found:
        return found
    low, high = stage.limits.travel_mm
    where = f"{motion.start_mm:g} mm to {end_mm:.5g} mm, travel {low:g} to {high:g} mm"
    run_up = f"run-up {motion.run_up_s:.3g} s" if motion.run_up_s else "no run-up"
    return [_good("stage", f"{where}; {run_up}")]


def _calibration(plan: Plan, calibration: Calibration | None) -> list[Check]:
    """A calibration in pixels holds for pixels of one size."""
    if calibration is None:
        return []
    try:
        calibration.refuse_other_grid(plan.image_size, plan.superpixel)
    except KinopixError as error:
        return [_error("calibration", error)]
    measured = (f"[{name}] of {section.date:%Y-%m-%d}" for name, section in calibration.sections.items())
    return [_good("calibration", ", ".join(measured) or "empty")]


def _object(plan: Plan, where: Whereabouts | None, travel_mm: tuple[float, float] | None) -> list[Check]:
    """Whether the object stays in the field."""
    if plan.motion is None:
        return []
    if where is None:
        return [_good("object", "where it will be is not known: the bench has no calibration of displacement")]
    error = leaving(where, plan, travel_mm)
    message = where_in_words(where, plan.image_size)
    if error is not None and plan.motion.field == "stay":
        return [_error("object", error)]
    if error is not None:
        return [Check("object", "warning", f"{error.saw}; the plan says that it may leave")]
    beyond_px = float(where.beyond_px(plan.image_size).max())
    if beyond_px > 0:
        return [Check("object", "warning", f"{message}: it comes to the border of the field")]
    return [_good("object", message)]


def _wiring(plan: Plan, calibration: Calibration | None) -> list[Check]:
    """Say how patterns are wired and how the picture lies, or ask for the alignment that tells.

    A run tells by itself how patterns are wired. How the picture lies it tells only against the stage's calibrated axis.
    """
    if scheme_of(plan).image_rows is None:
        return []
    aligned = None if calibration is None else calibration.alignment
    if aligned is not None:
        as_meant = aligned.wiring == "as planned" and aligned.orientation == "upright"
        message = (
            f"patterns {aligned.wiring}, the picture {aligned.orientation}, by the alignment of {aligned.date:%Y-%m-%d}"
        )
        return [Check("wiring", "good" if as_meant else "warning", message)]
    known = None if calibration is None else calibration.displacement
    axis = "" if known is None else "; against the stage's axis it will be seen whether the picture is turned"
    asked = "whether the picture is mirrored or turned is not known, and a run does not tell: `kinopix calibrate alignment` does"
    return [_good("wiring", asked + axis)]


def _displacement(plan: Plan, where: Whereabouts | None) -> Check:
    """A periodic position is unambiguous within half a period from frame to frame (the paper, equation 6)."""
    position = scheme_of(plan).position
    if position is None:
        if plan.motion is None:
            return _good("displacement", f"{plan.scheme.name} sees none; the stage does not move")
        message = f"{plan.scheme.name} sees no displacement, and the plan moves the stage"
        return Check("displacement", "warning", message)
    range_px = np.inf if position.period_px is None else position.period_px / 2
    within = "unambiguous everywhere" if position.period_px is None else f"unambiguous within {range_px:g} px a frame"
    if plan.motion is None:
        return _good("displacement", f"{within}; the stage does not move")
    if where is None:
        return _good("displacement", f"{within}; the bench has no calibration of displacement")
    step_px = abs(plan.motion.velocity_mm_s) * float(np.hypot(*where.px_per_mm)) * plan.frame_time_s
    message = f"{step_px:.3g} px a frame, {within.removesuffix(' a frame')}"
    if step_px >= range_px:
        error = PlanError(
            saw=message,
            expected=f"less than {range_px:g} px a frame",
            remedy="lower velocity_mm_s or fourier_cycles, or raise pattern_rate_hz",
        )
        return _error("displacement", error)
    if step_px > 1:
        return Check("displacement", "warning", f"{message}; above 1 px the patterns of a frame differ in place")
    return _good("displacement", message)


def _run_length(plan: Plan, limits: CounterLimits) -> Check:
    patterns = plan.patterns
    message = f"{plan.frames} frames, {patterns} patterns, {plan.run_time_s:.4g} s"
    try:
        limits.check_bins(patterns, "counter")
    except PlanError as error:
        return _error("run length", error)
    if scheme_of(plan).image_rows is not None and plan.frames > plan.image_size**2:
        return Check("run length", "warning", f"{message}; Hadamard patterns repeat after {plan.image_size**2} frames")
    return _good("run length", message)


def _stop_rules(plan: Plan, limits: CounterLimits) -> list[Check]:
    """Which rules may end the run early, and which of them never can on this bench."""
    table = plan.stop_if
    if table is None:
        return []
    given = table.rules
    idle = [f"{key} holds for longer than the run lasts" for key, hold_s in given.items() if hold_s > plan.run_time_s]
    if "audit_fails_s" in given and limits.edge_time_resolution_s is None:
        idle.append("audit_fails_s sees nothing of a counter without edge times")
    message = ", ".join(f"{key} = {hold_s:g}" for key, hold_s in given.items())
    return [Check("stop rules", "warning" if idle else "good", "; ".join([message, *idle]))]


def _disk(plan: Plan) -> Check:
    """Tell how much room the recording takes; a run looks whether it is there when it knows where."""
    needed = needed_on_disk(plan.patterns)
    return _good("disk", f"{needed / 1e6:.1f} MB, with a copy while an analysis is stored")
