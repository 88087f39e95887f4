"""Constraints of loops and contacts from Pinocchio's kinematics, and the parts they form."""
