"""The four tables that mmgdynamics ships (github.com/nikpau/mmgdynamics, calibrated_vessels.py): keys and numbers."""

SIZES = "C_b Lpp B d m I_zG x_G x_P D_p A_R rho"
HULL = "m_x m_y J_z R_0 X_vv X_vr X_rr X_vvvv Y_v Y_r Y_vvv Y_vvr Y_vrr Y_rrr N_v N_r N_vvv N_vvr N_vrr N_rrr x_H"
REST = "w_P0 J_int J_slo k_0 l_R gamma_R_plus gamma_R_minus eta kappa epsilon f_alpha t_R t_P a_H A_R/Ld_em"
THRUST_AND_WAKE = {"k_1": -0.2753, "k_2": -0.1359, "C_1": 2.0, "C_2_plus": 1.6, "C_2_minus": 1.1}


def table(sizes, hull, rest, **more):
    """Key -> number, of the numbers in the order of `SIZES`, `HULL` and `REST`."""
    names = [*SIZES.split(), *(f"{name}_dash" for name in HULL.split()), *REST.split()]
    return dict(zip(names, [*sizes, *hull, *rest], strict=True)) | more


KVLCC2_HULL = (
    0.022, 0.223, 0.011, 0.022, -0.04, 0.002, 0.011, 0.771, -0.315, 0.083, -1.607, 0.379, -0.391, 0.008, -0.137, -0.049,
    -0.03, -0.294, 0.055, -0.013, -0.464,
)  # fmt: skip
TABLES = {
    "seiunmaru": table(
        (0.508, 105.0, 17.91, 5.966, 5701565.0, 3928734632, -2.249, -52.5, 4.7, 13.405, 1000),
        (0.0167, 0.1576, 0.009, 0.016, -0.0804, 0.072, 0.022, 0.439, -0.317, 0.052, -1.604, -0.75, -0.8599, -0.051,
         -0.1136, -0.0795, -0.3095, -0.6257, -0.3143, -0.0502, -0.4),
        (0.204, 0.4, -0.4, 0.4, -0.947, 0.394, 0.312, 0.96, 0.676, 1.033, 2.88, 0.341, 0.21, 0.236, 1 / 46.8),
    ),
    "GMS1": table(
        (0.9, 110.0, 11.45, 1.631, 1848820.0, 1398170125.0, 0.0, -55.0, 1.7, 4.402, 1000),
        (0.009, 0.0423, 1.121e-6, 0.026, -0.0723, -0.0566, -0.116, 0.474, -0.177, 0.056, -1.297, -0.75, -0.3598, -0.051,
         -0.029, -0.0151, -0.039, -0.614, 0.014, -0.0326, -0.4),
        (0.4, 0.4, -0.4, 0.4, -0.9, 0.394, 0.312, 0.96, 0.475, 2.467, 2.45, 0.39, 0.2, 0.4113, 1 / 46.8),
        gamma_R=0.333, k_s=0.2,
    ),
    "kvlcc2": table(
        (0.81, 64, 11.6, 4.16, 2500800.0, 640204800, 2.24, -32, 1.972, 4.5, 1000), KVLCC2_HULL,
        (0.4, 0.4, -0.5, 0.2931, -0.71, 0.64, 0.395, 0.626, 0.5, 1.09, 2.747, 0.387, 0.22, 0.312, 1 / 46.8),
        **THRUST_AND_WAKE,
    ),
    "kvlcc2_full": table(
        (0.81, 320.0, 58.0, 20.8, 312600000.0, 2e12, 11.2, -160.0, 9.86, 112.5, 1000), KVLCC2_HULL,
        (0.35, 0.4, -0.5, 0.2931, -0.71, 0.64, 0.395, 0.626, 0.5, 1.09, 2.747, 0.387, 0.22, 0.312, 1 / 46.8),
        **THRUST_AND_WAKE,
    ),
}  # fmt: skip
