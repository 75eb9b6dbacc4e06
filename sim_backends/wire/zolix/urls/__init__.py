"""Handlers that pyserial finds by module name, one a URL scheme."""
