"""The whole suite of a ``LinearStage``: import all of it into a test file of your own, and define ``open_rig`` there."""

from protocols.conformance.test_stage_limits import *  # noqa: F403
from protocols.conformance.test_stage_machine import *  # noqa: F403
from protocols.conformance.test_stage_moves import *  # noqa: F403
from protocols.conformance.test_stage_stops import *  # noqa: F403
