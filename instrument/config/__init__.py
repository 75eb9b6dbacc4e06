"""TOML files into checked models, and plug-ins by name."""

from instrument.config.bench import BenchConfig, OnAbort, Resolved, ResolvedDevice, load_bench
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
from instrument.config.errors import ConfigError, Problem
from instrument.config.load import load_model

__all__ = [
    "BenchConfig",
    "ConfigError",
    "InstalledPlugin",
    "OnAbort",
    "PluginBroken",
    "PluginKind",
    "PluginLine",
    "PluginMissing",
    "Problem",
    "Resolved",
    "ResolvedDevice",
    "find_plugin",
    "installed_plugins",
    "list_plugins",
    "load_bench",
    "load_model",
]
