"""Safe state: stage at rest, modulator halted, counter disarmed, each even if another fails, and verified."""

from collections.abc import Callable, Collection
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
    """Bring every device to rest, what moves first, and then verify that it is: a stop that was sent is not a stage that stands.

    Args:
        devices: of the bench.
        on_abort: what the stage does: ``stop`` where it is; ``hold``: let ``motion`` come to its end, after all others are at
            rest; ``home``: stop, then look for the origin.
        motion: under way, where one is known.

    Raises:
        SafeStateFailed: names each device that may still be moving, showing or counting, and how long the stage may go on.
    """
    failures: dict[str, BaseException] = {}

    def attempt(name: str, step: Callable[[], object]) -> None:
        try:
            step()
        except Exception as error:  # noqa: BLE001 - whatever one device does, the next must still be made safe
            failures[name] = error

    held = on_abort == "hold" and motion is not None
    roles = sorted(devices.roles(), key=lambda role: not role.moves)
    for role in roles:
        if not (held and role is STAGE):
            attempt(role.name, partial(role.make_safe, devices[role]))
    if held and motion is not None:
        attempt(STAGE.name, motion.wait)
    for role in roles:
        if role.verify is not None and role.name not in failures:
            attempt(role.name, partial(role.verify, devices[role], devices.clock))
    if on_abort == "home" and STAGE.name not in failures:
        attempt("stage, homing", lambda: devices.stage.home().wait())
    if failures:
        raise SafeStateFailed(failures, stands_in_s=_stands_in_s(devices, failures))


def _stands_in_s(devices: Devices, failures: Collection[str]) -> float | None:
    """By when a stage that failed must stand, in seconds from now; None where the stage is none of those that failed."""
    if not any(name.startswith(STAGE.name) for name in failures):
        return None
    return devices.stage.stands_by_s - devices.clock.now_s()
