"""Plans of any installed scheme, by name and settings, as plan.toml states them."""

from typing import Any

from instrument.plan import Plan


def plan_of(scheme: str, frames: int, image_size: int = 128, superpixel: int = 4, **settings: Any) -> Plan:
    """Make a plan whose ``[scheme]`` table has these settings."""
    return Plan.model_validate(
        {
            "frames": frames,
            "image_size": image_size,
            "superpixel": superpixel,
            "scheme": {"name": scheme, **settings},
        }
    )
