"""Safe state: stage at rest, modulator halted, counter disarmed, each even if another fails."""

from collections.abc import Callable
from contextlib import suppress
from functools import partial

from instrument.acquisition import Devices
from instrument.config import OnAbort
from instrument.roles import STAGE
from protocols import Motion, SafeStateFailed


def stop_at_once(devices: Devices, on_abort: OnAbort = "stop") -> None:
    """Stop what moves and shows, from any thread, whatever the devices answer.

    It is the first thing after an error or an abort. What fails here is met again by ``make_safe``, which names it.

    Args:
        devices: of the bench.
        on_abort: with ``hold`` a stage that moves is let go on.
    """
    for role in sorted(devices.roles(), key=lambda role: not role.moves):
        if role.any_thread and not (role is STAGE and on_abort == "hold"):
            with suppress(Exception):
                role.make_safe(devices[role])


def make_safe(devices: Devices, on_abort: OnAbort = "stop", motion: Motion | None = None) -> None:
    """Bring every device to rest, what moves first.

    Args:
        devices: of the bench.
        on_abort: what the stage does: ``stop`` where it is; ``hold``: let ``motion`` come to its end, after all others are at
            rest; ``home``: stop, then look for the origin.
        motion: under way, where one is known.

    Raises:
        SafeStateFailed: names each device that may still be moving, showing or counting.
    """
    held = on_abort == "hold" and motion is not None
    steps: dict[str, Callable[[], object]] = {}
    for role in sorted(devices.roles(), key=lambda role: not role.moves):
        if not (held and role is STAGE):
            steps[role.name] = partial(role.make_safe, devices[role])
    if held and motion is not None:
        steps["stage"] = motion.wait
    if on_abort == "home":
        steps["stage, homing"] = lambda: devices.stage.home().wait()
    failures: dict[str, BaseException] = {}
    for name, step in steps.items():
        try:
            step()
        except Exception as error:  # noqa: BLE001 - whatever one device does, the next must still be made safe
            failures[name] = error
    if failures:
        raise SafeStateFailed(failures)
