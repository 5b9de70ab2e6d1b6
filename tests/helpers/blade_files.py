"""A short blade with couplings: BeamDyn input files and a GXBeam-style description of it, as text and numbers."""

import numpy as np

MU = (1.0e-3, 1.2e-3, 1.4e-3, 1.8e-3, 2.2e-3, 2.6e-3)

HEAD = """ ------- BEAMDYN INDIVIDUAL BLADE INPUT FILE ----
 A short blade with couplings
---------------------- BLADE PARAMETERS ----
3      station_total    - Number of blade input stations (-)
1      damp_type        - Damping type
---------------------- DAMPING COEFFICIENT ----
   mu1        mu2        mu3        mu4        mu5        mu6
   (-)        (-)        (-)        (-)        (-)        (-)
1.0E-03    1.2E-03    1.4D-03     0.0018      0.0022     0.0026
"""
MODAL = """------ Modal Damping [used only if damp_type=2] ----
4                        n_modes    - Number of modal damping coefficients (-)
0.01 0.02 0.03 0.04      zeta       - Damping coefficients
"""
PRIMARY = """--------- BEAMDYN with OpenFAST INPUT FILE ----
A short blade
---------------------- SIMULATION CONTROL ----
True          Echo            - Echo input data
---------------------- GEOMETRY PARAMETER ----
          1   member_total    - Total number of members (-)
          4   kp_total        - Total number of key points (-)
     1     4                  - Member number; Number of key points in this member
   kp_xr         kp_yr         kp_zr        initial_twist
    (m)           (m)           (m)            (deg)
 0.0  0.0  0.0  13.0
 0.1  0.0  2.0   9.0
 0.2  0.1  4.0   4.0
 0.5  0.3  7.0   0.0
---------------------- MESH PARAMETER ----
          5   order_elem
"""


def matrices(k):
    """Stiffness and mass of the k-th station, coupled, as numbers with few digits."""
    factor = 1.0 - 0.3 * k
    stiffness = np.diag([3.0e8, 3.2e8, 4.5e9, 7.0e8, 9.0e8, 1.1e9]) * factor
    for i, j, value in ((2, 3, 2.0e8), (2, 4, -1.5e8), (0, 5, 3.0e7), (4, 5, -4.0e7)):
        stiffness[i, j] = stiffness[j, i] = value * factor
    mass, y, x = 300.0 * factor, 0.05, -0.1
    inertia = np.diag([mass, mass, mass, 40.0 * factor, 60.0 * factor, 100.0 * factor])
    for i, j, value in ((0, 5, -mass * y), (1, 5, mass * x), (2, 3, mass * y), (2, 4, -mass * x)):
        inertia[i, j] = inertia[j, i] = value
    return stiffness, inertia


def rows(matrix):
    return "\n".join("  ".join(f"{value:14.6E}" for value in row) for row in matrix)


def blade_text(head=HEAD, modal="", stations=(0.0, 0.4, 1.0)):
    parts = [head + modal + "---------------------- DISTRIBUTED PROPERTIES ----"]
    for k, station in enumerate(stations):
        stiffness, inertia = matrices(k)
        parts += [f"  {station:.6f}", rows(stiffness), "", rows(inertia), ""]
    return "\n".join(parts) + "\n"


PLACES = [2, 0, 1, 5, 3, 4]


def assembly(**changes):
    stiffness, inertia = matrices(0)
    given = {
        "points": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        "stiffness": stiffness[np.ix_(PLACES, PLACES)].tolist(),
        "mass": inertia[np.ix_(PLACES, PLACES)].tolist(),
        "damping": [0.01, 0.02, 0.03, 0.04, 0.05, 0.06],
    }
    return {key: value for key, value in (given | changes).items() if value is not None}
