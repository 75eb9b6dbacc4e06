"""One test suite a protocol: run it on your driver to show that the framework can rely on it.

Name a *rig factory*, a function of yours, and run ::

    pytest --pyargs protocols.conformance --kinopix-driver my_package.conformance:stage_rig

``--kinopix-driver`` may be given many times. The suites need pytest and hypothesis (``pip install kinopix[conformance]``).
They take all time from the rig's clock: seconds on a virtual one, some minutes on a real one. A modulator shows a few dozen
pictures, a counter wants sync edges. A stage moves within ``StageRig.span_mm``, or 6 mm to both sides of where it stands, and
is brought back after each test. Before a real one moves (the host's own clock, and not simulated by its identity) the suite
asks at the terminal; ``--kinopix-may-move`` answers beforehand.

To have the tests in your own test tree instead, import all of ``protocols.conformance.stage`` (or ``counter``, ``modulator``)
there and define a fixture ``open_rig`` that gives the factory.
"""

from protocols.conformance.rigs import CounterRig, ModulatorRig, Rig, RigFactory, StageRig

__all__ = ["CounterRig", "ModulatorRig", "Rig", "RigFactory", "StageRig"]
