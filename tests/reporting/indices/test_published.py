"""Models from indices of published ships, as the report has them."""

import numpy as np

from helmbench.estimation.indices.fit import NORMAL_95, PRIORS, parameters_of
from helmbench.reporting.indices import GIVEN, compared, published_page, published_ship


def test_a_published_ship_lies_within_the_prior_and_her_turns_are_predicted():
    found, rows = compared(published_ship("s175"))
    low, high = (parameters_of(np.full(len(PRIORS), side * NORMAL_95)) for side in (-1.0, 1.0))
    values = np.array([row.value for row in found.parameters[: len(PRIORS)]])
    assert ((low < values) & (values < high)).all()
    errors = {(row.manoeuvre, row.key): row.error for row in rows}
    assert max(abs(errors["turn:20", f"{name}_lengths"]) for name in ("advance", "transfer", "tactical_diameter")) < 0.1
    assert len(errors) == 13 and {text for text, _ in errors} - set(GIVEN) == {"turn:20", "zigzag:20/20"}


def test_the_report_has_a_table_for_every_ship_and_one_over_all():
    text = published_page([published_ship("esso-osaka-l3")])
    assert text.count("| manoeuvre") == 2 and "## Esso Osaka tanker, 3 m model, simulated" in text
    assert "The 95 % interval of the first overshoot of zigzag:20/20" in text
    assert "nan" not in text and "| zigzag:20/20 | left out | first overshoot" in text
