"""Configuration: TOML files read into checked models, and plug-ins found by name."""

from instrument.config.bench import BenchConfig, OnAbort, Resolved, ResolvedDevice, bench_of_tables, load_bench
from instrument.config.check import validate_table
from instrument.config.discovery import (
    InstalledPlugin,
    PluginBroken,
    PluginKind,
    PluginLine,
    PluginMissing,
    find_plugin,
    installed_plugins,
    list_plugins,
)
from instrument.config.document import read_document
from instrument.config.errors import ConfigError, Problem
from instrument.config.light_table import NOTHING_KNOWN, DeadTimeKind, Grid, LightTable, Stated, StatedProfile
from instrument.config.scheme_table import (
    DEFAULT_SCHEME,
    SchemePlugin,
    SchemeSettings,
    scheme_plugin,
    scheme_problems,
    settings_of,
)

__all__ = [
    "DEFAULT_SCHEME",
    "NOTHING_KNOWN",
    "BenchConfig",
    "ConfigError",
    "DeadTimeKind",
    "Grid",
    "InstalledPlugin",
    "LightTable",
    "OnAbort",
    "PluginBroken",
    "PluginKind",
    "PluginLine",
    "PluginMissing",
    "Problem",
    "Resolved",
    "ResolvedDevice",
    "SchemePlugin",
    "SchemeSettings",
    "Stated",
    "StatedProfile",
    "bench_of_tables",
    "find_plugin",
    "installed_plugins",
    "list_plugins",
    "load_bench",
    "read_document",
    "scheme_plugin",
    "scheme_problems",
    "settings_of",
    "validate_table",
]
