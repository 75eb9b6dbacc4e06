"""A table of a TOML file against a pydantic model: what pydantic found wrong, as problems with a place and a suggestion."""

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

_LONGEST = 60
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

    Validation is strict, by the rules for JSON: the text "25" is no number, 1666.0 is no whole number.

    Args:
        model: what the table should be.
        values: the keys that are meant for the model.
        document: where they stand.
        table: path of the table.
        reserved: keys of the same table that belong to somebody else; they serve as suggestions only.

    Returns:
        The model and no problems, or None and all of them.
    """
    try:
        return model.model_validate_json(json.dumps(values, default=str), strict=True), []
    except ValidationError as error:
        place = _Place(model, document, table, tuple(reserved))
        found = sorted(map(dict, error.errors(include_url=False, include_input=False)), key=place.line)
        return None, _merged([place.problem(detail, told=k < MOST_TOLD) for k, detail in enumerate(found)])


@dataclass(frozen=True)
class _Place:
    """The table that is being checked."""

    model: type[BaseModel]
    document: Document
    table: KeyPath
    reserved: tuple[str, ...]

    def line(self, detail: dict[str, Any]) -> int:
        """Where one of pydantic's findings stands; 0 for the whole file."""
        return self.document.line_of((*self.table, *detail["loc"])) or 0

    def problem(self, detail: dict[str, Any], *, told: bool) -> Problem:
        """One of pydantic's findings, with its place and, where it will be ``told``, what to do about it."""
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
        value, context = self.value(path), detail.get("ctx", {})
        choices = str(context.get("expected_tags") or context.get("expected") or "")
        suggestion = suggest_value(value, re.findall(r"'([^']*)'", choices)) if isinstance(value, str) else ""
        if "expected_tags" in context:
            return _shown(value), f"one of {choices}", suggestion
        return _shown(value), _expected(str(detail["msg"])), suggestion

    def broken_rule(self, path: KeyPath, message: str) -> tuple[KeyPath, str, str, str]:
        """A validator of the model's own; its message may begin with the key that it is about."""
        message = message.removeprefix("Value error, ")
        about = tuple(message.split(maxsplit=1)[0].split("."))
        if self.value((*path, *about)) is not None:
            path = (*path, *about)
        return path, _shown(self.value(path)), "another value", message

    def unknown_key(self, path: KeyPath) -> tuple[str, str, str]:
        known = [*fields_at(self.model, path[:-1]), *(self.reserved if len(path) == 1 else ())]
        present = set(self.keys_beside(path))
        # A key that is there already cannot be what was meant, unless nothing else is near.
        suggestion = suggest_key(str(path[-1]), [key for key in known if key not in present] or known)
        return "an unknown key", f"one of {', '.join(known)}" if known else "no key here", suggestion

    def missing_key(self, path: KeyPath) -> tuple[str, str, str]:
        name, known = str(path[-1]), fields_at(self.model, path[:-1])
        near = [key for key in self.keys_beside(path) if key not in known and suggest_key(key, [name])]
        return "nothing", f"a value for {name}", f"is {near[0]} meant to be {name}?" if near else ""

    def value(self, path: KeyPath) -> object:
        return self.document.at((*self.table, *path))

    def keys_beside(self, path: KeyPath) -> list[str]:
        beside = self.value(path[:-1])
        return [str(key) for key in cast("dict[str, Any]", beside)] if isinstance(beside, dict) else []

    def real_path(self, detail: dict[str, Any]) -> KeyPath:
        """Path of the mistake in the file: without the names that pydantic puts in for the members of a union."""
        kind, parts = str(detail["type"]), tuple[str | int, ...](detail["loc"])
        if kind.startswith("union_tag"):
            # The key that tells the members apart is what is wrong, not the table it stands in.
            parts = (*parts, str(detail["ctx"]["discriminator"]).strip("'"))
        path: KeyPath = ()
        for depth, part in enumerate(parts, 1):
            names_a_key = depth == len(parts) and kind in {"missing", "extra_forbidden", "union_tag_not_found"}
            if names_a_key or self.value((*path, part)) is not None:
                path = (*path, part)
        return path


def fields_at(model: type[BaseModel], path: KeyPath) -> list[str]:
    """Keys that ``model`` knows in the table at ``path``, of all members where that is a union."""
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
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for inner in get_args(annotation) for model in _models_in(inner)]


def _expected(message: str) -> str:
    """Pydantic's sentence without its first words, in the words of TOML."""
    for opening in ("Input should be ", "Assertion failed, "):
        if message.startswith(opening):
            message = message.removeprefix(opening)
            return _IN_TOML.get(message, message)
    return message[:1].lower() + message[1:]


def _shown(value: object) -> str:
    if isinstance(value, dict):
        return "this table"
    text = json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."


def _merged(problems: list[Problem]) -> list[Problem]:
    """One problem a key: pydantic names each member of a union that did not fit."""
    by_key: dict[tuple[str, str], Problem] = {}
    for problem in problems:
        earlier = by_key.get((problem.key, problem.saw))
        if earlier is None:
            by_key[problem.key, problem.saw] = problem
        elif problem.expected not in earlier.expected:
            both = f"{earlier.expected}, or {problem.expected}"
            by_key[problem.key, problem.saw] = replace(earlier, expected=both)
    return list(by_key.values())
