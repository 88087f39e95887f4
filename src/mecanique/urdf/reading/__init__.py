"""The elements of a URDF file, read one by one."""
