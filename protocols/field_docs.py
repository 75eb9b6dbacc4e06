"""What stands below each field of a value reaches ``help()``: Python itself keeps no docstring of a field."""

import ast
import dataclasses
import inspect
import textwrap
from itertools import pairwise
from typing import Any, Final, TypeVar, cast

from pydantic import BaseModel
from pydantic._internal._model_construction import ModelMetaclass

HEADING: Final = "Fields:"
"""Line of a class's docstring from which on its fields are listed."""

_WIDTH: Final = 100

ClassT = TypeVar("ClassT", bound=type)


def field_docstrings(owner: type) -> dict[str, str]:
    """Read the text below each field of a model or dataclass, and of the classes that it extends, from their source.

    Returns:
        Text by name, each in one line; without those of classes that were made in memory.
    """
    found: dict[str, str] = {}
    for cls in reversed(owner.__mro__):
        if cls is BaseModel or "__annotations__" not in vars(cls):
            continue
        try:
            source = textwrap.dedent(inspect.getsource(cls))
        except (OSError, TypeError):  # made in memory
            continue
        body = cast("ast.ClassDef", ast.parse(source).body[0]).body
        for field, below in pairwise(body):
            if (
                isinstance(field, ast.AnnAssign)
                and isinstance(field.target, ast.Name)
                and isinstance(below, ast.Expr)
                and isinstance(below.value, ast.Constant)
                and isinstance(below.value.value, str)
            ):
                found[field.target.id] = " ".join(inspect.cleandoc(below.value.value).split())
    return found


def with_fields(cls: ClassT) -> ClassT:
    """Let the docstring of a dataclass go on with its fields. They are read when somebody asks: imports stay quick."""
    type.__setattr__(cls, "__doc__", _DocWithFields(cls.__doc__ or ""))
    return cls


def own_docstring(cls: type) -> str:
    """Give the docstring of a class as it was written, without its fields."""
    kept = vars(cls).get("__doc__")
    return kept.own if isinstance(kept, _DocWithFields) else inspect.cleandoc(kept or "")


def whole_docstring(cls: type) -> str:
    """Give a class's own text, and a line or more for each field: name, default, meaning."""
    meanings, own = field_docstrings(cls), own_docstring(cls)
    lines = [
        textwrap.fill(f"{name}{default}: {meanings[name]}", _WIDTH, initial_indent=" " * 4, subsequent_indent=" " * 8)
        for name, default in _defaults(cls).items()
        if name in meanings
    ]
    return "\n".join([own, "", HEADING, *lines]) if lines else own


class ModelType(ModelMetaclass):
    """Type of models whose docstring goes on with their fields.

    ``help()`` of a class that has a type of its own asks that type, so that it is here that the docstring is made.
    """


type.__setattr__(ModelType, "__doc__", property(whole_docstring))


class _DocWithFields:
    """Stands in a dataclass for its ``__doc__``."""

    def __init__(self, own: str) -> None:
        self.own = inspect.cleandoc(own)

    def __get__(self, _: object, owner: type) -> str:
        """Give the docstring with the fields."""
        return whole_docstring(owner)


def _defaults(owner: type[Any]) -> dict[str, str]:
    """Give `` = default`` of each field by name; nothing where there is none, or one that is made anew each time."""
    if issubclass(owner, BaseModel):
        return {
            name: "" if field.is_required() or field.default_factory is not None else f" = {field.default!r}"
            for name, field in owner.model_fields.items()
        }
    fields = dataclasses.fields(owner) if dataclasses.is_dataclass(owner) else ()
    return {field.name: "" if field.default is dataclasses.MISSING else f" = {field.default!r}" for field in fields}
