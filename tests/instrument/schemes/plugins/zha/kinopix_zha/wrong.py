"""Entry points that give what cannot serve."""

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from pydantic import ConfigDict

from instrument.plan import Plan
from instrument.schemes import SchemePlugin, SchemeSettings
from protocols import DriverPlugin, Floats, Frozen, PatternSequence

from .good import ZhaMoments, ZhaSettings


def open_device(settings: Frozen, context: object) -> tuple[Frozen, object]:
    """Give back what was given."""
    return settings, context


def make_nothing(plan: Plan, settings: ZhaSettings) -> tuple[Plan, ZhaSettings]:
    """Give no scheme."""
    return plan, settings


def make_nothing_at_all(plan: Plan, settings: ZhaSettings) -> ZhaMoments:
    """Fail as a careless scheme does."""
    raise KeyError(f"no table for {plan.image_size} px in {settings.name}")


class Misweighted(ZhaMoments):
    """A scheme with a weight too few."""

    @property
    def light_weights(self) -> Floats:
        """Of four patterns."""
        return np.array([1.0, 0, 0, 0])


class Short(ZhaMoments):
    """A scheme that forgets a picture."""

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """All but the first picture."""
        whole = super().sequence(columns, rows)
        return replace(whole, play_order=whole.play_order[1:])


def _settings(scheme: str, patterns: int = 5) -> type[Any]:
    """Settings of the good scheme under another name."""
    own: dict[str, Any] = {
        "__annotations__": {"name": str, "patterns_per_frame": ClassVar[int]},
        "__module__": __name__,
        "name": scheme,
        "patterns_per_frame": patterns,
    }
    return type("OwnSettings", (ZhaSettings,), own)


class LooseSettings(SchemeSettings):
    """Settings that ignore a key they do not know."""

    model_config = ConfigDict(extra="ignore")
    patterns_per_frame: ClassVar[int] = 5
    name: str = "zha-loose"


class ForeignSettings(Frozen):
    """Settings that are no scheme's."""

    name: str = "zha-settings"


class UncountedSettings(SchemeSettings):
    """Settings that do not say how many patterns a frame has."""

    name: str = "zha-uncounted"


foreign = DriverPlugin("A driver where a scheme belongs", ForeignSettings, open_device)
loose: SchemePlugin[Any] = SchemePlugin("Takes anything", LooseSettings, ZhaMoments)
other_settings: SchemePlugin[Any] = SchemePlugin("No settings", ForeignSettings, ZhaMoments)
uncounted: SchemePlugin[Any] = SchemePlugin("Does not count", UncountedSettings, ZhaMoments)
nameless: SchemePlugin[Any] = SchemePlugin("Another's settings", ZhaSettings, ZhaMoments)
nothing: SchemePlugin[Any] = SchemePlugin("No scheme", _settings("zha-nothing"), make_nothing)
crashing: SchemePlugin[Any] = SchemePlugin("Crashes", _settings("zha-crash"), make_nothing_at_all)
miscounted: SchemePlugin[Any] = SchemePlugin("Counts wrongly", _settings("zha-columns", 4), ZhaMoments)
misweighted: SchemePlugin[Any] = SchemePlugin("Weighs wrongly", _settings("zha-weights"), Misweighted)
short: SchemePlugin[Any] = SchemePlugin("Forgets a picture", _settings("zha-short"), Short)
