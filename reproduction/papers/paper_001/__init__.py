"""Paper 001: Euler-difference least squares (A1, A2) for the 60 coefficients of a Mariner model."""

from ..study import Study
from . import studies
from .figures import (
    draw_accuracy,
    draw_coefficients,
    draw_data,
    draw_explanation,
    draw_headings,
    draw_trajectories,
)
from .search import wide_settings

STUDIES = {**studies.STUDIES, "wide-settings": Study(wide_settings, seeds=32)}

__all__ = [
    "STUDIES",
    "draw_accuracy",
    "draw_coefficients",
    "draw_data",
    "draw_explanation",
    "draw_headings",
    "draw_trajectories",
]
