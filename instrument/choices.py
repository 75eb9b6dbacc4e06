"""Names of methods that a person can choose among: here, so that the command can offer them without loading what they do."""

from typing import Literal, TypeAlias

TrackingMethod: TypeAlias = Literal["smooth", "per-frame"]
"""How ``track`` finds the path: one smooth path through all frames; each frame by itself, as published."""

Tracking: TypeAlias = Literal["joint", "smooth", "per-frame"]
"""How an analysis finds the path: path and image refined together (``joint``), or as ``TrackingMethod``."""

Method: TypeAlias = Literal["tv", "tv-fourier", "tv-bregman", "tv-al", "pseudo-inverse", "dgi", "conventional"]
"""How an image is made."""

Background: TypeAlias = Literal["auto", "fit", "none"]
"""Whether the light of something that stands still is found together with the object: where the values show it, always, never."""

Grid: TypeAlias = Literal["auto", "1", "2"]
"""Image pixels that a pattern pixel has along each axis; ``auto`` takes 2 where the motion supports it."""

Extent: TypeAlias = Literal["inside", "field", "wide"]
"""Which pixels of the object are solved for: those that stay inside the field in every frame; those inside it at frame 0; or all
that it ever sees, of an object that passes by and may be larger than the field."""

Reach: TypeAlias = Literal["auto", "inside", "wide"]
"""How far the object reaches in an analysis: inside the field but for some frames, or passing by and perhaps larger. ``auto``
takes it to pass by where a calibrated stage tells so, and its values are explained by nothing else."""

Normalise: TypeAlias = Literal["auto", "smoothed", "frame", "off"]
"""By what values are divided against a lamp that changes: the total light smoothed over frames, each frame's own as published, or
nothing; ``auto`` is ``frame`` where the path is found as published, else ``smoothed``."""

Shape: TypeAlias = Literal["auto", "rigid", "changing"]
"""Whether the object's slow turning and growing is found with its path: where the values show it, never, always."""

StudyName: TypeAlias = Literal["table1", "frames", "noise", "upsampling", "speed", "background", "dgi"]
"""Tables and figures of the paper that can be reproduced."""

Reproduced: TypeAlias = Literal["table1", "frames", "noise", "upsampling", "speed", "background", "dgi", "all"]
"""What ``kinopix reproduce`` makes: one study, or all."""
