"""Run the written code, and compare it with Pinocchio."""
