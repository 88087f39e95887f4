"""Other formats of robots: MJCF and SDF in, MJCF out."""
