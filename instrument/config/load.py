"""A TOML file into a pydantic model, with every mistake named at once."""

import tomllib
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel

ModelT = TypeVar("ModelT", bound=BaseModel)


def load_model(model: type[ModelT], path: Path) -> ModelT:
    """Read ``path`` as ``model``."""
    return model.model_validate(tomllib.loads(path.read_text()))
