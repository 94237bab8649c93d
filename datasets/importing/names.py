"""Names of columns: cut into words and compared with the names of quantities."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

from .quantities import AMBIGUOUS, COMMANDS, DATE_NAMES, NOT_MEASURED, QUANTITIES, TIME_NAMES
from .units import Unit, unit_of

UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue"})
GREEK = {"ψ": "psi", "δ": "delta", "φ": "phi"}


def words(name: str) -> tuple[str, ...]:
    """A name as words in lower case: `RudderAngle_deg` is (rudder, angle, deg)."""
    name = "".join(GREEK.get(letter, letter) for letter in name.translate(UMLAUTS))
    name = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    name = re.sub(r"([a-z])([A-Z])|([A-Z])([A-Z][a-z])", r"\1\3 \2\4", name)
    return tuple(re.findall(r"[a-z]+\d?|\d+", name.lower()))


def split_unit(name: str) -> tuple[tuple[str, ...], Unit | None]:
    """(words without a unit at the end, that unit): `rot_deg_min` is rate of turn in deg/min, `sog_kn` in kn."""
    found = words(name)
    for count in (3, 2, 1):
        tail, head = found[-count:], found[:-count]
        if not head or len(tail) < count:
            continue
        for joint in ("/", ""):
            unit = unit_of(joint.join(tail))
            if unit is not None and (count > 1 or unit.name != "m/s" or tail != ("m",)):
                return head, unit
    return found, None


def match(name: str) -> tuple[str | None, float, str]:
    """(quantity, confidence between 0 and 1, reason) for a name; the quantity is None where none is near."""
    parts, _ = split_unit(name)
    best, confidence = _best(parts)
    if best is None:
        parts = words(name)
        best, confidence = _best(parts)
    if best is None:
        return None, 0.0, "no known name"
    if set(parts) & NOT_MEASURED:
        return None, 0.0, f"{(set(parts) & NOT_MEASURED).pop()!r}: no measured quantity of a record"
    ordered = set(parts) & COMMANDS
    if ordered and best == "rudder":
        return "rudder_command", confidence, f"name with {ordered.pop()!r}"
    if ordered and best != "rudder_command":
        return None, 0.0, f"{ordered.pop()!r}: a set value, no measurement"
    return best, confidence, "name"


def _best(parts: tuple[str, ...]) -> tuple[str | None, float]:
    scores = {quantity: _score(parts, quantity) for quantity in QUANTITIES}
    best = max(scores, key=lambda quantity: scores[quantity])
    return (best, scores[best]) if scores[best] > 0.0 else (None, 0.0)


def _score(parts: tuple[str, ...], quantity: str) -> float:
    """0.95 for a whole name, 0.75 for a short one; less the more other words there are."""
    joined, best = "".join(parts), 0.0
    for name in (_words(name) for name in QUANTITIES[quantity].names):
        if "".join(name) == joined:
            return 0.7 if joined in AMBIGUOUS else 0.95
        if _holds(parts, name):
            best = max(best, 0.55 + 0.3 * sum(map(len, name)) / len(joined))
    return 0.75 if joined in ("".join(_words(name)) for name in QUANTITIES[quantity].short) else best


@lru_cache(maxsize=1024)
def _words(name: str) -> tuple[str, ...]:
    return words(name)


def _holds(parts: tuple[str, ...], name: tuple[str, ...]) -> bool:
    """Whether the words of a name, at least three letters in all, follow each other in the parts."""
    n = len(name)
    return sum(map(len, name)) >= 3 and any(parts[i : i + n] == name for i in range(len(parts) - n + 1))


def time_confidence(name: str) -> float:
    """How surely a name is that of the time."""
    return _whole(name, TIME_NAMES)


def date_confidence(name: str) -> float:
    """How surely a name is that of a date."""
    return _whole(name, DATE_NAMES)


def _whole(name: str, known: tuple[str, ...]) -> float:
    parts, joined = words(name), "".join(words(name))
    if any(joined == "".join(_words(one)) for one in known):
        return 0.95
    return 0.7 if any(_holds(parts, _words(one)) for one in known if len(one) > 2) else 0.0
