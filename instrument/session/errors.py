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


class RunStopped(RunAborted):
    """A rule of the plan's ``[stop_if]`` ended the run. The notes say what is kept."""

    exit_code: ClassVar[int] = 4

    def __init__(
        self, *, rule: str, hold_s: float, frames: tuple[int, int], pattern: int, found: str, remedy: str
    ) -> None:
        """Name the rule and where it ended the run.

        Args:
            rule: its key in ``[stop_if]``.
            hold_s: how long it had to hold.
            frames: first frame in which it held, and the one after the last.
            pattern: the pattern before which the run ended, from 0.
            found: what was found in every one of these frames.
            remedy: what to do.
        """
        self.rule = rule
        self.pattern = pattern
        self.why = (
            f"stop_if.{rule} = {hold_s:g} at pattern {pattern}: frames {frames[0]} to {frames[1] - 1} have {found}"
        )
        KinopixError.__init__(
            self,
            saw=f"a run that its plan stopped ({self.why})",
            expected="a run that comes to its end",
            remedy=remedy,
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
