"""What loops and contacts demand, from Pinocchio's kinematics, and what shares a motion."""
