"""The log of a command: what it was asked, what it said, and what a run told, with the time of each."""

import logging
import shlex
import sys
import time
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Final

_LOGGERS: Final = ("kinopix", "drivers", "sim_backends", "instrument", "uvicorn")
FORMAT: Final = "%(asctime)s.%(msecs)03dZ %(levelname)s %(name)s: %(message)s"


def begin_log(path: Path | None, arguments: Sequence[str] | None, *, verbose: bool) -> None:
    """Append to a log from now on, or to standard error where ``verbose`` alone is asked for; begin with the command's arguments.

    Times are UTC. What comes many times a second (blocks of counts, images), and the lines of libraries below warnings, are
    logged where ``verbose``.

    Raises:
        InputError: the file cannot be written.
    """
    from protocols import InputError

    try:
        handler = logging.StreamHandler() if path is None else logging.FileHandler(path, encoding="utf-8")
    except OSError as error:
        raise InputError(
            saw=f"the log {path}, which cannot be written: {error.strerror}",
            expected="a file in a folder that is there",
            remedy="name another file",
        ) from error
    formatter = logging.Formatter(FORMAT, datefmt="%Y-%m-%dT%H:%M:%S")
    formatter.converter = time.gmtime
    handler.setFormatter(formatter)
    for name in _LOGGERS:
        logger = logging.getLogger(name)
        logger.setLevel(logging.DEBUG if verbose else logging.INFO)
        logger.propagate = False
        logger.addHandler(handler)
    logging.getLogger(_LOGGERS[0]).info("kinopix %s: %s", version("kinopix"), shlex.join(arguments or ()))


def log_beside(recording: Path, arguments: Sequence[str] | None) -> None:
    """Log into the file of a recording's name that ends with ``.log``, beside whatever ``--log`` and ``--verbose`` ask for.

    Raises:
        InputError: as ``begin_log``.
    """
    log = recording.with_suffix(".log")
    if log == recording:  # a recording may be called anything
        log = recording.with_name(f"{recording.name}.log")
    begin_log(log, arguments, verbose=logging.getLogger(_LOGGERS[0]).level == logging.DEBUG)


def end_log(code: int | None) -> None:
    """Say how the command ended, and close the log; nothing happens where none was begun.

    Args:
        code: exit code; None where an error of ours, or an interrupt, goes on its way.
    """
    kinopix = logging.getLogger(_LOGGERS[0])
    if not any(_kept(handler) for handler in kinopix.handlers):
        return
    kinopix.info("ended with exit code %s", code, exc_info=sys.exc_info()[0] is not None)
    for name in _LOGGERS:
        logger = logging.getLogger(name)
        for handler in filter(_kept, tuple(logger.handlers)):
            logger.removeHandler(handler)
            handler.close()
        logger.propagate = True
        logger.setLevel(logging.NOTSET)


def _kept(handler: logging.Handler) -> bool:
    """Whether a handler keeps anything."""
    return not isinstance(handler, logging.NullHandler)
