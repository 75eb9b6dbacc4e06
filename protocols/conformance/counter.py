"""The whole suite of a ``PhotonCounter``: import all of it into a test file of your own, and define ``open_rig`` there."""

from protocols.conformance.test_counter import *  # noqa: F403
from protocols.conformance.test_counter_machine import *  # noqa: F403
