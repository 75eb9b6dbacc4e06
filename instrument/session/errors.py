"""How a run ends that was not let come to its end, and a wait that was too short."""

from typing import ClassVar

from protocols import KinopixError


class RunAborted(KinopixError):
    """The run was aborted on request. The notes say what is kept."""

    exit_code: ClassVar[int] = 130

    def __init__(self, why: str) -> None:
        """Name who wanted it."""
        self.why = why
        super().__init__(
            saw=f"an aborted run ({why})",
            expected="a run that comes to its end",
            remedy="use what is kept, or start the run again",
        )


class RunNotOver(KinopixError, TimeoutError):
    """A run was waited for, and goes on."""

    def __init__(self, *, waited_s: float, state: str, patterns_done: int, patterns_total: int) -> None:
        """Name how long it was waited for and how far the run is."""
        super().__init__(
            saw=f"a run that is {state} after {waited_s:g} s, {patterns_done} of {patterns_total} patterns counted",
            expected="the end of the run",
            remedy="wait longer, or abort the run",
        )
