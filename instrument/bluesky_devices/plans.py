"""Plans for the RunEngine, which do the steps of the detector in their order and leave the bench safe."""

from collections.abc import Mapping
from typing import Any, Final

from bluesky import plan_stubs, preprocessors
from bluesky.utils import MsgGenerator

from instrument.bluesky_devices.detector import KinopixDetector
from instrument.plan import Plan

bps: Any = plan_stubs  # typed in parts: the types end here
bpp: Any = preprocessors


FLUSH_S: Final = 1.0
"""Time from one telling of what is in the file to the next, if nobody says otherwise."""


def record(
    detector: KinopixDetector, plan: Plan, *, flush_s: float | None = FLUSH_S, md: Mapping[str, Any] | None = None
) -> MsgGenerator[None]:
    """Carry out one plan of Kinopix as one run of bluesky; its file is told of while it grows, and whatever ends it.

    However the plan is left, a run that goes on is broken off, the bench is safe, and what was counted is told of. After a pause
    the run is repeated whole, in a new file, whose frames have the numbers of the first ones.

    Args:
        detector: of the bench.
        plan: what is shown, counted and moved.
        flush_s: seconds from one telling of what is in the file to the next; None tells of it at the end.
        md: metadata for the start document, beside the plan itself (``kinopix_plan``).
    """

    def one_run() -> MsgGenerator[None]:
        yield from bps.prepare(detector, plan, wait=True)
        yield from bps.declare_stream(detector, name="primary", collect=True)
        yield from bps.declare_stream(detector.audit, name="audit", collect=True)
        yield from bpp.finalize_wrapper(flight(), landing())

    def flight() -> MsgGenerator[None]:
        yield from bps.checkpoint()
        yield from bps.kickoff(detector, wait=True)
        yield from bps.collect_while_completing([detector], [detector], flush_period=flush_s, stream_name="primary")

    def landing() -> MsgGenerator[None]:
        yield from bps.stop(detector)
        yield from bps.collect(detector, name="primary")
        yield from bps.collect(detector.audit, name="audit")

    about = {"kinopix_plan": plan.model_dump(mode="json"), **(md or {})}
    yield from bpp.stage_wrapper(bpp.run_wrapper(one_run(), md=about), [detector])
