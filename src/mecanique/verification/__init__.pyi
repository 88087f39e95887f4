"""The names of this room and where they live; `mecanique.lazy` reads this."""

from mecanique.verification.compare import verify as verify
from mecanique.verification.transformation import (
    Transformation as Transformation,
    compare_coordinates as compare_coordinates,
)
from mecanique.verification.verdict import (
    LikelyCause as LikelyCause,
    Row as Row,
    Verdict as Verdict,
)
