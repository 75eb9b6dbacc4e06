# pyright: reportUnknownVariableType=false
# lazy_loader leaves the types of what it gives open; __init__.pyi has them.
"""The framework: plans, acquisition, tracking, reconstruction, and the bench that composes the devices.

A lab script needs ``Instrument`` and ``Plan`` to record, ``track`` and ``reconstruct`` to analyse. The names are listed in
``__init__.pyi``; each is loaded when it is first used, so that a script that only reads files loads no solver.
"""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
