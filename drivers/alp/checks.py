"""What the driver refuses before the board is touched."""

from drivers.alp.inspection import Inspection
from drivers.alp.settings import Dlp7000Settings
from protocols.errors import InputError, PictureTimeTooShort, PlanError
from protocols.modulator import ModulatorTiming, PatternSequence


def check_settings(settings: Dlp7000Settings, device: str) -> None:
    """Refuse slave mode.

    Raises:
        InputError: with the reason.
    """
    if settings.trigger == "slave":
        raise InputError(
            device=device,
            saw='trigger = "slave"',
            expected='trigger = "master"',
            remedy="let the board give the clock and clock the counter by its sync output: in slave mode the board drops "
            "triggers that come too early without any error, so pictures and counts would no longer match",
        )


def check_plan(sequence: PatternSequence, timing: ModulatorTiming, found: Inspection, device: str) -> None:
    """Refuse a sequence or a timing that this board cannot play.

    Raises:
        PictureTimeTooShort: names the shortest.
        PlanError: another geometry, or a time out of range.
    """
    limits, grid = found.limits, sequence.grid
    if (grid.columns, grid.rows) != (limits.columns, limits.rows):
        raise PlanError(
            device=device,
            saw=f"patterns for {grid.columns} x {grid.rows} mirrors",
            expected=f"{limits.columns} x {limits.rows}",
            remedy="build the sequence with the columns and rows of this modulator's limits",
        )
    if timing.picture_time_us < limits.shortest_picture_time_us:
        raise PictureTimeTooShort(device, timing.picture_time_us, limits.shortest_picture_time_us)
    for what, asked_us, longest_us, remedy in (
        ("picture time", timing.picture_time_us, limits.longest_picture_time_us, "raise pattern_rate_hz"),
        ("sync delay", timing.sync_delay_us, found.longest_sync_delay_us, "use 0, so that bins are pictures"),
        ("sync width", timing.sync_width_us, timing.picture_time_us - 1, "give a pulse shorter than the picture"),
    ):
        if asked_us > longest_us:
            raise PlanError(
                device=device,
                saw=f"a {what} of {asked_us} us",
                expected=f"at most {longest_us} us",
                remedy=remedy,
            )
