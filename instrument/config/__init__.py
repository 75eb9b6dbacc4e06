"""TOML files into checked models, and plug-ins by name."""
