"""A TOML file into a pydantic model, with every mistake named at once."""

from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel

from instrument.config.check import validate_table
from instrument.config.document import read_document
from instrument.config.errors import ConfigError

ModelT = TypeVar("ModelT", bound=BaseModel)


def load_model(model: type[ModelT], path: Path) -> ModelT:
    """Read ``path`` as ``model``.

    Raises:
        ConfigError: no such file, no TOML, or values that the model does not take: every mistake, each with its line, what
            was seen, what was expected and, where one is near, what was probably meant.
    """
    document = read_document(path)
    value, problems = validate_table(model, document.values, document)
    if value is None:
        raise ConfigError(path, problems)
    return value
