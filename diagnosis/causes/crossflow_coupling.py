"""Cause `crossflow_coupling`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ..searches.score import ByScore
from .base import Cause, NotTestable, require_3dof, term

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class CrossflowCoupling(Cause):
    """Coupled cross-flow terms in a turn: Y r|v|, Y v|r|, N v|r|, N r|v|, in the vessel's own prime system."""

    id = "crossflow_coupling"
    where = "hull"
    unit = "1"
    search = ByScore()
    extension = "crossflow_coupling"
    separate_by = "turns with sway measured at several drift angles"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_3dof(est)
        if "added_Yr_absv" not in est.index:
            raise NotTestable("the model has these terms already")
        entries = {"Yrv": "added_Yr_absv", "Yvr": "added_Yv_absr", "Nvr": "added_Nv_absr", "Nrv": "added_Nr_absv"}
        single = [term(est, name, "1", entry) for name, entry in entries.items()]
        return [*((p,) for p in single), tuple(single)]

    def details(self, est: Estimator, variant: Variant) -> Mapping[str, list[str]]:
        return {"components": [p.name for p in variant]}
