"""Opening a Zaber stage: who it is, and whether bench.toml and the controller agree on where it may go."""

from typing import Final

import serial

from drivers.polled_stage import PolledStage
from drivers.zaber.axis import ZaberAxis
from drivers.zaber.codec import LONGEST
from drivers.zaber.settings import ZaberSettings
from protocols import BenchContext, DeviceIdentity, DeviceTimeout, DriverUnavailable, InputError

_NAME: Final = "stage"


def open_zaber(settings: ZaberSettings, context: BenchContext) -> PolledStage:
    """Open the stage. Nothing moves.

    ``context.transport``, where given, is an open pyserial port or a pyserial URL, and takes the place of ``settings.port``.

    Raises:
        InputError: neither port nor transport, or ``travel_mm`` beyond the controller's own limits.
        DriverUnavailable: the port cannot be opened, or no Zaber controller answers.
    """
    axis, version = open_axis(settings, context)
    try:
        device_id = axis.query("get deviceid").value.data
        _check_travel(settings, axis)
    except BaseException:
        axis.close()
        raise
    identity = DeviceIdentity(
        name=_NAME,
        vendor="Zaber",
        model=f"device {device_id}, axis {settings.axis}",
        firmware=version,
        driver=f"zaber (ASCII), pyserial {serial.__version__}",
        simulated=context.transport is not None,
    )
    return PolledStage(
        axis,
        context.clock,
        identity=identity,
        limits=settings.limits,
        home_mm=settings.home_position_mm,
        home_profile=settings.home_profile,
        home_limit_s=settings.home_timeout_s,
        require_home=settings.require_home,
    )


def open_axis(settings: ZaberSettings, context: BenchContext) -> tuple[ZaberAxis, str]:
    """Open the line, and give the axis with its firmware.

    Raises:
        InputError, DriverUnavailable: as ``open_zaber``.
    """
    wire = settings.open_wire(context, device=_NAME, longest=LONGEST)
    try:
        wire.clear()
        axis = ZaberAxis(wire, settings)
        try:
            return axis, axis.query("get version").value.data
        except DeviceTimeout as silence:
            raise DriverUnavailable(
                device=_NAME,
                saw=f"no Zaber controller as device {settings.device} ({silence.saw})",
                expected="a reply in the ASCII protocol",
                remedy="check cable, power, device and baud in bench.toml, and that the protocol is ASCII, not binary",
            ) from silence
    except BaseException:
        wire.close()
        raise


def _check_travel(settings: ZaberSettings, axis: ZaberAxis) -> None:
    low, high = (
        float(axis.query(f"get limit.{end}").value.data) / settings.microsteps_per_mm for end in ("min", "max")
    )
    ours_low, ours_high = settings.travel_mm
    if ours_low < low - axis.tolerance_mm or ours_high > high + axis.tolerance_mm:
        raise InputError(
            device=_NAME,
            saw=f"travel_mm = [{ours_low:g}, {ours_high:g}]",
            expected=f"within the controller's own limits, {low:g} to {high:g} mm by microsteps_per_mm",
            remedy="correct travel_mm or microsteps_per_mm in the [stage] table of bench.toml",
        )
