"""The one place where a plan's scheme name becomes a scheme."""

from functools import lru_cache

from instrument.config import PluginBroken, scheme_plugin
from instrument.plan import Plan
from instrument.schemes.scheme import Scheme


def scheme_of(plan: Plan) -> Scheme:
    """Give the scheme that ``plan`` names; the same one for equal plans, so that its patterns are synthesised once.

    Raises:
        PluginMissing: the scheme is not installed.
        PluginBroken: what is installed under its name is no scheme, or does not have the patterns that its settings state.
    """
    return _made(_Key(plan))


class _Key:
    """A plan, compared by its content."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._text = plan.model_dump_json()

    def __hash__(self) -> int:
        return hash(self._text)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and self._text == other._text


@lru_cache(maxsize=4)
def _made(key: _Key) -> Scheme:
    plan = key.plan
    scheme = scheme_plugin(plan.scheme.name).make(plan, plan.scheme)
    if not isinstance(scheme, Scheme) or len(scheme.columns) != plan.patterns_per_frame:
        raise PluginBroken(
            device=f"scheme plug-in {plan.scheme.name!r}",
            saw=f"an object of type {type(scheme).__name__}",
            expected=f"an instrument.schemes.Scheme of {plan.patterns_per_frame} columns, as its settings state",
            remedy="repair or reinstall the distribution that offers it, or choose another scheme",
        )
    return scheme
