"""Cause `base_coefficients`."""

from __future__ import annotations

from ._stage import StageCause


class BaseCoefficients(StageCause):
    """Numbers of the base model are wrong: groups of coefficients and constants that the family states, such as the
    propeller's thrust or the resistance, moved within their priors."""

    id = "base_coefficients"
    where = "hull"
    stage = "looked for by free runs of records that were left out, where the base model leaves effects unexplained"
    separate_by = "runs that vary one thing at a time: speed on a straight course, rudder angle at one speed"
