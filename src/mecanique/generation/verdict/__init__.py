"""Run what was written, and compare it with Pinocchio."""
