"""What engines read from a file itself, not from what mecanique writes."""
