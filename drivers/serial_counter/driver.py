"""Opening a serial counter: who it is, and how fast its clock is."""

from typing import Final

import serial

from drivers.h10682.counter import H10682Counter
from drivers.h10682.detector import NAME, counter_limits
from drivers.serial_counter.codec import LONGEST
from drivers.serial_counter.run import SerialRun, ask
from drivers.serial_counter.settings import SerialCounterSettings
from drivers.serial_line import LineWire, open_port
from protocols import BenchContext, DeviceIdentity, DeviceTimeout, DriverUnavailable, ProtocolViolation

_RING_BINS: Final = 8192
"""Bins that the example firmware keeps; what the line holds comes on top."""


def open_serial_counter(settings: SerialCounterSettings, context: BenchContext) -> H10682Counter:
    """Open the counter, and stop what a program before may have armed.

    ``context.transport``, where given, is an open pyserial port or a pyserial URL, and takes the place of ``settings.port``.

    Raises:
        InputError: neither port nor transport.
        DriverUnavailable: the port cannot be opened, or nobody answers.
        ProtocolViolation: an answer without the rate of its clock.
    """
    port = open_port(settings.port, context.transport, device=NAME, table="counter", baud=settings.baud)
    try:
        port.reset_input_buffer()
        wire = LineWire(
            port,
            context.clock,
            device=NAME,
            baud=settings.baud,
            longest=LONGEST,
            margin_s=settings.reply_margin_s,
            poll_s=settings.poll_s,
        )
        try:
            wire.put(b"\n")  # ends what another program may have left half said
            ask(wire, "stopped", "stop")
            who = ask(wire, "id", "id")
        except DeviceTimeout as silence:
            raise DriverUnavailable(
                device=NAME,
                saw=f"no serial counter on the line ({silence.saw})",
                expected="answers by the protocol of docs/reference/serial-counter.md",
                remedy="check the port's name, the cable, and that the firmware is on the board",
            ) from silence
        if len(who) != 4 or not who[3].isdigit() or int(who[3]) == 0:
            raise ProtocolViolation(
                device=NAME,
                saw=f"an id of {','.join(who)!r}",
                expected="vendor, model, firmware and the rate of the clock in Hz",
                remedy="see that the firmware keeps the protocol of docs/reference/serial-counter.md",
            )
    except BaseException:
        port.close()
        raise
    vendor, model, firmware, ticks_hz = who
    identity = DeviceIdentity(
        name=NAME,
        vendor=vendor,
        model=f"{model} with {settings.head.model}",
        firmware=firmware,
        driver=f"serial-counter, pyserial {serial.__version__}",
        simulated=context.transport is not None,
    )
    limits = counter_limits(
        settings.head,
        counter_dead_time_s=settings.counter_dead_time_s,
        max_sync_rate_hz=settings.max_sync_rate_hz,
        edge_time_resolution_s=1 / int(ticks_hz),
        max_unread_bins=_RING_BINS,
    )
    return H10682Counter(
        identity, limits, lambda run: SerialRun(run, wire, int(ticks_hz), context.clock), close=wire.close
    )
