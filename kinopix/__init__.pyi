from instrument import *  # noqa: F403
from instrument import __all__ as __all__
