"""Numbers that paper 004 prints, by the names of vessels `s175` and `s175-polynomial`."""

from __future__ import annotations

TABLE_2 = {
    "Xuu": -1.7269, "Xuuu": 1.7265, "Xvv": 4.0798, "Xrr": -1.4597, "Xvr": -1.5504, "Xuvv": -3.2796, "Xuvr": 1.5436,
    "Xurr": 1.4738,
    "Yuv": 1.2316, "Yur": 2.0764, "Yuur": -2.0740, "Yuuv": -1.2372, "Yvvv": 2.3357, "Yrrr": 0.0369, "Yvrr": 0.1787,
    "Yvvr": 0.2364, "Yv_absv": -0.4871, "Yr_absv": -0.0634, "Yv_absr": -0.2374, "Yr_absr": -0.0139,
    "Nuv": 0.0149, "Nur": -0.1533, "Nuur": 0.1525, "Nuuv": -0.0142, "Nvvv": -0.0126, "Nrrr": -0.0183, "Nvrr": -0.0695,
    "Nvvr": -0.0054, "Nv_absv": -0.0089, "Nr_absv": 0.0017, "Nv_absr": -0.0121, "Nr_absr": 0.0056,
}  # fmt: skip
PAIRS = {"Xuu": "Xuuu", "Xvr": "Xuvr", "Xrr": "Xurr", "Xvv": "Xuvv", "Yuv": "Yuuv", "Yur": "Yuur", "Nuv": "Nuuv",
         "Nur": "Nuur"}  # fmt: skip
"""Terms that differ by a factor u' alone, which is 1 to the second order of the drift angle at instantaneous speed."""
RUDDER_AREA_M2, ASPECT_RATIO = 22.04, -0.51


def slope(aspect_ratio: float) -> float:
    """f_alpha of eq 9."""
    return 6.13 * aspect_ratio / (2.25 + aspect_ratio)
