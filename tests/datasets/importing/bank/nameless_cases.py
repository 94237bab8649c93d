"""Logs without a header: how their columns move together says what they are, and one question asks if it is right."""

import numpy as np

from .case import Case, Is
from .texts import D, fixed, series

MEANT = {
    "heading": Is("heading", "deg"), "psi_rad": Is("heading", "rad"), "rot_s": Is("yaw_rate", "deg/s"),
    "rot_min": Is("yaw_rate", "deg/min"), "r_rad": Is("yaw_rate", "rad/s"), "rudder": Is("rudder", "deg"),
    "delta_rad": Is("rudder", "rad"), "north": Is("north", "m"), "east": Is("east", "m"), "u": Is("surge", "m/s"),
    "v": Is("sway", "m/s"), "lat": Is("latitude", "deg"), "lon": Is("longitude", "deg"),
    "port": Is("rudder", "deg"), "unwrapped": Is("heading", "deg"), "vn": Is("velocity_north", "m/s"),
    "ve": Is("velocity_east", "m/s"), "order": Is("rudder_command", "deg"), "sog": Is("speed_over_ground", "kn"),
    "east_x": Is("east", "m"), "north_y": Is("north", "m"), "ccw": Is("heading", "rad", -1, 1.0, np.pi / 2.0),
    "r_ccw": Is("yaw_rate", "rad/s", -1), "cog": Is("course_over_ground", "deg"),
}  # fmt: skip
CHANNELS = {"heading": "heading_rad", "yaw_rate": "yaw_rate_rad_s", "rudder": "rudder_rad", "north": "north_m",
            "east": "east_m", "surge": "surge_m_s", "sway": "sway_m_s", "latitude": "north_m",
            "longitude": "east_m"}  # fmt: skip


def more(run) -> dict[str, list[str]]:
    """Further columns: what a towing tank or a simulator writes, and what is none of a record's channels."""
    return {
        "east_x": fixed(run.east, 3), "north_y": fixed(run.north, 3), "ccw": fixed(np.pi / 2.0 - run.psi, 5),
        "r_ccw": fixed(-run.r, 6), "port": fixed(-run.delta * D, 2), "unwrapped": fixed(run.psi * D + 360.0, 3),
        "vn": fixed(run.north_speed, 4), "ve": fixed(run.east_speed, 4), "row": [str(i) for i in range(run.t.size)],
        "thrust": fixed(40.0 + 8.0 * np.abs(run.delta) + 0.3 * np.sin(3.0 * run.t), 3),
        "const": fixed(10.23 + 0 * run.t), "ms": fixed(1000.0 * run.t, 0),
        "noise": fixed(np.sin(12.7 * np.arange(run.t.size) ** 1.1), 3),
    }  # fmt: skip


def nameless(name, *columns, between=",", comma=False, questions=1, time=""):
    """A case of a log with such columns in this order."""

    def write(run, folder):
        own = series(run) | more(run)
        rows = zip(*(own[column] for column in columns), strict=True)
        lines = [between.join(row) for row in rows]
        (folder / name).write_text(
            "\n".join(line.replace(".", ",") if comma else line for line in lines) + "\n", "utf-8"
        )
        return [folder / name]

    knows = {f"column {i}": MEANT[c] for i, c in enumerate(columns, start=1) if c in MEANT}
    wanted = tuple(dict.fromkeys(CHANNELS[own.quantity] for own in knows.values() if own.quantity in CHANNELS))
    return Case(write, True, knows, wanted, "port" if "port" in columns else "starboard", time, questions=questions)


NAMELESS_CASES = {
    "nameless, towing tank": nameless("a.dat", "t", "north", "east", "heading", "vn", "ve", "rot_s", "port", "const",
                                      "thrust", between="  "),
    "nameless, simulator": nameless("b.csv", "t", "north", "east", "psi_rad", "u", "v", "r_rad", "delta_rad"),
    "nameless, any order": nameless("c.csv", "t", "rudder", "rot_min", "east", "thrust", "u", "north", "v", "heading"),
    "nameless, semicolons and decimal commas": nameless("d.csv", "t", "heading", "rot_s", "rudder", "north", "east",
                                                        between=";", comma=True),
    "nameless, globe": nameless("e.csv", "iso", "lat", "lon", "heading", "rot_min", "rudder"),
    "nameless, no positions": nameless("f.csv", "t", "heading", "rot_min", "rudder", "noise"),
    "nameless, no yaw rate": nameless("g.csv", "t", "north", "east", "heading", "rudder", "const"),
    "nameless, milliseconds": nameless("h.csv", "ms", "heading", "rot_s", "rudder", "north", "east"),
    "nameless, rows counted": nameless("i.csv", "row", "t", "heading", "rot_s", "rudder", "north", "east"),
    "nameless, heading beyond the turn": nameless("j.txt", "t", "unwrapped", "rot_s", "port", "north", "east", "u", "v",
                                                  between="\t"),
    "nameless, receiver": nameless("l.csv", "t", "lat", "lon", "sog", "cog", "heading", "rudder"),
    "nameless, order and rudder": nameless("m.csv", "ms", "order", "rudder", "heading", "rot_min"),
    "nameless, axes x east, y north": nameless("n.csv", "t", "east_x", "north_y", "ccw", "r_ccw", "port"),
    "nameless, heading and rudder": nameless("o.csv", "t", "heading", "rudder"),
    "nameless, rate and rudder": nameless("p.csv", "t", "rot_s", "rudder"),
    "nameless, no time": nameless("q.csv", "unwrapped", "rot_s", "rudder", questions=2, time="0.5"),
    "nameless, gyro and helm only": nameless("k.csv", "t", "psi_rad", "r_rad", "delta_rad"),
}  # fmt: skip
