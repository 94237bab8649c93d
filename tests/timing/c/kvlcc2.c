/* MMG standard method, Yasukawa & Yoshimura 2015, equation by equation in SI units; velocities at midship. */

#define STATES 6
#define INPUTS 2
#define NUMBERS(F) \
    F(R_0) F(X_vv) F(X_vr) F(X_rr) F(X_vvvv) F(Y_v) F(Y_r) F(Y_vvv) F(Y_vvr) F(Y_vrr) F(Y_rrr) \
    F(N_v) F(N_r) F(N_vvv) F(N_vvr) F(N_vrr) F(N_rrr) F(t_R) F(a_H) F(x_R) F(x_H) \
    F(L) F(d) F(nabla) F(x_G) F(I_zz) F(rho) F(m_x) F(m_y) F(J_z) F(D_P) F(t_P) F(w_P0) F(x_P) \
    F(C_1) F(C_2_plus) F(C_2_minus) F(k_0) F(k_1) F(k_2) F(H_R) F(A_R) F(f_alpha) F(epsilon) F(kappa) \
    F(l_R) F(gamma_R_plus) F(gamma_R_minus)
#define DERIVED(F) F(mx) F(my) F(xgm) F(jz) F(det) F(hull) F(disc) F(foil) F(eta) F(lever)

enum { NUMBERS(PLACE) DERIVED(PLACE) KEPT };

static void prepare(const double *numbers, double *kept) {
    EACH_RUN {
        NUMBERS(LOAD)
        double added = 0.5 * rho * L * L * d, m = rho * nabla;
        double mx = m + m_x * added;
        double my = m + m_y * added;
        double xgm = x_G * m;
        double jz = I_zz + J_z * added * L * L;
        double det = my * jz - xgm * xgm;
        double hull = 0.5 * rho * L * d;
        double disc = rho * D_P * D_P * D_P * D_P;
        double foil = 0.5 * rho * A_R * f_alpha;
        double eta = D_P / H_R;
        double lever = (x_R + a_H * x_H) * L;
        NUMBERS(STORE) DERIVED(STORE)
    }
}

static void rates(const double *restrict numbers, const double *restrict x, const double *restrict in,
                  double *restrict dx) {
    EACH_RUN {
        NUMBERS(LOAD) DERIVED(LOAD)
        double u = STATE(0), v = STATE(1), r = STATE(2), psi = STATE(5), delta = INPUT(0), n = INPUT(1);
        double U = sqrt(u * u + v * v), vp = v / U, rp = r * L / U, beta = atan2(-v, u);

        double beta_P = beta - x_P * rp, C_2 = beta_P > 0 ? C_2_plus : C_2_minus;
        double w = (1 - w_P0) * (1 + (1 - exp(-C_1 * fabs(beta_P))) * (C_2 - 1)); /* 1 - w_P */
        double J = u * w / (n * D_P), K_T = k_0 + k_1 * J + k_2 * J * J;
        double X_P = (1 - t_P) * disc * n * n * K_T;

        double race = 1 + kappa * (sqrt(1 + 8 * K_T / (M_PI * J * J)) - 1);
        double u_R = epsilon * u * w * sqrt(eta * race * race + 1 - eta);
        double beta_R = beta - l_R * rp, v_R = U * (beta_R > 0 ? gamma_R_plus : gamma_R_minus) * beta_R;
        double F_N = foil * (u_R * u_R + v_R * v_R) * sin(delta - atan2(v_R, u_R));
        double X_R = -(1 - t_R) * F_N * sin(delta);
        double Y_R = -(1 + a_H) * F_N * COS(delta);
        double N_R = -lever * F_N * COS(delta);

        double q = hull * U * U, v2 = vp * vp, r2 = rp * rp;
        double X_H = q * (-R_0 + X_vv * v2 + X_vr * vp * rp + X_rr * r2 + X_vvvv * v2 * v2);
        double Y_H = q * (Y_v * vp + Y_r * rp + Y_vvv * v2 * vp + Y_vvr * v2 * rp + Y_vrr * vp * r2
                          + Y_rrr * r2 * rp);
        double N_H = q * L * (N_v * vp + N_r * rp + N_vvv * v2 * vp + N_vvr * v2 * rp
                                 + N_vrr * vp * r2 + N_rrr * r2 * rp);

        double X = X_H + X_R + X_P + my * v * r + xgm * r * r;
        double Y = Y_H + Y_R - mx * u * r, N = N_H + N_R - xgm * u * r;
        RATE(0) = X / mx;
        RATE(1) = (jz * Y - xgm * N) / det;
        RATE(2) = (my * N - xgm * Y) / det;
        RATE(3) = u * COS(psi) - v * sin(psi);
        RATE(4) = u * sin(psi) + v * COS(psi);
        RATE(5) = r;
    }
}
