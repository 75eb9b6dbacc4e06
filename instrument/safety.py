"""Safe state: stage at rest, modulator halted, counter disarmed, each even if another fails."""

from collections.abc import Callable

from instrument.acquisition import Devices
from instrument.config import OnAbort
from protocols import Motion, SafeStateFailed


def make_safe(devices: Devices, on_abort: OnAbort = "stop", motion: Motion | None = None) -> None:
    """Bring every device to rest.

    Args:
        devices: of the bench.
        on_abort: what the stage does: ``stop`` where it is; ``hold``: let ``motion`` come to its end; ``home``: stop, then look
            for the origin.
        motion: under way, where one is known.

    Raises:
        SafeStateFailed: names each device that may still be moving, showing or counting.
    """
    steps: dict[str, Callable[[], object]] = {
        "modulator": devices.modulator.halt,
        "counter": devices.counter.disarm,
        "stage": devices.stage.stop if on_abort != "hold" or motion is None else motion.wait,
    }
    if on_abort == "home":
        steps["stage, homing"] = lambda: devices.stage.home().wait()
    elif on_abort == "stop":
        steps = {"stage": steps.pop("stage"), **steps}  # what moves comes first
    failures: dict[str, BaseException] = {}
    for name, step in steps.items():
        try:
            step()
        except Exception as error:  # noqa: BLE001 - whatever one device does, the next must still be made safe
            failures[name] = error
    if failures:
        raise SafeStateFailed(failures)
