"""Configuration: TOML files read into checked models, and plug-ins found by name."""

from instrument.config.bench import BenchConfig, OnAbort, Resolved, ResolvedDevice, bench_of_tables, load_bench
from instrument.config.calibration_file import (
    CalibratedDevice,
    Calibration,
    SectionName,
    read_calibration,
    refuse_other,
    updated_calibration,
    write_calibration,
)
from instrument.config.calibration_section import GridSection, Section
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
from instrument.config.displacement_section import Approach, CalibrationPosition, DisplacementSection
from instrument.config.document import read_document
from instrument.config.errors import ConfigError, Problem
from instrument.config.light_table import NOTHING_KNOWN, DeadTimeKind, LightTable
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
    "Approach",
    "BenchConfig",
    "CalibratedDevice",
    "Calibration",
    "CalibrationPosition",
    "ConfigError",
    "DeadTimeKind",
    "DisplacementSection",
    "GridSection",
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
    "Section",
    "SectionName",
    "bench_of_tables",
    "find_plugin",
    "installed_plugins",
    "list_plugins",
    "load_bench",
    "read_calibration",
    "read_document",
    "refuse_other",
    "scheme_plugin",
    "scheme_problems",
    "settings_of",
    "updated_calibration",
    "validate_table",
    "write_calibration",
]
