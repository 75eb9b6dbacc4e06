"""DAQmx errors as the emulated board gives them: codes of the sheet (h10682-daq.md 4.5) with sentences of our own."""

from typing import Literal, TypeAlias

Manner: TypeAlias = Literal["metadata", "bare", "status"]
"""How the server tells of a failed read; see ``ReadFault.give``."""

SAMPLES_NOT_YET_AVAILABLE = -200284
SAMPLES_NO_LONGER_AVAILABLE = -200279
SAMPLES_WILL_NEVER_BE_AVAILABLE = -200278
STOPPED_TO_PREVENT_OVERWRITE = -200222
CI_OVERRUN = -201314
EXT_SAMP_CLK_SRC_NOT_SPECIFIED = -200303
PAUSE_TRIGGER_AND_SAMPLE_CLOCK = -200145
MULTIPLE_COUNTER_INPUT_TASK = -200147
PHYSICAL_CHAN_DOES_NOT_EXIST = -200170
INVALID_DEVICE_ID = -200220
RESOURCE_RESERVED = -50103
ROUTE_NOT_SUPPORTED = -89136
INVALID_TERMINAL = -89120
INVALID_ATTRIBUTE_VALUE = -200077
INVALID_TASK = -200088
DUPLICATE_TASK = -200089
WAIT_IS_OVER = -200560
NO_CHANNELS = -200478
TASK_IS_RUNNING = -200479
ATTRIBUTE_NOT_SUPPORTED = -200452
ABORTED = -88709

_TEXTS = {
    SAMPLES_NOT_YET_AVAILABLE: "Not all of the samples came in time; with external timing, perhaps no clock came.",
    SAMPLES_NO_LONGER_AVAILABLE: "The samples were overwritten before they were read.",
    SAMPLES_WILL_NEVER_BE_AVAILABLE: "The read goes beyond the end of the acquisition.",
    STOPPED_TO_PREVENT_OVERWRITE: "The acquisition stopped, as it would have overwritten unread samples.",
    -200361: "The onboard memory overflowed.",
    -200010: "The input FIFO overflowed.",
    -209829: "The input FIFO overflowed.",
    -200141: "Counter data was overwritten before the system read it.",
    CI_OVERRUN: "More than one sample clock pulse came within one period of the input signal.",
    -201313: "The counter timebase was not periodic; the counter was reset.",
    -200140: "Two gate edges came without a timebase edge between them.",
    -200313: "The external clock is out of specification.",
    -200314: "The external clock was lost.",
    EXT_SAMP_CLK_SRC_NOT_SPECIFIED: "Buffered edge counting needs an external sample clock.",
    PAUSE_TRIGGER_AND_SAMPLE_CLOCK: "A pause trigger and a sample clock exclude each other for edge counting.",
    MULTIPLE_COUNTER_INPUT_TASK: "A task takes one counter only.",
    PHYSICAL_CHAN_DOES_NOT_EXIST: "There is no such physical channel.",
    INVALID_DEVICE_ID: "There is no device of that name.",
    -201003: "The device cannot be accessed.",
    -200324: "The device is absent or unavailable.",
    -200022: "The resource is reserved already.",
    RESOURCE_RESERVED: "The resource is reserved.",
    -89137: "A line is in use by another route.",
    ROUTE_NOT_SUPPORTED: "The hardware has no such route.",
    INVALID_TERMINAL: "There is no source terminal of that name.",
    INVALID_ATTRIBUTE_VALUE: "The value is not supported by this device.",
    INVALID_TASK: "There is no such task.",
    DUPLICATE_TASK: "There is a task of that name already.",
    -200474: "The operation did not end in time.",
    WAIT_IS_OVER: "The task was not done when the wait ended.",
    NO_CHANNELS: "The task has no channel.",
    TASK_IS_RUNNING: "This cannot be done while the task runs.",
    ATTRIBUTE_NOT_SUPPORTED: "The attribute is not supported here.",
    ABORTED: "The task was stopped during the call.",
    -88710: "The task is being stopped.",
    -201025: "A hardware-timed task needs a buffer.",
}


def text_of(code: int) -> str:
    """A sentence for an error code; any code has one."""
    return f"{_TEXTS.get(code, 'An error.')}\n\nStatus Code: {code}"


class NiError(Exception):
    """A call that fails with a DAQmx status."""

    def __init__(self, code: int, *, manner: Manner = "bare") -> None:
        """Keep the code and how the server tells of it: ``metadata`` adds that no sample was read."""
        self.code = code
        self.manner: Manner = manner
        super().__init__(text_of(code))


class ServerGone(Exception):
    """The server dies in the middle of this call."""
