"""What a column of a log can be: quantities with their dimensions, and the names that logs give them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """A quantity: dimension, the unit that logs usually use, and its names as words in lower case.

    usual : unit taken where nothing else tells it;  short : names that count only where the whole name is so.
    """

    dimension: str
    usual: str
    names: tuple[str, ...]
    short: tuple[str, ...] = ()
    wraps: bool = False


def words_of(text: str) -> frozenset[str]:
    """Words that are separated by spaces."""
    return frozenset(text.split())


def names(text: str) -> tuple[str, ...]:
    """Names that are separated by bars."""
    return tuple(name.strip() for name in text.split("|"))


QUANTITIES: dict[str, Quantity] = {
    "rudder": Quantity(
        "angle",
        "deg",
        names(
            "rudder angle | rudder | rudder position | rudder feedback | rsa | ruderlage | ruderwinkel | ruder | helm "
            "angle | steering angle | nozzle angle | fin angle | rudder pos | rudder deflection | rudder response | "
            "rudder actual"
        ),
        names("delta | rud | helm | dr"),
    ),
    "rudder_command": Quantity(
        "angle",
        "deg",
        names("rudder command | commanded rudder | rudder order | rudder setpoint"),
        names("deltac | delta c"),
    ),
    "propeller": Quantity(
        "rotation",
        "rpm",
        names(
            "propeller | propeller revolutions | shaft speed | shaft revolutions | drehzahl | engine speed | motor "
            "speed | propellerdrehzahl | revolutions | rpm | rps | prop"
        ),
        names("n"),
    ),
    "propeller_thrust": Quantity(
        "force",
        "N",
        names("propeller thrust | thrust | schub"),
    ),
    "heading": Quantity(
        "angle",
        "deg",
        names(
            "heading | true heading | gyro heading | gyro | yaw | yaw angle | hdt | thdg | steuerkurs | "
            "kurs | gyrokurs "
            "| kompass | compass | hdg | heading true"
        ),
        names("psi"),
        True,
    ),
    "heading_magnetic": Quantity(
        "angle",
        "deg",
        names("magnetic heading | heading magnetic | mag heading | magnetic compass"),
        (),
        True,
    ),
    "magnetic_variation": Quantity(
        "angle",
        "deg",
        names("magnetic variation | variation | declination"),
    ),
    "magnetic_deviation": Quantity(
        "angle",
        "deg",
        names("magnetic deviation | compass deviation"),
    ),
    "yaw_rate": Quantity(
        "angular rate",
        "deg/s",
        names(
            "yaw rate | rate of turn | rot | turn rate | yawrate | drehrate | wendegeschwindigkeit | gyro z | angular "
            "velocity z | turning rate | wendekreisel | giergeschwindigkeit | heading rate"
        ),
        names("r | wz"),
    ),
    "surge": Quantity(
        "speed",
        "m/s",
        names(
            "surge | surge velocity | surge speed | longitudinal speed | forward speed | velocity x body "
            "| longitudinal "
            "velocity | forward velocity | ground speed longitudinal | laengsgeschwindigkeit"
        ),
        names("u"),
    ),
    "sway": Quantity(
        "speed",
        "m/s",
        names(
            "sway | sway velocity | sway speed | lateral speed | transverse speed | transverse velocity | lateral "
            "velocity | athwartship speed | quergeschwindigkeit | starboard velocity"
        ),
        names("v"),
    ),
    "speed_over_ground": Quantity(
        "speed",
        "kn",
        names(
            "speed over ground | sog | ground speed | gps speed | geschwindigkeit ueber grund | fahrt "
            "ueber grund | fug "
            "| fahrt | geschwindigkeit | speed | speed gps"
        ),
    ),
    "course_over_ground": Quantity(
        "angle",
        "deg",
        names(
            "course over ground | cog | track angle | gps course | kurs ueber grund | kueg | course | track | ground "
            "course"
        ),
        (),
        True,
    ),
    "speed_through_water": Quantity(
        "speed",
        "kn",
        names("speed through water | stw | log speed | water speed | fahrt durchs wasser | fdw"),
    ),
    "velocity_north": Quantity(
        "speed",
        "m/s",
        names("velocity north | north velocity | speed north | v north | vn"),
    ),
    "velocity_east": Quantity(
        "speed",
        "m/s",
        names("velocity east | east velocity | speed east | v east | ve"),
    ),
    "latitude": Quantity(
        "angle",
        "deg",
        names("latitude | lat | breite | gps lat | geographische breite"),
    ),
    "longitude": Quantity(
        "angle",
        "deg",
        names("longitude | lon | long | lng | laenge | gps lon"),
    ),
    "north": Quantity(
        "length",
        "m",
        names("north | northing | position north | pos north | x north | x0 | x earth | hochwert"),
        names("x"),
    ),
    "east": Quantity(
        "length",
        "m",
        names("east | easting | position east | pos east | y east | y0 | y earth | rechtswert"),
        names("y"),
    ),
    "roll": Quantity(
        "angle",
        "deg",
        names("roll | roll angle | heel | heel angle | kraengung | rollwinkel"),
        names("phi"),
    ),
    "roll_rate": Quantity(
        "angular rate",
        "deg/s",
        names("roll rate | rollrate | gyro x"),
        names("p | wx"),
    ),
    "wind_speed": Quantity(
        "speed",
        "m/s",
        names("wind speed | true wind speed | tws | windgeschwindigkeit | windspeed"),
    ),
    "wind_direction": Quantity(
        "angle",
        "deg",
        names("wind direction | wind dir | true wind direction | twd | windrichtung | winddirection"),
        (),
        True,
    ),
}
TIME_NAMES = names(
    "time | timestamp | time stamp | utc | utc time | zeit | uhrzeit | datetime | date time | date and time | datum "
    "uhrzeit | zeitstempel | gps time | elapsed time | seconds | epoch | unix time | t | local time | pc time | datum "
    "zeit | ros time | stamp | clock | sec | time utc | log time"
)
DATE_NAMES = names("date | datum | utc date | day | date utc | gps date")
COMMANDS = words_of(
    "cmd command commanded demand demanded desired order ordered ref reference set setpoint soll sollwert target"
)
"""Words that make a rudder angle a command, and any other quantity no measurement."""
NOT_MEASURED = words_of(
    "accel acceleration accuracy age alarm apparent count counter cov depth dop error flag hdop id limit max min mode "
    "pitch pressure pwm quality raw rel relativ relative scheinbar sd sigma status std temperature uncertainty valid "
    "validity variance"
)
"""Words that make a column no quantity of a record."""
AMBIGUOUS = words_of("compass course fahrt geschwindigkeit gyro kompass kurs prop speed steering track x y")
"""Names that stand for more than one quantity; their confidence is that of a short name."""
NOT_USED = {
    "speed_through_water": "a speed through the water is none over ground: map it to surge where there is no current",
}
"""Quantities that are recognised, but kept aside, and why."""
