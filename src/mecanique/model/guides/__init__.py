"""What holds joints on the coordinate map without being described."""
