"""What engines read from the file itself, compared with what mecanique reads."""
