"""Paper 004: NMI-RLS on a 3-DOF MMG container ship in sea state 5."""

from .figures import draw_omega, draw_printed_model, draw_tracks, draw_unknown_ship
from .studies import STUDIES

__all__ = ["STUDIES", "draw_omega", "draw_printed_model", "draw_tracks", "draw_unknown_ship"]
