"""Configuration: TOML files read into checked models, and plug-ins found by name."""

from instrument.config.alignment_section import ORIENTATIONS, AlignmentSection, Orientation, upright_angle_deg
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
from instrument.config.detector_section import DetectorSection, LampLine, Measured
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
from instrument.config.keys_page import keys_page
from instrument.config.light_table import NOTHING_KNOWN, DeadTimeKind, Grid, LightTable, Stated, StatedProfile
from instrument.config.mirrors_section import MirrorsSection
from instrument.config.profile_section import ProfileSection
from instrument.config.run_table import RunTable
from instrument.config.schema import bench_schema, plan_schema
from instrument.config.scheme_table import (
    DEFAULT_SCHEME,
    SchemePlugin,
    SchemeSettings,
    scheme_plugin,
    scheme_problems,
    settings_of,
)
from instrument.config.stop_table import StopTable
from instrument.config.template import bench_template, plan_template

__all__ = [
    "DEFAULT_SCHEME",
    "NOTHING_KNOWN",
    "ORIENTATIONS",
    "AlignmentSection",
    "Approach",
    "BenchConfig",
    "CalibratedDevice",
    "Calibration",
    "CalibrationPosition",
    "ConfigError",
    "DeadTimeKind",
    "DetectorSection",
    "DisplacementSection",
    "Grid",
    "GridSection",
    "InstalledPlugin",
    "LampLine",
    "LightTable",
    "Measured",
    "MirrorsSection",
    "OnAbort",
    "Orientation",
    "PluginBroken",
    "PluginKind",
    "PluginLine",
    "PluginMissing",
    "Problem",
    "ProfileSection",
    "Resolved",
    "ResolvedDevice",
    "RunTable",
    "SchemePlugin",
    "SchemeSettings",
    "Section",
    "SectionName",
    "Stated",
    "StatedProfile",
    "StopTable",
    "bench_of_tables",
    "bench_schema",
    "bench_template",
    "find_plugin",
    "installed_plugins",
    "keys_page",
    "list_plugins",
    "load_bench",
    "plan_schema",
    "plan_template",
    "read_calibration",
    "read_document",
    "refuse_other",
    "scheme_plugin",
    "scheme_problems",
    "settings_of",
    "updated_calibration",
    "upright_angle_deg",
    "validate_table",
    "write_calibration",
]
