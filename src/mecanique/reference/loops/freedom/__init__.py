"""The motion that loops leave free: its count, its coordinates, its singular positions."""
