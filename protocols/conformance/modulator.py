"""The whole suite of a ``PatternModulator``: import all of it into a test file of your own, and define ``open_rig`` there."""

from protocols.conformance.test_modulator_halting import *  # noqa: F403
from protocols.conformance.test_modulator_loading import *  # noqa: F403
from protocols.conformance.test_modulator_machine import *  # noqa: F403
from protocols.conformance.test_modulator_playing import *  # noqa: F403
