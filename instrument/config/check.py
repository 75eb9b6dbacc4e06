"""Validation of a table of a TOML file by a pydantic model: each mistake becomes a problem with a line and a suggestion."""

import json
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, TypeVar, cast, get_args

from pydantic import BaseModel, ValidationError

from instrument.config.document import Document
from instrument.config.errors import MOST_TOLD, Problem
from instrument.config.positions import KeyPath
from instrument.config.suggest import suggest_key, suggest_value

ModelT = TypeVar("ModelT", bound=BaseModel)

_LONGEST = 60  # characters of a value that are shown
_IN_TOML = {
    "an object": "a table",
    "a valid array": "a list",
    "a valid string": "text in quotes",
    "a valid integer": "a whole number",
    "a valid number": "a number",
    "a valid boolean": "true or false",
}


def validate_table(
    model: type[ModelT],
    values: dict[str, Any],
    document: Document,
    table: KeyPath = (),
    reserved: Iterable[str] = (),
) -> tuple[ModelT | None, list[Problem]]:
    """Validate ``values``, which stand in ``table`` of ``document``.

    Validation is strict and follows the rules for JSON: the text "25" is no number, and 1666.0 is no whole number.

    Args:
        model: model that the table should fit.
        values: keys and values of the table that the model should take.
        document: file that holds the table.
        table: path of the table.
        reserved: keys of the same table that another model takes; they are used for suggestions only.

    Returns:
        The model and no problems, or None and all problems.
    """
    try:
        return model.model_validate_json(json.dumps(values, default=str), strict=True), []
    except ValidationError as error:
        place = _Place(model, document, table, tuple(reserved))
        found = sorted(map(dict, error.errors(include_url=False, include_input=False)), key=place.line)
        return None, _merged([place.problem(detail, told=k < MOST_TOLD) for k, detail in enumerate(found)])


@dataclass(frozen=True)
class _Place:
    """The table that is being validated."""

    model: type[BaseModel]
    """Model that the table should fit."""

    document: Document
    """File that holds the table."""

    table: KeyPath
    """Path of the table."""

    reserved: tuple[str, ...]
    """Keys of the table that another model takes."""

    def line(self, detail: dict[str, Any]) -> int:
        """Give the line on which one of pydantic's errors stands; 0 for the whole file."""
        return self.document.line_of((*self.table, *detail["loc"])) or 0

    def problem(self, detail: dict[str, Any], *, told: bool) -> Problem:
        """Give one of pydantic's errors as a problem, with a suggestion where it will be ``told``."""
        path, kind = self.real_path(detail), str(detail["type"])
        if kind == "extra_forbidden":
            saw, expected, suggestion = self.unknown_key(path) if told else ("an unknown key", "no key here", "")
        elif kind in {"missing", "union_tag_not_found"}:
            saw, expected, suggestion = self.missing_key(path)
        elif kind == "value_error":
            path, saw, expected, suggestion = self.broken_rule(path, str(detail["msg"]))
        else:
            saw, expected, suggestion = self.bad_value(path, detail)
        where = (*self.table, *path)
        key = ".".join(str(part) for part in where)
        return Problem(self.document.path, self.document.line_of(where), key, saw, expected, suggestion)

    def bad_value(self, path: KeyPath, detail: dict[str, Any]) -> tuple[str, str, str]:
        """Say what was seen, expected and probably meant where a value does not fit."""
        value, context = self.value(path), detail.get("ctx", {})
        choices = str(context.get("expected_tags") or context.get("expected") or "")
        suggestion = suggest_value(value, re.findall(r"'([^']*)'", choices)) if isinstance(value, str) else ""
        if "expected_tags" in context:
            return _shown(value), f"one of {choices}", suggestion
        return _shown(value), _expected(str(detail["msg"])), suggestion

    def broken_rule(self, path: KeyPath, message: str) -> tuple[KeyPath, str, str, str]:
        """Say the same, and the path, where a validator of the model raised; its message may begin with the key concerned."""
        message = message.removeprefix("Value error, ")
        about = tuple(message.split(maxsplit=1)[0].split("."))
        if self.value((*path, *about)) is not None:
            path = (*path, *about)
        return path, _shown(self.value(path)), "another value", message

    def unknown_key(self, path: KeyPath) -> tuple[str, str, str]:
        """Say what was seen, expected and probably meant where the model does not know the key."""
        known = [*fields_at(self.model, path[:-1]), *(self.reserved if len(path) == 1 else ())]
        present = set(self.keys_beside(path))
        # A key that the table already has is probably not what was meant, unless it is the only one that is similar.
        suggestion = suggest_key(str(path[-1]), [key for key in known if key not in present] or known)
        return "an unknown key", f"one of {', '.join(known)}" if known else "no key here", suggestion

    def missing_key(self, path: KeyPath) -> tuple[str, str, str]:
        """Say what was seen, expected and probably meant where a key is missing."""
        name, known = str(path[-1]), fields_at(self.model, path[:-1])
        near = [key for key in self.keys_beside(path) if key not in known and suggest_key(key, [name])]
        return "nothing", f"a value for {name}", f"is {near[0]} meant to be {name}?" if near else ""

    def value(self, path: KeyPath) -> object:
        """Give the value at a path in the table; None where there is none."""
        return self.document.at((*self.table, *path))

    def keys_beside(self, path: KeyPath) -> list[str]:
        """List the keys that the file has beside the one at a path, itself included."""
        beside = self.value(path[:-1])
        return [str(key) for key in cast("dict[str, Any]", beside)] if isinstance(beside, dict) else []

    def real_path(self, detail: dict[str, Any]) -> KeyPath:
        """Give the path of an error in the file, without the names that pydantic inserts for the members of a union."""
        kind, parts = str(detail["type"]), tuple[str | int, ...](detail["loc"])
        if kind.startswith("union_tag"):
            # The mistake is in the key that tells the members apart, and not in its table.
            parts = (*parts, str(detail["ctx"]["discriminator"]).strip("'"))
        path: KeyPath = ()
        for depth, part in enumerate(parts, 1):
            names_a_key = depth == len(parts) and kind in {"missing", "extra_forbidden", "union_tag_not_found"}
            if names_a_key or self.value((*path, part)) is not None:
                path = (*path, part)
        return path


def fields_at(model: type[BaseModel], path: KeyPath) -> list[str]:
    """List the keys that ``model`` knows in the table at ``path``; where that is a union, those of all its members."""
    models = [model]
    for key in path:
        if isinstance(key, str):
            models = [
                inner
                for outer in models
                for name, field in outer.model_fields.items()
                if key == (field.alias or name)
                for inner in _models_in(field.annotation)
            ]
    names = [field.alias or name for each in models for name, field in each.model_fields.items()]
    return list(dict.fromkeys(names))


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    """List the models that an annotation names, such as the members of a union."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for inner in get_args(annotation) for model in _models_in(inner)]


def _expected(message: str) -> str:
    """Give pydantic's message without its first words, in the terms of TOML."""
    for opening in ("Input should be ", "Assertion failed, "):
        if message.startswith(opening):
            message = message.removeprefix(opening)
            return _IN_TOML.get(message, message)
    return message[:1].lower() + message[1:]


def _shown(value: object) -> str:
    """Write a value as it is shown in a message, shortened where it is long."""
    if isinstance(value, dict):
        return "this table"
    text = json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."


def _merged(problems: list[Problem]) -> list[Problem]:
    """Merge problems of the same key, as pydantic reports each member of a union that did not fit."""
    by_key: dict[tuple[str, str], Problem] = {}
    for problem in problems:
        earlier = by_key.get((problem.key, problem.saw))
        if earlier is None:
            by_key[problem.key, problem.saw] = problem
        elif problem.expected not in earlier.expected:
            both = f"{earlier.expected}, or {problem.expected}"
            by_key[problem.key, problem.saw] = replace(earlier, expected=both)
    return list(by_key.values())
