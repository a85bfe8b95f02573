"""Angular-contact ball bearings: loads, motion of balls and cage, and what their friction costs."""
