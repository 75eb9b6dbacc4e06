# pyright: reportUnknownVariableType=false
# lazy_loader leaves the types of what it gives open; __init__.pyi has them.
"""Mathematics on arrays: splines and smoothing, total variation and its solvers, operators, compiled loops, metrics.

The names are listed in ``__init__.pyi``; each is loaded when it is first used: a run looks for slips without a solver.
"""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
