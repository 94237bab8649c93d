"""Particulars that no ship has are told where a model file is read."""

import json

import pytest

from helmbench.models.errors import BadInput
from helmbench.models.model import model_to_json, resolve


@pytest.mark.parametrize(("name", "value"), [("L", 0.0), ("L", -160.0), ("L", 1e300), ("U0", -7.7), ("rho", 1e-300)])
def test_sizes_that_no_ship_has_are_refused(tmp_path, name, value):
    path = tmp_path / "x.json"
    model_to_json(resolve("mariner"), path)
    facts = json.loads(path.read_text())
    facts["particulars"] |= {"x_G": 0.0}
    path.write_text(json.dumps(facts))
    assert resolve(path).particulars["x_G"] == 0.0
    facts["particulars"] |= {name: value}
    path.write_text(json.dumps(facts))
    with pytest.raises(BadInput, match=rf"x\.json: particulars {name}: .* is no size of a ship"):
        resolve(path)
