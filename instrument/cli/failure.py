"""How the command tells what went wrong: one clear paragraph and an exit code, for every error that has a cause."""

from instrument.views import show_error
from protocols import InputError, KinopixError, SafeStateFailed


def exit_code_of(error: Exception) -> int | None:
    """Print an error as a person reads it, and give the command's exit code for it; None for one that is a mistake of ours."""
    if isinstance(error, KinopixError):
        known = error
    elif isinstance(error, OSError | MemoryError):
        known = _in_words(error)
    else:
        return None
    show_error(known)
    return known.exit_code


def is_unsafe(error: BaseException) -> bool:
    """Whether an error says that the bench could not be made safe, which no other must hide."""
    return isinstance(error, SafeStateFailed)


def _in_words(error: OSError | MemoryError) -> KinopixError:
    """Give what the machine refused as an error of ours; the notes, which say what was kept, go along."""
    known: KinopixError
    if isinstance(error, MemoryError):
        known = InputError(
            saw=f"more memory asked for than this machine has ({error})",
            expected="a run that fits into memory",
            remedy="lower frames or image_size in plan.toml",
        )
    else:
        known = KinopixError(
            saw=f"the operating system refuse: {error}",
            expected="files and folders that can be read and written",
            remedy="check the room on the disk and the permissions",
        )
    for note in getattr(error, "__notes__", ()):
        known.add_note(note)
    return known
