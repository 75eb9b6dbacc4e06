"""What the driver refuses before the board is touched."""

from drivers.alp.inspection import Inspection
from drivers.alp.settings import Dlp7000Settings
from protocols.errors import InputError, PlanError
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
    """Refuse a sequence or a timing that this board cannot play. Whether it fits into the memory is for ``plan_upload`` to say.

    Raises:
        PictureTimeTooShort: names the shortest.
        PlanError: another geometry, or a time out of range.
    """
    found.limits.check_geometry(sequence.grid, device)
    found.limits.check_timing(timing, device)
    if timing.sync_delay_us > found.longest_sync_delay_us:
        raise PlanError(
            device=device,
            saw=f"a sync delay of {timing.sync_delay_us} us",
            expected=f"at most {found.longest_sync_delay_us} us",
            remedy="use 0, so that bins are pictures",
        )
