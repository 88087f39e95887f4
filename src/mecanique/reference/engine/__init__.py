"""Run Pinocchio: the model read from URDF text, its quantities, and the loads on it."""
