"""Read a robot's file by other engines directly, not by way of what mecanique writes."""
