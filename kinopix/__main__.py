"""``python -m kinopix``: the command."""

import kinopix as _kinopix  # claims the packages' names  # noqa: F401
from instrument.cli import main

if __name__ == "__main__":
    main()
