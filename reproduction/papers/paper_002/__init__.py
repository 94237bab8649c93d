"""Paper 002: fast convergent iterative learning least squares (FCI-LS) on response models, and a tank test."""

from .figures import (
    draw_beta,
    draw_convergence,
    draw_noise,
    draw_tank,
    draw_tank_course,
)
from .studies import STUDIES

__all__ = ["STUDIES", "draw_beta", "draw_convergence", "draw_noise", "draw_tank", "draw_tank_course"]
