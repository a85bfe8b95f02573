"""What a fitted law comes to in a bearing: torque, cage slip, heat, and what to measure next."""
