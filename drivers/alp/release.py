"""Let go of several things, each even if another fails."""

from collections.abc import Callable, Iterable


def release(steps: Iterable[Callable[[], object]], because: BaseException | None = None) -> None:
    """Call every step. What fails becomes a note of ``because``, the error under way, or is raised when there is none."""
    failures: list[Exception] = []
    for step in steps:
        try:
            step()
        except Exception as error:  # noqa: BLE001 - the next step must be tried whatever this one did
            failures.append(error)
    first = because or next(iter(failures), None)
    if first is None:
        return
    for failure in failures:
        if failure is not first:
            first.add_note(f"While letting go of the device: {failure}")
    if because is None:
        raise first
