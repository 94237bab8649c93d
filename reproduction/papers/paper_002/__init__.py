"""Paper 002: fast convergent iterative learning least squares (FCI-LS) on response models, and a tank test."""

from functools import partial

from ..study import Study
from . import studies
from .figures import (
    draw_beta,
    draw_convergence,
    draw_noise,
    draw_tank,
    draw_tank_course,
)
from .search import over_range

STUDIES = {
    **studies.STUDIES,
    "first_order_searched": Study(partial(over_range, "first_order"), seeds=48),
    "second_order_searched": Study(partial(over_range, "second_order"), seeds=48),
}

__all__ = ["STUDIES", "draw_beta", "draw_convergence", "draw_noise", "draw_tank", "draw_tank_course"]
