"""Paper 004: NMI-RLS on a 3-DOF MMG container ship in sea state 5."""
