"""What may be asked of an analysis, and what of it goes together."""

from typing import get_args

from instrument.analysis.passing import refuse_passing
from instrument.choices import Method, Normalise, Reach, Shape, Tracking
from instrument.reconstruction import method_of
from protocols import InputError


def refuse_choices(
    *, tracking: Tracking, mean_filter: int | None, method: Method, normalise: Normalise, shape: Shape, region: Reach
) -> None:
    """Refuse what there is not, and what does not go together.

    Raises:
        InputError: in both cases.
    """
    _refuse_tracking(tracking, mean_filter)
    method_of(method)
    _refuse_shape(shape, tracking, method)
    _refuse_region(region, tracking, method, shape, normalise)


def _refuse_tracking(tracking: Tracking, mean_filter: int | None) -> None:
    """Refuse a tracking that there is not, and a filter that the tracking does not have.

    Raises:
        InputError: in both cases.
    """
    if tracking not in get_args(Tracking):
        raise InputError(
            saw=f"the tracking {tracking!r}",
            expected=f"one of {', '.join(get_args(Tracking))}",
            remedy="correct the name",
        )
    if mean_filter is not None and tracking != "per-frame":
        raise InputError(
            saw=f"a mean filter of {mean_filter} for the tracking {tracking}, which smooths as far as the values ask for it",
            expected="a mean filter with the tracking per-frame alone",
            remedy="leave it out, or ask for per-frame",
        )


def _refuse_shape(shape: Shape, tracking: Tracking, method: Method) -> None:
    """Refuse a shape that there is not, and one that tracking or method do not follow.

    Raises:
        InputError: in both cases.
    """
    if shape not in get_args(Shape):
        raise InputError(
            saw=f"the shape {shape!r}", expected=f"one of {', '.join(get_args(Shape))}", remedy="correct the name"
        )
    if shape == "changing" and (tracking != "joint" or method != "tv"):
        raise InputError(
            saw=f"a changing shape with the tracking {tracking} and the method {method}",
            expected="the tracking joint and the method tv, which follow it",
            remedy="leave out the one or the other",
        )


def _refuse_region(region: Reach, tracking: Tracking, method: Method, shape: Shape, normalise: Normalise) -> None:
    """Refuse a region that there is not, and one that the methods do not see.

    Raises:
        InputError: in both cases.
    """
    if region not in get_args(Reach):
        raise InputError(
            saw=f"the region {region!r}", expected=f"one of {', '.join(get_args(Reach))}", remedy="correct the name"
        )
    if region == "wide":
        refuse_passing(tracking, method, shape, normalise)
