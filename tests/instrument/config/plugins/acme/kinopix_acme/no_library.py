"""A plug-in whose import fails."""

raise ImportError("libacme.so: cannot open shared object file")
