"""A calibration file: what was measured of one bench, a section for each kind of measurement.

bench.toml names it (``calibration = "calibration.toml"``, relative to its own folder). A section that is measured anew takes the
place of the old one; the others stay.
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Final, Literal, Self, TypeAlias

import tomli_w

from instrument.config.alignment_section import AlignmentSection
from instrument.config.calibration_section import GridSection, Section
from instrument.config.check import validate_table
from instrument.config.detector_section import DetectorSection
from instrument.config.displacement_section import DisplacementSection
from instrument.config.document import Document, read_document
from instrument.config.errors import ConfigError, Problem
from instrument.config.mirrors_section import MirrorsSection
from instrument.config.profile_section import ProfileSection
from instrument.roles import RoleName
from protocols import DeviceIdentity, Frozen, InputError

VERSION: Final = 1
"""Version of the layout of calibration files."""

SectionName: TypeAlias = Literal["displacement", "detector", "mirrors", "light", "alignment"]
"""Name of a section."""

_HEAD: Final = (
    "# What was measured of a bench, by `kinopix calibrate`. bench.toml names this file: calibration = {name!r}\n"
)


class CalibratedDevice(Frozen):
    """A device that was there when the calibration was made."""

    vendor: str
    """Maker of the device."""

    model: str
    """Name of the model."""

    serial: str = ""
    """Serial number; empty where the device does not tell, and then not compared."""

    @classmethod
    def of(cls, identity: DeviceIdentity) -> Self:
        """Keep what tells one device from another."""
        return cls(vendor=identity.vendor, model=identity.model, serial=identity.serial)

    def is_same(self, other: Self) -> bool:
        """Whether both may be the same device."""
        serials = {self.serial, other.serial} - {""}
        return (self.vendor, self.model) == (other.vendor, other.model) and len(serials) < 2

    def __str__(self) -> str:
        """Name it as a person would."""
        return " ".join(part for part in (self.vendor, self.model, self.serial) if part)


class Calibration(Frozen):
    """What was measured of one bench."""

    version: Literal[1] = VERSION
    """Version of the layout."""

    magnification: str = ""
    """Name of the optics between object and modulator, as bench.toml has it."""

    bench: dict[RoleName, CalibratedDevice]
    """The devices, by role."""

    displacement: DisplacementSection | None = None
    """Pixels a millimetre, and the stage's axis."""

    detector: DetectorSection | None = None
    """Dark counts, dead time, linear limit."""

    mirrors: MirrorsSection | None = None
    """Transition leak, edge loss, delay of the light."""

    light: ProfileSection | None = None
    """Illumination and background."""

    alignment: AlignmentSection | None = None
    """Which way is x, flips and turns."""

    @property
    def sections(self) -> dict[SectionName, Section]:
        """The sections that were measured."""
        names: tuple[SectionName, ...] = ("displacement", "detector", "mirrors", "light", "alignment")
        return {name: section for name in names if (section := getattr(self, name)) is not None}

    def refuse_other_bench(self, devices: Mapping[RoleName, DeviceIdentity], magnification: str = "") -> None:
        """Refuse a bench with another device, or with other optics, than this was measured on.

        Args:
            devices: the bench's devices by role.
            magnification: the bench's own name for its optics.

        Raises:
            InputError: names the device.
        """
        for role, calibrated in self.bench.items():
            if role in devices and not calibrated.is_same(here := CalibratedDevice.of(devices[role])):
                raise InputError(
                    device=role,
                    saw=f"a calibration that was made with {calibrated}",
                    expected=f"one made with {here}, which is on this bench",
                    remedy="calibrate this bench, or take calibration out of bench.toml",
                )
        if self.magnification != magnification:
            raise InputError(
                saw=f"a calibration at the magnification {self.magnification!r}",
                expected=f"one at {magnification!r}, as bench.toml names the optics",
                remedy="calibrate with these optics, or correct magnification in bench.toml",
            )

    def refuse_other_grid(self, image_size: int, superpixel: int) -> None:
        """Refuse pixels of another size than a section was measured in.

        Raises:
            InputError: names the section, and both.
        """
        for name, section in self.sections.items():
            if isinstance(section, GridSection) and (section.image_size, section.superpixel) != (
                image_size,
                superpixel,
            ):
                raise InputError(
                    saw=f"{image_size} px of {superpixel} x {superpixel} mirrors, where [{name}] of the calibration of "
                    f"{section.date:%Y-%m-%d} holds for {section.image_size} px of {section.superpixel} x {section.superpixel}",
                    expected="the image_size and the superpixel that the bench was calibrated with",
                    remedy=f"calibrate with these (kinopix calibrate {name}), or take calibration out of bench.toml",
                )

    def with_section(self, name: SectionName, section: Section) -> Self:
        """Give the same calibration with one section measured anew."""
        return type(self).model_validate(
            {**{key: getattr(self, key) for key in type(self).model_fields}, name: section}
        )


def read_calibration(path: Path) -> Calibration:
    """Read a calibration file.

    Raises:
        ConfigError: the file cannot be read, is of another version, or has mistakes; names all of them with their lines.
    """
    document = read_document(path)
    _refuse_version(document)
    calibration, problems = validate_table(Calibration, document.values, document)
    if calibration is None:
        raise ConfigError(path, problems)
    return calibration


def _refuse_version(document: Document) -> None:
    version: object = document.values.get("version")
    if version != VERSION or version is True:
        saw = "no version" if version is None else f"version {version!r}"
        hint = "install a newer Kinopix, or calibrate anew" if version is not None else "is this a calibration file?"
        problem = Problem(
            document.path, document.line_of(("version",)), "version", saw, f"{VERSION}, which this program reads", hint
        )
        raise ConfigError(document.path, [problem])


def refuse_other(path: Path, devices: Mapping[RoleName, DeviceIdentity], magnification: str = "") -> Calibration | None:
    """Give what a calibration file holds that is to be written into; None where there is none yet.

    Raises:
        ConfigError: the file is there and is no calibration file that can be read.
        InputError: it is of another bench.
    """
    if not path.exists():
        return None
    calibration = read_calibration(path)
    calibration.refuse_other_bench(devices, magnification)
    return calibration


def updated_calibration(
    path: Path,
    name: SectionName,
    section: Section,
    devices: Mapping[RoleName, DeviceIdentity],
    magnification: str = "",
) -> Calibration:
    """Write one section into a calibration file, which is made if it is not there; the other sections stay.

    Args:
        path: the file.
        name: of the section.
        section: what was measured.
        devices: the bench that it was measured on, by role.
        magnification: name of its optics.

    Returns:
        What the file holds now.

    Raises:
        ConfigError: the file is there and is no calibration file that can be read.
        InputError: it is of another bench.
    """
    bench = {role: CalibratedDevice.of(identity) for role, identity in devices.items()}
    old = refuse_other(path, devices, magnification) or Calibration(magnification=magnification, bench=bench)
    new = old.model_copy(update={"bench": {**bench, **old.bench}}).with_section(name, section)
    write_calibration(path, new)
    return new


def write_calibration(path: Path, calibration: Calibration) -> None:
    """Write a calibration file, whole or not at all.

    Raises:
        InputError: the file cannot be written.
    """
    values = calibration.model_dump(exclude_none=True)
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        beside.write_text(_HEAD.format(name=path.name) + tomli_w.dumps(values), encoding="utf-8")
        beside.replace(path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise InputError(
            saw=f"a calibration that cannot be written to {path} ({error.strerror or error})",
            expected="a folder that can be written to",
            remedy="name another file",
        ) from error
