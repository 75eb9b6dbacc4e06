"""What each NI-DAQmx error code means for this bench, and what the person at the bench does about it.

Codes and names are NI's (``nidaqmx.error_codes``); the meanings follow the fact sheet h10682-daq, section 4.5. A code that is not
in the table is passed on as ``DeviceRefused`` with NI's own text.
"""

from dataclasses import dataclass
from enum import Enum, auto

from protocols import (
    CounterOverrun,
    DeviceBusy,
    DeviceDisconnected,
    DeviceRefused,
    DeviceTimeout,
    DriverUnavailable,
    KinopixError,
    TimingFault,
    TriggerMissed,
)

NOT_YET_AVAILABLE = -200284
"""Fewer samples than asked for. To a poll that waits on its own clock it is an answer, not a fault."""

RPC_UNAVAILABLE = "UNAVAILABLE"
"""gRPC status of a server that is not there or no longer there."""


class NiFault(Exception):
    """What came back from NI-DAQmx instead of an answer."""

    def __init__(self, text: str, code: int | None = None, *, rpc_code: str = "", samples_read: int = 0) -> None:
        """Keep NI's words.

        Args:
            text: NI's message.
            code: DAQmx error code; None where the failure lies below DAQmx.
            rpc_code: name of the gRPC status code, where the failure is the connection's.
            samples_read: samples that came before the failure of a read.
        """
        super().__init__(text)
        self.text = " ".join(text.split()).rstrip(".")
        self.code = code
        self.rpc_code = rpc_code
        self.samples_read = samples_read


@dataclass(frozen=True)
class Progress:
    """How far the run had come when NI answered with an error."""

    bins_read: int = 0
    bins_expected: int = 0
    waited_s: float = 0.0


class Kind(Enum):
    """Which branch of the error tree a code belongs to."""

    MISSED = auto()
    OVERRUN = auto()
    SYNC = auto()
    ABSENT = auto()
    GONE = auto()
    BUSY = auto()
    TIMEOUT = auto()
    CONFIG = auto()


@dataclass(frozen=True)
class Meaning:
    """One row of the table."""

    name: str
    kind: Kind
    saw: str
    remedy: str


_FASTER_HOST = "raise buffer_s or latency_s, and keep the computer free of other work during a run"
_FIFO = "lower pattern_rate_hz, or put the board on PCIe or its own USB port; then record again"
_SYNC = "look at the sync line on an oscilloscope; set its width well above sync_filter_s and keep SynchDelay at 0"
_ROUTE = "choose a PFI line that this counter can be routed to (NI MAX, device routes), and correct it in bench.toml"
_BUG = "report this with the whole message: the driver asked for something that it never should"
_NAME = (
    "compare device and counter in bench.toml with the names that NI MAX (or `nilsdev`) shows, and look at the cable"
)
_CABLE = "look at the board's cable and power, then open the bench again"
_FREE = "close the other program or task that uses this counter or line, then try again"
_CAPABLE = "use a board that counts edges on an external sample clock (an X-series board does)"

MEANINGS: dict[int, Meaning] = {
    -200284: Meaning("SAMPLES_NOT_YET_AVAILABLE", Kind.MISSED, "fewer sync edges than expected", _SYNC),
    -200279: Meaning("SAMPLES_NO_LONGER_AVAILABLE", Kind.OVERRUN, "unread samples overwritten", _FASTER_HOST),
    -200222: Meaning(
        "ACQ_STOPPED_TO_PREVENT_INPUT_BUFFER_OVERWRITE", Kind.OVERRUN, "the host's buffer full", _FASTER_HOST
    ),
    -200278: Meaning("SAMPLES_WILL_NEVER_BE_AVAILABLE", Kind.CONFIG, "a read past the end of a stopped task", _BUG),
    -200361: Meaning("INPUT_FIFO_OVERFLOW_2", Kind.OVERRUN, "the board's own memory full", _FIFO),
    -200010: Meaning("INPUT_FIFO_OVERFLOW", Kind.OVERRUN, "the board's own memory full", _FIFO),
    -209829: Meaning("INPUT_FIFO_OVERFLOW_3", Kind.OVERRUN, "the board's own memory full", _FIFO),
    -200141: Meaning("COUNTER_OVERFLOW", Kind.OVERRUN, "a sample overwritten before the host read it", _FIFO),
    -201314: Meaning("CI_OVERRUN", Kind.SYNC, "several sync edges within one period of the input signal", _SYNC),
    -201313: Meaning(
        "COUNTER_NON_RESPONSIVE_AND_RESET", Kind.CONFIG, "an aperiodic signal used as the counter's timebase", _BUG
    ),
    -200140: Meaning(
        "COUNTER_NO_TIMEBASE_EDGES_BETWEEN_GATES",
        Kind.CONFIG,
        "two sync edges without a timebase edge between them",
        "correct timebase in bench.toml",
    ),
    -200313: Meaning("STREAM_DCM_LOCK", Kind.SYNC, "a sync signal out of the board's specification", _SYNC),
    -200314: Meaning("STREAM_DCM_BECAME_UNLOCKED", Kind.SYNC, "a sync signal that changed its rate", _SYNC),
    -200303: Meaning(
        "EXT_SAMP_CLK_SRC_NOT_SPECIFIED", Kind.CONFIG, "no sample clock", "set sync_terminal in bench.toml"
    ),
    -200145: Meaning(
        "COUNTER_INPUT_PAUSE_TRIGGER_AND_SAMPLE_CLOCK_INVALID", Kind.CONFIG, "a pause trigger with a clock", _BUG
    ),
    -200147: Meaning("MULTIPLE_COUNTER_INPUT_TASK", Kind.CONFIG, "two counters in one task", _BUG),
    -200170: Meaning("PHYSICAL_CHAN_DOES_NOT_EXIST", Kind.ABSENT, "no such counter", _NAME),
    -200220: Meaning("INVALID_DEVICE_ID", Kind.ABSENT, "no such device", _NAME),
    -201003: Meaning("DEV_CANNOT_BE_ACCESSED", Kind.GONE, "a board that does not answer", _CABLE),
    -200324: Meaning("DEV_ABSENT_OR_UNAVAILABLE", Kind.GONE, "a board that is absent", _CABLE),
    -200022: Meaning("RESOURCE_ALREADY_RESERVED", Kind.BUSY, "a counter that another task holds", _FREE),
    -50103: Meaning("PAL_RESOURCE_RESERVED", Kind.BUSY, "a counter that another program holds", _FREE),
    -89137: Meaning("RESOURCES_IN_USE_FOR_ROUTE_ROUTING", Kind.BUSY, "a line that another task uses", _FREE),
    -89136: Meaning("ROUTE_NOT_SUPPORTED_BY_HW_ROUTING", Kind.CONFIG, "a line that cannot reach the counter", _ROUTE),
    -89120: Meaning("INVALID_ROUTING_SOURCE_TERMINAL_NAME_ROUTING", Kind.CONFIG, "no such line", _ROUTE),
    -200077: Meaning("INVALID_ATTRIBUTE_VALUE", Kind.CONFIG, "a setting that this board does not have", _CAPABLE),
    -200089: Meaning("DUPLICATE_TASK", Kind.CONFIG, "two tasks of one name", _BUG),
    -200474: Meaning("OPERATION_TIMED_OUT", Kind.TIMEOUT, "no end of the operation", _CABLE),
    -200560: Meaning("WAIT_UNTIL_DONE_DOES_NOT_INDICATE_DONE", Kind.TIMEOUT, "a task that is not done", _SYNC),
    -201025: Meaning("NON_BUFFERED_AND_HW_TIMED", Kind.CONFIG, "hardware timing without a buffer", _BUG),
    -88709: Meaning("RUNTIME_ABORTED_ROUTING", Kind.GONE, "the task aborted from outside", _CABLE),
    -88710: Meaning("RUNTIME_ABORTING_ROUTING", Kind.GONE, "the task being aborted from outside", _CABLE),
}
"""Every code of the fact sheet."""


def typed_error(fault: NiFault, *, device: str, progress: Progress | None = None) -> KinopixError:
    """Say what an NI error means here: the returned error is for the caller to raise or to keep."""
    done = progress or Progress()
    if fault.code is None:
        return _below_daqmx(fault, device)
    meaning = MEANINGS.get(fault.code)
    if meaning is None:
        return DeviceRefused(
            device,
            code=str(fault.code),
            saw=f"NI-DAQmx saying {fault.text!r}",
            expected="a counter that accepts its settings and runs",
            remedy="look the code up in NI's documentation; correct the [counter] table of bench.toml",
        )
    return _by_kind(fault.code, meaning, device, done)


def _by_kind(code: int, meaning: Meaning, device: str, done: Progress) -> KinopixError:
    saw = f"{meaning.saw} ({meaning.name}, code {code})"
    so_far = f"{done.bins_read} bins counted"
    match meaning.kind:
        case Kind.MISSED:
            return TriggerMissed(
                device, bins_read=done.bins_read, bins_expected=done.bins_expected, waited_s=done.waited_s
            )
        case Kind.OVERRUN:
            return CounterOverrun(
                device=device, saw=f"{saw}, {so_far}", expected="every sample read in time", remedy=meaning.remedy
            )
        case Kind.SYNC:
            return TimingFault(
                device=device, saw=f"{saw}, {so_far}", expected="one clean sync edge a pattern", remedy=meaning.remedy
            )
        case Kind.ABSENT:
            return DriverUnavailable(device=device, saw=saw, expected="the board of bench.toml", remedy=meaning.remedy)
        case Kind.GONE:
            return DeviceDisconnected(
                device=device, saw=f"{saw}, {so_far}", expected="a board that answers", remedy=meaning.remedy
            )
        case Kind.BUSY:
            return DeviceBusy(device=device, saw=saw, expected="a free counter", remedy=meaning.remedy)
        case Kind.TIMEOUT:
            return DeviceTimeout(
                device,
                awaited="the end of the operation",
                waited_s=done.waited_s,
                progress=f"{saw}, {so_far}",
                remedy=meaning.remedy,
            )
        case Kind.CONFIG:
            return DeviceRefused(
                device, code=str(code), saw=f"{meaning.saw}, {meaning.name}", expected="settings that the board takes",
                remedy=meaning.remedy,
            )  # fmt: skip


def _below_daqmx(fault: NiFault, device: str) -> KinopixError:
    if fault.rpc_code:
        gone = fault.rpc_code == RPC_UNAVAILABLE
        kind = DeviceDisconnected if gone else DriverUnavailable
        return kind(
            device=device,
            saw=f"gRPC status {fault.rpc_code}: {fault.text}",
            expected="a NI gRPC device server that answers",
            remedy="start the server, or look at the network between here and it",
        )
    return DriverUnavailable(
        device=device,
        saw=fault.text,
        expected="the NI-DAQmx runtime and the nidaqmx package",
        remedy="install NI-DAQmx from ni.com, and the package with: pip install 'kinopix[ni]'",
    )
