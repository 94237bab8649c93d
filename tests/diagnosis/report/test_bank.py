"""One line for every cause: of later findings, of their ties, and of what was named before."""

from helmbench.diagnosis.causes.registry import causes
from helmbench.diagnosis.report.bank import demoted, lines
from helmbench.diagnosis.result import Entry, Finding

STATUS = {"current": "named", "wind": "tied", "rudder_delay": "not_testable"}
NUMBERS = "the numbers do"


def test_later_findings_take_the_place_of_earlier_ones():
    before = tuple(Entry(name, STATUS.get(name, "not_significant"), 1.0, 0.5, None, "") for name in causes())
    finding = Finding("rudder_offset", ("sway_offset",), "free runs", 9.0, 1e-4, (), evidence="it fits")
    after = {e.cause: e for e in lines([finding], demoted(before, ("named", "tied"), "explained_by", NUMBERS))}
    assert [*after] == [*causes()]
    assert after["rudder_offset"] == Entry("rudder_offset", "tied", 9.0, 1e-4, None, "it fits")
    assert after["sway_offset"].status == "tied" and "rudder_offset" in after["sway_offset"].why
    for name in ("current", "wind"):
        assert after[name] == Entry(name, "explained_by", 1.0, 0.5, None, NUMBERS)
    assert after["rudder_delay"].status == "not_testable" and after["heading_delay"].status == "not_significant"
