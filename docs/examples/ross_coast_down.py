"""A shaft on two ball bearings, braked by oil-film traction: ROSS with the exported law.

    pip install ross-rotordynamics "plotly<7"     # ROSS 2.3 fails with plotly 7
    oilfilm export --printed
    python ross_coast_down.py

ROSS has the stiffness of a ball bearing, but no friction. Here every ball slides on the inner ring
at one slide-roll ratio, so that the ring has the torque

    M = n mu(P, U, T, S) Q r

with n balls, the load Q of a ball and the radius r of the groove. In a real bearing S follows from
the equilibrium of cage and balls (docs/explanation/bearing.md of oilfilm).
"""

import sys

import numpy as np
import ross

sys.path.insert(0, "printed-constants/4102_printed")
from traction_4102_printed import outside_tested_box, traction_coefficient

BALLS, BALL_DIAMETER_M, BALL_LOAD_N, GROOVE_RADIUS_M = 16, 0.0127, 150.0, 0.035
AT = (1.3, 35.0, 90.0, 0.05)  # GPa, m/s, degC, slide-roll ratio
SPEED_RAD_S = 1000.0

steel = ross.Material(name="steel", rho=7810, E=211e9, G_s=81.2e9)
shaft = [ross.ShaftElement(L=0.1, idl=0.0, odl=0.05, material=steel) for _ in range(4)]
disk = ross.DiskElement.from_geometry(n=2, material=steel, width=0.05, i_d=0.05, o_d=0.25)
bearings = [
    ross.BallBearingElement(
        n=node, n_balls=BALLS, d_balls=BALL_DIAMETER_M, fs=BALLS * BALL_LOAD_N, alpha=0.0
    )
    for node in (1, 3)
]
rotor = ross.Rotor(shaft, [disk], bearings)

mu = float(traction_coefficient(*AT))
torque_n_m = BALLS * mu * BALL_LOAD_N * GROOVE_RADIUS_M
times_s = np.linspace(0.0, 0.5, 5001)
forces = np.zeros((len(times_s), rotor.ndof))
for bearing in bearings:
    # the last of the six degrees of freedom of a node is the rotation about the shaft
    forces[:, rotor.number_dof * bearing.n + 5] = -torque_n_m
response = rotor.run_time_response(SPEED_RAD_S, forces, times_s)
angle = response.yout[-1, rotor.number_dof * 2 + 5]

polar_inertia = disk.Ip + sum(element.Im for element in shaft)
closed_form = -0.5 * 2 * torque_n_m / polar_inertia * times_s[-1] ** 2
print(f"mu = {mu:.5f}{', extrapolated' if outside_tested_box(*AT) else ''}")
print(f"friction torque of a bearing: {torque_n_m:.4f} N m")
print(f"angle lost in {times_s[-1]} s: {angle:.5f} rad; closed form {closed_form:.5f} rad")
