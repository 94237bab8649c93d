"""The public names of an exam: causes with what their sizes are called, and groups of a model's own numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ...diagnosis.causes.registry import causes
from ...models.coefficient_groups import stated_groups
from ..faults import kinds
from ..kinds.diagnosis.names import BASE

if TYPE_CHECKING:
    from ...models.model import Model

GROUP = "group:"
"""What the name of a group of a model's own numbers begins with: some causes have the same identifier."""
MORE = {
    "shallow_water": {"draught_over_depth": "1"},
    "speed_loss": {"loss_gain": "1"},
    "second_order_lead": {"lead": "1"},
}
"""Cause -> further sizes by which it may be stated."""


def cause_list() -> dict[str, dict[str, Any]]:
    """Cause -> what it is, and its sizes with their units; the same for every exam."""
    known = kinds()
    return {
        name: {
            "what": " ".join(cause.physics.split()),
            "sizes": ({k: u for k, u in known[name].units.items() if u} if name in known else {}) | MORE.get(name, {}),
        }
        for name, cause in causes().items()
        if name != BASE
    }


def group_list(model: Model) -> dict[str, dict[str, Any]]:
    """Group of a model's own numbers -> what it is, and its numbers."""
    return {GROUP + g.id: {"what": g.title, "numbers": sorted(g.every)} for g in stated_groups(model)}
