"""What sub-commands over several recordings share: a bar that tells how far they are, and failures that are named at the end."""

from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from instrument.workers import Failure


@contextmanager
def told_of(recordings: int) -> "Generator[Callable[[Path, int, int], None]]":
    """Give what is called with each recording that is done; whoever interrupts is told what is kept.

    Args:
        recordings: number of all.
    """
    from instrument.views import progress

    ended = 0
    with progress() as bars:
        task = bars.add_task("recordings", total=recordings)

        def tell(path: Path, done: int, total: int) -> None:
            nonlocal ended
            ended = done
            bars.update(task, description=path.name, completed=done, total=total)

        try:
            yield tell
        except KeyboardInterrupt as interrupt:
            interrupt.add_note(f"{ended} of {recordings} recordings are done, and the same command goes on from there")
            raise


def refuse_failures(failures: "Mapping[Path, Failure]", recordings: int, done: str) -> None:
    """Name the recordings that failed, if any.

    Args:
        failures: they, and why.
        recordings: number of all.
        done: what was done with the others, such as ``analysed``.

    Raises:
        InputError: all failed by a wrong input.
        KinopixError: some failed otherwise.
    """
    from protocols import InputError, KinopixError

    if not failures:
        return
    wrong_inputs = all(failure.exit_code == InputError.exit_code for failure in failures.values())
    error = (InputError if wrong_inputs else KinopixError)(
        saw=f"{len(failures)} of {recordings} recordings that could not be {done}",
        expected=f"all {done}; the others are",
        remedy="look at the reasons below, then give the same command: it does what is missing",
    )
    for path, failure in failures.items():
        error.add_note(f"{path}: {failure.why}")
    raise error
