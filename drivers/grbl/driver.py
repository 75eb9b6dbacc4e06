"""Opening a GRBL stage: who it is, and whether bench.toml and the controller's own settings agree."""

from typing import Final

import serial

from drivers.grbl.axis import GrblAxis
from drivers.grbl.codec import LONGEST, UNLOCK
from drivers.grbl.link import GrblLink
from drivers.grbl.settings import GrblSettings
from drivers.polled_stage import PolledStage
from protocols import BenchContext, DeviceIdentity, DeviceTimeout, DriverUnavailable, InputError, MotionProfile

_NAME: Final = "stage"
_POLL_S: Final = 0.1
"""Time between two questions to a stage that moves: GRBL's own pages ask for ten a second at most."""


def open_grbl(settings: GrblSettings, context: BenchContext) -> PolledStage:
    """Open the stage. Nothing moves.

    ``context.transport``, where given, is an open pyserial port or a pyserial URL, and takes the place of ``settings.port``.

    Raises:
        InputError: neither port nor transport, or limits beyond the controller's own, or one that reports in inches.
        DriverUnavailable: the port cannot be opened, or no GRBL answers.
    """
    link, version = open_link(settings, context)
    axis = GrblAxis(link, settings)
    try:
        _agree(settings, axis.read_settings())
        axis.find_offset()
        if settings.unlock and axis.status().trouble:
            link.command(UNLOCK)
    except BaseException:
        link.wire.close()
        raise
    identity = DeviceIdentity(
        name=_NAME,
        vendor="GRBL",
        model=f"axis {settings.axis}",
        firmware=version,
        driver=f"grbl 1.1, pyserial {serial.__version__}",
        simulated=context.transport is not None,
    )
    return PolledStage(
        axis,
        context.clock,
        identity=identity,
        limits=settings.limits,
        home_mm=settings.home_position_mm,
        home_profile=MotionProfile(
            velocity_mm_s=settings.max_velocity_mm_s, acceleration_mm_s2=settings.max_acceleration_mm_s2
        ),
        home_limit_s=settings.home_timeout_s,
        require_home=settings.require_home,
        poll_s=_POLL_S,
    )


def open_link(settings: GrblSettings, context: BenchContext) -> tuple[GrblLink, str]:
    """Open the line, and give it with the controller's version.

    Raises:
        InputError, DriverUnavailable: as ``open_grbl``.
    """
    wire = settings.open_wire(context, device=_NAME, longest=LONGEST)
    try:
        link = GrblLink(wire)
        try:
            return link, link.version(settings.boot_s)
        except DeviceTimeout as silence:
            raise DriverUnavailable(
                device=_NAME,
                saw=f"no GRBL on the line ({silence.saw})",
                expected="an answer to $I",
                remedy="check cable, power and baud, and that it is GRBL 1.1; reset it where a limit switch was hit",
            ) from silence
    except BaseException:
        wire.close()
        raise


def _agree(settings: GrblSettings, stored: dict[int, float]) -> None:
    """Refuse what the controller would clip or refuse later."""
    index = settings.axis_index
    highest_mm_s = stored.get(110 + index, 60 * settings.max_velocity_mm_s) / 60
    if settings.max_velocity_mm_s > highest_mm_s:
        raise InputError(
            device=_NAME,
            saw=f"max_velocity_mm_s = {settings.max_velocity_mm_s:g}",
            expected=f"at most {highest_mm_s:g}: the controller clips faster moves to ${110 + index} without a word",
            remedy="lower max_velocity_mm_s in bench.toml, or raise that setting of the controller",
        )
    if stored.get(13, 0) != 0:
        raise InputError(
            device=_NAME,
            saw="a controller that reports in inches ($13=1)",
            expected="millimetres",
            remedy="set $13=0",
        )
    low, high = settings.travel_mm
    longest_mm = stored.get(130 + index, high - low)
    if stored.get(20, 0) != 0 and high - low > longest_mm:
        raise InputError(
            device=_NAME,
            saw=f"travel_mm = [{low:g}, {high:g}]",
            expected=f"at most {longest_mm:g} mm between the two: the controller's soft limits (${130 + index})",
            remedy="correct travel_mm in bench.toml, or that setting of the controller",
        )
