"""The flaws of a real bench, in figures: what ``realism = "realistic"`` means in ``[scene]``."""

from collections.abc import Mapping
from typing import Any, Final

from sim_backends.bench.noise_settings import NoNoise, PhotonNoise, PixelNoise

_PHOTONS: Final[Mapping[str, Any]] = {
    "peak_counts": 250.0,  # 5 million counts a second at 20 kHz: the linear limit of the H10682 (data sheet)
    "dark_rate_hz": 600.0,  # typical of the H10682-210 (data sheet)
    "dead_time_s": 20e-9,  # pulse-pair resolution of the H10682 (data sheet)
    "afterpulse_probability": 0.005,  # assumed: photomultipliers have some tenths of a percent to some percent
    "afterpulse_delay_s": 1e-6,  # assumed: ions need from some hundred nanoseconds to some microseconds
}

REALISTIC: Final[Mapping[str, Any]] = {
    "mirror_transition_s": 4e-6,  # crossover of the DLP7000 (DLPS026G)
    "mirror_settling_s": 8.5e-6,  # its switching time of 12.5 us (DLPS026G) without the crossover
    "edge_loss": 0.02,  # assumed: measured benches show that there is some, not how much of it
    "illumination_falloff": 0.35,  # assumed: an LED without a homogeniser
    "blur_px": 0.5,  # assumed: a lens that just resolves the pixels
    "object_growth": 0.003,  # assumed: a travel that is not quite in the plane of focus
    "object_turn_deg": 0.2,  # assumed: yaw of the stage
    "led_drift_per_s": -0.01,  # assumed: an LED that warms up
    "led_flicker": 0.01,  # assumed: a driver with some ripple of the mains
    "ambient_level": 0.02,  # assumed: a dark room with a gap under its door
    "ambient_ripple": 0.3,  # assumed: lamps in the corridor
    "spike_probability": 1e-4,  # assumed: one bin of the standard run
    "sync_jitter_s": 1e-8,  # assumed: one step of a counter's 100 MHz time base
}


def flaws(said: Mapping[str, Any]) -> dict[str, Any]:
    """Give the flaws of a real bench of which a ``[scene]`` table does not say otherwise, key by key.

    Args:
        said: keys that the table gives, with their values. A ``noise`` of another kind replaces that of the real bench; of one
            of the same kind the keys that are missing are filled in.
    """
    return {key: value for key, value in REALISTIC.items() if key not in said} | {"noise": _noise(said.get("noise"))}


def _noise(said: NoNoise | PixelNoise | PhotonNoise | None) -> NoNoise | PixelNoise | PhotonNoise:
    if said is not None and not isinstance(said, PhotonNoise):
        return said
    given = {} if said is None else {key: getattr(said, key) for key in said.model_fields_set}
    return PhotonNoise.model_validate({"kind": "poisson", **_PHOTONS, **given})
