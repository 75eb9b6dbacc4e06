"""A stage whose controller tells at any time where it is and whether it moves: what drivers of such controllers share."""

from drivers.polled_stage.axis import Axis, Status
from drivers.polled_stage.settings import PolledStageSettings, SerialStageSettings
from drivers.polled_stage.stage import PolledStage

__all__ = ["Axis", "PolledStage", "PolledStageSettings", "SerialStageSettings", "Status"]
