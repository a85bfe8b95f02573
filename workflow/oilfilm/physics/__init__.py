"""Contact, film, oils and thermal traction: NumPy in, NumPy out."""
