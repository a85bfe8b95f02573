"""What is done with fitted laws: comparison, extrapolation, claims, selection, bearing torque."""
