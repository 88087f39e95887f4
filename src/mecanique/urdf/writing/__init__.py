"""The parts of a URDF file, written one by one."""
