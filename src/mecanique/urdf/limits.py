"""The largest trees given to Pinocchio; larger ones fill the memory or end the process."""

from __future__ import annotations

MOST_VELOCITIES = 210
"""Its work space takes about 63 bytes times the cube of the number of velocities: 0.6 GB at 210."""

MOST_DEPTH = 1000
"""Its parser recurses along the tree; a few thousand joints in a row end the process."""
