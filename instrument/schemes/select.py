"""The one place where a plan's scheme name becomes a scheme."""

import inspect
from functools import lru_cache
from typing import TypeGuard

from instrument.config import PluginBroken, find_plugin, scheme_plugin
from instrument.plan import ABOUT_THE_RUN, Plan, refuse_no_plan
from instrument.schemes.scheme import Scheme
from protocols import KinopixError


def scheme_of(plan: Plan) -> Scheme:
    """Give the scheme that ``plan`` names; the same one for equal plans, so that its patterns are synthesised once.

    Raises:
        InputError: ``plan`` is no plan.
        PluginMissing: the scheme is not installed.
        PluginBroken: what is installed under its name fails, is no scheme, or does not have the patterns that its settings
            state.
    """
    refuse_no_plan(plan)
    return _made(_Key(plan))


class _Key:
    """A plan, compared by what it shows."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._text = plan.model_dump_json(exclude=set(ABOUT_THE_RUN))

    def __hash__(self) -> int:
        return hash(self._text)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and self._text == other._text


@lru_cache(maxsize=4)
def _made(key: _Key) -> Scheme:
    plan = key.plan
    patterns = plan.patterns_per_frame
    try:
        scheme = scheme_plugin(plan.scheme.name).make(plan, plan.scheme)
    except KinopixError:
        raise
    except Exception as error:  # whatever third-party code raises
        raise _broken(plan, f"{type(error).__name__}: {error}", "to be made without an error") from error
    if not _is_scheme(scheme):
        raise _broken(plan, f"an object of type {type(scheme).__name__}", "an instrument.schemes.Scheme")
    if len(scheme.columns) != patterns:
        raise _broken(plan, f"{len(scheme.columns)} columns", f"{patterns}, its settings' patterns_per_frame")
    if scheme.light_weights.shape != (patterns,):
        raise _broken(plan, f"light_weights of shape {scheme.light_weights.shape}", f"({patterns},), one a column")
    return scheme


def _is_scheme(made: object) -> TypeGuard[Scheme]:
    """Whether an object has every member of a scheme. ``isinstance`` would ask for their values, and so make all patterns."""
    members = [name for name in dir(Scheme) if not name.startswith("_")]
    absent = object()
    return all(inspect.getattr_static(made, name, absent) is not absent for name in members)


def _broken(plan: Plan, saw: str, expected: str) -> PluginBroken:
    installed = find_plugin("scheme", plan.scheme.name)
    return PluginBroken(
        device=installed.origin,
        saw=saw,
        expected=expected,
        remedy=f"repair or reinstall {installed.distribution} {installed.version}, or choose another scheme",
    )
