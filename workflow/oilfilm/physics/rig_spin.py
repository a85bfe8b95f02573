"""Spin in the contact of a ball-on-disc rig, which lowers the traction that it measures.

The disc turns about an axis at the distance R2 of the contact. Hence its surface turns about the
normal of the contact, and slides across it at the edges, also without slip. The ball's axis is
parallel to the disc, so that the ball has no such spin.

Decides: how much the spin of a rig lowers the traction coefficient.
"""

import numpy as np

from oilfilm.base.units import FloatArray
from oilfilm.physics.contact import Floats

# The correction holds where the slip is above this multiple of the slip at the edge.
SMALLEST_SLIP_OVER_EDGE_SLIP = 2.0


def edge_slip(contact_radius_m: Floats, disc_track_radius_m: Floats) -> FloatArray:
    """Slide-roll ratio by spin at the edge of the contact, e = a/R2.

    Args:
        contact_radius_m: Radius a of the contact.
        disc_track_radius_m: Distance R2 of the contact from the axis of the disc.
    """
    return np.asarray(contact_radius_m / np.asarray(disc_track_radius_m))


def spin_correction(
    slide_roll_ratio: Floats,
    mu: Floats,
    mu_slope: Floats,
    mu_curvature: Floats,
    slip_at_edge: Floats,
) -> FloatArray:
    """Share of mu by which the spin of the rig lowers it.

        mu = mu_m - (e^2/10) (mu_m'' + mu_m'/S - mu_m/S^2)

    with the measured mu_m(S). A point of the contact slides by (S - e y, e x), with x and y over
    the radius; traction is against it. The mean over Hertz's pressure, with the mean squares 1/5 of
    x and y, is developed to second order in e.

    Args:
        slide_roll_ratio: S, above 0.
        mu: Measured mu_m at S.
        mu_slope: Derivative of mu_m by S.
        mu_curvature: Second derivative of mu_m by S.
        slip_at_edge: e, of `edge_slip`.

    Returns:
        mu/mu_m - 1 where S is above 2 e, else NaN.

    Validity: right to 0.3 % of mu at S = 0.01 and a pressure of 1.5 GPa on a 20 mm ball.

    Examples:
        A plateau of mu at S = 4 e lacks 1/160:

        >>> print(f"{spin_correction(0.02, 0.03, 0.0, 0.0, 0.005):.5f}")
        0.00625
    """
    slip = np.asarray(slide_roll_ratio, dtype=float)
    second_order_term = mu_curvature + mu_slope / slip - mu / slip**2
    correction = -(np.square(slip_at_edge) / 10) * second_order_term / mu
    return np.where(
        slip > SMALLEST_SLIP_OVER_EDGE_SLIP * np.asarray(slip_at_edge), correction, np.nan
    )
