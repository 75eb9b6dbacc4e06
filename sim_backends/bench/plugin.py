"""Entry point of the optical bench: ``[scene]`` in bench.toml."""

from protocols import ScenePlugin
from sim_backends.bench.bench import OpticalBench
from sim_backends.bench.settings import SceneSettings

plugin = ScenePlugin(
    summary="optical bench: a moving object, its light and its photons, in virtual time",
    settings=SceneSettings,
    open=OpticalBench,
)
"""Found as ``kinopix.scenes: optical-bench``."""
