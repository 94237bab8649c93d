"""Units of raw logs: their spellings, dimensions and factors to SI units and radians."""

from __future__ import annotations

import math
import re
import unicodedata
from dataclasses import dataclass

from ..grammar import DEGREE, KNOT


def words_of(text: str) -> frozenset[str]:
    """Words that are separated by spaces."""
    return frozenset(text.split())


@dataclass(frozen=True)
class LogUnit:
    """A unit: its name in mapping files, dimension, factor to SI (radians) and the spellings of logs."""

    name: str
    dimension: str
    factor: float
    spellings: frozenset[str]


UNITS: dict[str, LogUnit] = {
    name: LogUnit(name, dimension, factor, words_of(spellings))
    for name, dimension, factor, spellings in (
        ("rad", "angle", 1.0, "рад 라디안 rad rads radian radians radiant radianes ラジアン 弧度"),
        ("deg", "angle", DEGREE,
         "도 град градусы stopni derece asteen stupnjeva deg degs degree degrees grad ° degt degm °t °m degtrue "
         "degmag degre degres degré degrés grado grados grader 度 gradi graus graden graad grau degrees_north "
         "degrees_east degree_north degree_east deg(t) deg(m) °true °(t)"),
        ("gon", "angle", math.pi / 200.0, "gon gons gradian gradians grads neugrad"),
        ("mrad", "angle", 1e-3, "mrad milliradian milliradians"),
        ("cdeg", "angle", 0.01 * DEGREE, "cdeg centideg centidegrees"),
        ("1e-7 deg", "angle", 1e-7 * DEGREE, "dege7 deg1e7 1e-7deg dege-7"),
        ("deg min", "angle", DEGREE,
         "ddmm.mmm ddmm.mmmm dddmm.mmm dddmm.mmmm ddmm.mm dddmm.mm dd°mm.mmm' dms ddmm degmin"),
        ("rad/s", "angular rate", 1.0,
         "рад/с 라디안/초 rad/s rads/s rads radps radiansps rad/sec radian/s radians/s 1/s 弧度/秒"),
        ("deg/s", "angular rate", DEGREE,
         "도/초 град/с град/сек deg/s degs/s °/s deg/sec degps dps °/sec grad/s grados/s degres/s 度/秒 度/s "
         "degree/s degrees/s degree/sec degrees/sec grader/s grad/sek °/sek grados/seg gradi/s graus/s graden/s"),
        ("mrad/s", "angular rate", 1e-3, "mrad/s mrad/sec"),
        ("deg/min", "angular rate", DEGREE / 60.0,
         "도/분 град/мин deg/min degs/min °/min degpmin degmin dpm grad/min °/m deg/m grados/min degres/min 度/分 "
         "度/min degree/min degrees/min grader/min °/mn degres/mn gradi/min graus/min graden/min"),
        ("rad/min", "angular rate", 1.0 / 60.0, "rad/min rads/min radian/min radians/min"),
        ("deg/h", "angular rate", DEGREE / 3600.0, "deg/h deg/hr °/h"),
        ("m/s", "speed", 1.0,
         "м/с 미터/초 m/s m/sec ms mps m/s. meter/s meter/sec meters/sec metre/sec metres/sec m/sek m/seg 米/秒 "
         "metre/s metres/s meters/s metros/s"),
        ("kn", "speed", KNOT,
         "노트 уз узлы узл knopen wezly kn kt kts knot knots knoten kns sm/h nmi/h nm/h noeud noeuds nœud nœuds "
         "nds nd nudo nudos nos nó nós nodi nodo knop ノット 节 節 节速"),
        ("km/h", "speed", 1.0 / 3.6, "km/h kmh kph kmph km/t km/hr 公里/小时 km/std"),
        ("cm/s", "speed", 0.01, "cm/s cm/sec"),
        ("mm/s", "speed", 0.001, "mm/s mm/sec"),
        ("mph", "speed", 0.44704, "mph mi/h miles/h"),
        ("ft/s", "speed", 0.3048, "ft/s ft/sec fps"),
        ("m/min", "speed", 1.0 / 60.0, "m/min"),
        ("m", "length", 1.0, "m meter metre meters metres metros 米 メートル"),
        ("km", "length", 1000.0, "km kilometer kilometre kilometers kilometres"),
        ("cm", "length", 0.01, "cm"),
        ("mm", "length", 0.001, "mm"),
        ("nmi", "length", 1852.0, "nmi nm sm nauticalmiles"),
        ("ft", "length", 0.3048, "ft feet foot"),
        ("rps", "rotation", 1.0, "rps 1/s hz rev/s r/s tr/s u/s 转/秒"),
        ("rpm", "rotation", 1.0 / 60.0,
         "об/мин rpm 1/min u/min rev/min r/min /min tr/min o/min omdr/min 转/分 回転/分 upm rev/m tr/mn tpm"),
        ("rad/s shaft", "rotation", 1.0 / math.tau, "rad/s rad/sec"),
        ("N", "force", 1.0, "n newton"),
        ("kN", "force", 1000.0, "kn"),
    )
}  # fmt: skip
TIME_WORDS = words_of(
    "s sec secs second seconds sek sekunden ms msec millis us ns min h utc gmt hh:mm:ss hh:mm:ss.fff hhmmss iso "
    "iso8601 epoch unix dd.mm.yyyy yyyy-mm-dd days datum local lt hh:mm:ss.sss dd/mm/yyyy mm/dd/yyyy tt.mm.jjjj "
    "seg std 秒 nanosec nsec nanoseconds microseconds milliseconds unixtime"
)
NO_UNIT = words_of(
    "- -- none n/a 1 [-] % bool v a ma mv hpa mbar bar c °c degc l/h kw nm knm counts raw us µs pwm steps volt volts "
    "percent pct prozent hz m/s2 g kg t bits text ‰ adc lsb"
)
"""Units of columns that are no channel, or that say no size; a row of units holds them beside those above."""
SUPERSCRIPTS = str.maketrans("⁻⁰¹²³", "-0123")
PER_TIME = re.compile(
    r"(deg|degs|degrees?|°|rad|mrad|m|km|cm|mm|nmi|nm|r|rev|u|tr|grad)[-_.·* ]*(s|sec|min|h|hr)[-_^. ]*-?1"
)
"""A unit of a rate with its denominator as a power: deg s-1, m.s^-1, deg_s_1."""


def tidy(text: str) -> str:
    """A unit's text without brackets, spaces and signs of multiplication, in lower case."""
    text = unicodedata.normalize("NFKC", text.translate(SUPERSCRIPTS)).strip().strip("[](){}<>").lower()
    text = text.replace("º", "°").replace("˚", "°").replace("\u2212", "-").replace("^", "").replace("∘", "°")
    text = re.sub(" (?:per|pro|par|por) |_per_", "/", text)
    power = PER_TIME.fullmatch(text.strip())
    text = f"{power[1]}/{power[2]}" if power else re.sub(r"\s+|\*|·|⋅", "", text)
    text = text.replace("persecond", "/s").replace("perminute", "/min").replace("seconds", "s").replace("second", "s")
    return text.replace("minutes", "min").replace("minute", "min").replace("//", "/")


def unit_of(text: str, dimension: str | None = None) -> LogUnit | None:
    """The unit that a text spells, of the dimension if one is given; None where it spells none."""
    spelt = tidy(text)
    able = (unit for unit in UNITS.values() if spelt in unit.spellings)
    return next((unit for unit in able if dimension in (None, unit.dimension)), None)


CANDIDATES = {
    "angle": ("deg", "rad"),
    "angular rate": ("deg/s", "deg/min", "rad/s"),
    "speed": ("kn", "m/s", "km/h"),
    "length": ("m", "km", "ft", "mm"),
    "rotation": ("rpm", "rps"),
    "force": ("N", "kN"),
}
"""Dimension -> units that a column without a unit may be in, the likeliest first."""


def candidates(dimension: str) -> tuple[LogUnit, ...]:
    """The units of a dimension that a column without a unit may be in."""
    return tuple(UNITS[name] for name in CANDIDATES[dimension])
