"""The largest trees given to Pinocchio; larger ones fill the memory or end the process."""

from __future__ import annotations

MOST_VELOCITIES = 250
"""Its work space takes about 63 bytes times the cube of the number of velocities: 1.0 GB at 250."""

MOST_DEPTH = 1000
"""Its parser recurses along the tree; a few thousand joints in a row end the process."""
