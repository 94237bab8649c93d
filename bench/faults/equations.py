"""Hand-written equations of motion of the truth simulator (numba). No code of `models/` is used but `njit`.

Mariner: Chislett & Stroem-Tejsen 1965 (MSS mariner.m).  S175: Son & Nomoto 1982 with roll locked (MSS container.m).
KVLCC2: Yasukawa & Yoshimura 2015.  Response ships: paper 002, eq 1 and 4.  Wind, current, wave drift and damping
terms: the taxonomy of causes.
"""

from __future__ import annotations

from collections import namedtuple
from math import atan2, cos, exp, fabs, pi, sin, sqrt
from typing import Any

from ...models.compilation import njit

JIT: dict[str, Any] = {"cache": True, "error_model": "numpy"}
GRAVITY = 9.81

#: Effects that act inside the equations, units as in the files of `effects`: p of the functions below.
Terms = namedtuple(
    "Terms",
    "current_north current_east wind_north wind_east X Y N Nrr Nrrr Yvv Yrv Yvr Nvr Nrv mass_fraction Hs wave_from "
    "drop recovery r_quadratic r_cubic rudder_loss rudder_angle wake_loss wake_drift",
)
NO_TERMS = Terms(*[0.0] * len(Terms._fields))
#: What the equations know of a ship besides its coefficients: s.
ShipNumbers = namedtuple(
    "ShipNumbers", "rho S L U0 n m mxg iz m11 m22 m23 m32 m33 af al cx cy cn kn dw rho_air force moment"
)


@njit(**JIT)
def rudder_kept(p, d):
    """Share of the rudder's force at angle d that an injected stall leaves."""
    return 1.0 - p.rudder_loss if fabs(d) > p.rudder_angle else 1.0


@njit(**JIT)
def wake_kept(p, u, v):
    """Factor on the inflow of the propeller by an injected error of the wake at large drift angles."""
    return 1.0 - p.wake_loss if fabs(atan2(v, u)) > p.wake_drift else 1.0


@njit(**JIT)
def mariner_force(c, s, u, v, r, d, kept):
    """X, Y, N of hull, propeller and rudder, of whose force the share `kept` acts."""
    x, y, n = abkowitz_force(c, s, u, v, r, d)
    if kept == 1.0:
        return x, y, n
    x0, y0, n0 = abkowitz_force(c, s, u, v, r, 0.0)
    return x0 + kept * (x - x0), y0 + kept * (y - y0), n0 + kept * (n - n0)


@njit(**JIT)
def abkowitz_force(c, s, u, v, r, d):
    """X, Y, N of hull, propeller and rudder with the centripetal terms; c in the order of `ships.NAMES`."""
    speed = sqrt(u * u + v * v) + 1e-12
    a, b, w = (u - s.U0) / speed, v / speed, r * s.L / speed
    x = c[0] * a + c[1] * a * a + c[2] * a**3 + c[3] * b * b + c[4] * w * w + c[5] * d * d + c[6] * d * d * a
    x += c[7] * b * w + c[8] * b * d + c[9] * b * d * a + c[10] * a * b * b + c[11] * a * w * w + c[12] * a * b * w
    x += c[13] * w * d + c[14] * a * w * d + c[15]
    y = lateral(c[16:38], a, b, w, d)
    n = lateral(c[38:60], a, b, w, d)
    q = s.S * speed * speed
    return x * q, y * q, n * q * s.L


@njit(**JIT)
def lateral(c, a, b, w, d):
    """The 22 terms of sway and yaw."""
    out = c[0] * a + c[1] * a * a + c[2] * b + c[3] * w + c[4] * d + c[5] * b**3 + c[6] * d**3 + c[7] * b * b * w
    out += c[8] * b * b * d + c[9] * b * d * d + c[10] * d * a + c[11] * b * a + c[12] * w * a + c[13] * d * a * a
    out += c[14] * w**3 + c[15] * b * w * w + c[16] * b * a * a + c[17] * w * a * a + c[18] * w * d * d
    return out + c[19] * w * w * d + c[20] * w * b * d + c[21]


@njit(**JIT)
def s175_force(c, s, u, v, r, d, kept, wake):
    """Hull, propeller and rudder with the centripetal terms; c in the order of `ships.NAMES`.

    kept : share of the rudder's force that acts; wake : factor on the inflow of the propeller.
    """
    (xuu, xvv, xrr, xvr, cp, cru, yuv, yur, yvvv, yrrr, yvrr, yvvr, crv, nuv, nur, nvvv, nrrr, nvrr, nvvr, crr) = (
        c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10], c[11], c[12], c[13], c[14], c[15], c[16],
        c[17], c[18], c[19],
    )  # fmt: skip
    mx, my, dp, wp, tau, xp, a0, a1, ar, fa, eps, kx = (
        c[20], c[21], c[22], c[23], c[24], c[25], c[26], c[27], c[28], c[29], c[30], c[31],
    )  # fmt: skip
    gamma, crr1, crrr, crrv = c[32], c[33], c[34], c[35]
    length, rho = s.L, s.rho
    speed = sqrt(u * u + v * v) + 1e-12
    up, vp, rp = u / speed, v / speed, r * length / speed
    inflow = wake * u * ((1.0 - wp) + tau * (vp + xp * rp) ** 2)
    advance = inflow / (s.n * dp)
    kt = a0 + a1 * advance
    thrust = rho * s.n**2 * dp**4 * kt
    ur = inflow * eps * sqrt(1.0 + 8.0 * kx * kt / (pi * advance * advance))
    vr = speed * (gamma * vp + crr1 * rp + crrr * rp**3 + crrv * rp * rp * vp)
    normal = kept * 0.5 * rho * ar * fa * (ur * ur + vr * vr) * sin(d + atan2(vr, ur))
    q = s.S * speed * speed
    added = s.S * length
    x = q * (xuu * up * up + xvv * vp * vp + xrr * rp * rp + xvr * vp * rp) + cp * thrust - cru * normal * sin(d)
    x += (s.m + my * added) * v * r
    y = q * (yuv * up * vp + yur * up * rp + yvvv * vp**3 + yrrr * rp**3 + yvrr * vp * rp * rp + yvvr * vp * vp * rp)
    y += -crv * normal * cos(d) - (s.m + mx * added) * u * r
    n = q * (nuv * up * vp + nur * up * rp + nvvv * vp**3 + nrrr * rp**3 + nvrr * vp * rp * rp + nvvr * vp * vp * rp)
    return x, y, (n - crr * normal * cos(d)) * length


@njit(**JIT)
def kvlcc2_force(c, s, u, v, r, d, kept, wake):
    """MMG standard method with the centripetal terms; c in the order of `ships.NAMES`, kept and wake as above."""
    length, rho = s.L, s.rho
    speed = sqrt(u * u + v * v) + 1e-12
    vp, rp = v / speed, r * length / speed
    mx, my, dp, tp, wp0, xp, c1, c2p, c2m = c[20], c[21], c[22], c[23], c[24], c[25], c[26], c[27], c[28]
    k0, k1, k2, hr, ar, fa, eps, kappa, lr = c[29], c[30], c[31], c[32], c[33], c[34], c[35], c[36], c[37]
    beta = -atan2(v, u)
    beta_p = beta - xp * rp
    c2 = c2p if beta_p > 0 else c2m
    inflow = wake * u * (1.0 - wp0) * (1.0 + (1.0 - exp(-c1 * fabs(beta_p))) * (c2 - 1.0))
    advance = inflow / (s.n * dp)
    kt = k0 + k1 * advance + k2 * advance * advance
    thrust = rho * s.n**2 * dp**4 * kt
    eta = dp / hr
    race = 1.0 + kappa * (sqrt(1.0 + 8.0 * kt / (pi * advance * advance)) - 1.0)
    ur = eps * inflow * sqrt(eta * race * race + 1.0 - eta)
    beta_r = beta - lr * rp
    vr = speed * (c[38] if beta_r > 0 else c[39]) * beta_r
    normal = kept * 0.5 * rho * ar * fa * (ur * ur + vr * vr) * sin(d - atan2(vr, ur))
    q = s.S * speed * speed
    added = s.S * length
    x = q * (-c[0] + c[1] * vp * vp + c[2] * vp * rp + c[3] * rp * rp + c[4] * vp**4) + (1.0 - tp) * thrust
    x += -c[17] * normal * sin(d) + (s.m + my * added) * v * r + s.mxg * r * r
    y = q * (c[5] * vp + c[6] * rp + c[7] * vp**3 + c[8] * vp * vp * rp + c[9] * vp * rp * rp + c[10] * rp**3)
    y += -c[18] * normal * cos(d) - (s.m + mx * added) * u * r
    n = q * (c[11] * vp + c[12] * rp + c[13] * vp**3 + c[14] * vp * vp * rp + c[15] * vp * rp * rp + c[16] * rp**3)
    n = (n - c[19] * normal * cos(d)) * length - s.mxg * u * r
    return x, y, n


@njit(**JIT)
def wind_force(s, u, v):
    """Force of the air on a hull that moves with u, v through it (taxonomy, `wind`; Blendermann 1994 for S175)."""
    square = u * u + v * v + 1e-12
    gamma = -atan2(v, u)
    pressure = 0.5 * s.rho_air * square
    shape = 1.0 - 0.5 * s.dw * (1.0 - s.cx * s.af / (s.cy * s.al)) * sin(2.0 * gamma) ** 2
    x = -s.cx * cos(gamma) * pressure * s.af / shape
    y = s.cy * sin(gamma) * pressure * s.al / shape
    n = s.cn * sin(2.0 * gamma) * pressure * s.al * s.L - s.kn * (fabs(gamma) - 0.5 * pi) * y * s.L
    return x, y, n


@njit(**JIT)
def added_force(s, p, u, v, r, psi, ug, vg):
    """Injected forces: u, v through the water, ug, vg over ground."""
    speed = sqrt(u * u + v * v) + 1e-12
    b, w = v / speed, r * s.L / speed
    q = s.S * speed * speed
    x, y, n = p.X, p.Y, p.N
    y += q * (p.Yvv * b * fabs(b) + p.Yrv * w * fabs(b) + p.Yvr * b * fabs(w))
    n += q * s.L * (p.Nrr * w * fabs(w) + p.Nrrr * w**3 + p.Nvr * b * fabs(w) + p.Nrv * w * fabs(b))
    f = p.mass_fraction
    x += f * (s.m * v * r + s.mxg * r * r)
    y -= f * s.m * u * r
    n -= f * s.mxg * u * r
    if p.wind_north != 0.0 or p.wind_east != 0.0:
        ua = ug - (p.wind_north * cos(psi) + p.wind_east * sin(psi))
        va = vg - (-p.wind_north * sin(psi) + p.wind_east * cos(psi))
        x1, y1, n1 = wind_force(s, ua, va)
        x0, y0, n0 = wind_force(s, ug, vg)
        x, y, n = x + x1 - x0, y + y1 - y0, n + n1 - n0
    if p.Hs != 0.0:
        chi = p.wave_from - psi
        weight = s.rho * GRAVITY * p.Hs**2 * s.L
        x -= 0.010 * cos(chi) * (0.3 if cos(chi) < 0.0 else 1.0) * weight
        y -= 0.020 * sin(chi) * fabs(sin(chi)) * weight
        n -= 0.002 * sin(2.0 * chi) * weight * s.L
    return x, y, n


@njit(**JIT)
def three_dof(kind, c, s, p, x, d, fx, fy, fn, out):
    """out[:6] = derivative of u, v, r, north, east, psi under rudder d and further forces fx, fy, fn."""
    u, v, r, psi = x[0], x[1], x[2], x[5]
    co, si = cos(psi), sin(psi)
    uc, vc = p.current_north * co + p.current_east * si, -p.current_north * si + p.current_east * co
    ur, vr = u - uc, v - vc
    kept, wake = rudder_kept(p, d), wake_kept(p, ur, vr)
    if kind == 0:
        xx, yy, nn = mariner_force(c, s, ur, vr, r, d, kept)
    elif kind == 1:
        xx, yy, nn = s175_force(c, s, ur, vr, r, d, kept, wake)
    else:
        xx, yy, nn = kvlcc2_force(c, s, ur, vr, r, d, kept, wake)
    x1, y1, n1 = added_force(s, p, ur, vr, r, psi, u, v)
    xx, yy, nn = xx + x1 + fx, yy + y1 + fy, nn + n1 + fn
    f = p.mass_fraction
    m11, m22, m33 = s.m11 + f * s.m, s.m22 + f * s.m, s.m33 + f * s.iz
    m23, m32 = s.m23 + f * s.mxg, s.m32 + f * s.mxg
    det = m22 * m33 - m23 * m32
    out[0] = xx / m11 + r * vc
    out[1] = (m33 * yy - m23 * nn) / det - r * uc
    out[2] = (m22 * nn - m32 * yy) / det
    out[3] = u * co - v * si
    out[4] = u * si + v * co
    out[5] = r


@njit(**JIT)
def response(kind, c, s, p, x, d, fn, out):
    """out[:6] for a response ship: x[0] its speed U, x[1] = r_dot - K T3/h delta (second order), x[2] yaw rate.

    T r_dot + r + alpha r^3 = K delta; h r_ddot + g r_dot + r + alpha r^3 = K (delta + T3 delta_dot).  With speed loss
    U falls as U_dot = (U0 - U)/recovery - drop U0 (r L/U0)^2 / recovery and every term keeps its prime value.
    """
    u, r, psi = x[0], x[2], x[5]
    k = u / s.U0
    d *= rudder_kept(p, d)
    if kind == 3:
        damping = k * r + c[2] / k * r**3 + p.r_quadratic * r * fabs(r) + p.r_cubic / k * r**3
        out[2] = (c[1] * k * k * d - damping) / c[0] + fn
        out[1] = 0.0
    else:
        lead = c[2] * c[3] / c[0] * k * k
        rate = x[1] + lead * d
        damping = k * k * r + c[4] * r**3 + k * p.r_quadratic * r * fabs(r) + p.r_cubic * r**3
        out[2] = rate
        out[1] = (c[2] * k**3 * d - c[1] * k * rate - damping) / c[0] + fn
    out[0] = 0.0
    if p.recovery > 0.0:
        turn = r * s.L / s.U0
        out[0] = (s.U0 - u - p.drop * s.U0 * turn * turn) / p.recovery
    out[3] = u * cos(psi)
    out[4] = u * sin(psi)
    out[5] = r


@njit(**JIT)
def derivative(kind, c, s, p, extra, functions, t, x, d, fx, fy, fn, work, out):
    """out (8,) = dx/dt of u, v, r, north, east, psi and two hidden states; d is the rudder angle at the hull.

    extra (m, 6) and functions (m of them): further forces and what each gets (`effects.forces`); work (5,) is scratch.
    """
    out[6] = out[7] = 0.0
    i = 0
    for function in functions:
        work[:] = 0.0
        function(extra[i], t, x, d, s.L, s.U0, work)
        i += 1  # noqa: SIM113, numba takes no enumerate of a tuple of functions
        fx, fy, fn = fx + work[0] * s.force, fy + work[1] * s.force, fn + work[2] * s.moment
        out[6] += work[3]
        out[7] += work[4]
    if kind <= 2:
        three_dof(kind, c, s, p, x, d, fx, fy, fn, out)
    else:
        response(kind, c, s, p, x, d, fn, out)


def ship_numbers(ship, force: float, moment: float) -> ShipNumbers:
    """The numbers s of a `ships.TrueShip`; force and moment are the units of further forces."""
    m = ship.mass
    matrix = m[0, 0], m[1, 1], m[1, 2], m[2, 1], m[2, 2]
    own = ship.rho, ship.primes[0], ship.length_m, ship.speed_m_s, ship.propeller_rps, *ship.rigid, *matrix
    return ShipNumbers(*map(float, (*own, *ship.windage, force, moment)))
