# pyright: reportUnknownVariableType=false
# lazy_loader leaves the types of what it gives open; __init__.pyi has them.
"""Views for people: pictures as PNG, tables and progress in the terminal.

The names are listed in ``__init__.pyi``; each is loaded when it is first used, so that a table loads no plotting.
"""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
