"""Paper 000: FW-RLS on the K-T equation of the REMUS vehicle."""

from .figures import draw_continuous, draw_convergence, draw_errors, draw_noise, draw_prediction, draw_zigzag
from .studies import STUDIES

__all__ = [
    "STUDIES",
    "draw_continuous",
    "draw_convergence",
    "draw_errors",
    "draw_noise",
    "draw_prediction",
    "draw_zigzag",
]
