"""Faults of wording, which are read, and what of the chapter is not checked, with the reason."""

from __future__ import annotations

from collections.abc import Iterator

from mecanique.verification.chapter.row import ChapterRow, misread, open_point


def sentences() -> Iterator[ChapterRow]:
    """Yield the rows."""
    yield from _wording()
    yield from _open_points()


def _wording() -> Iterator[ChapterRow]:
    yield misread(
        "sect. 1.1 a",
        "mass is called a measure of how a body resists motion",
        right="a measure of how it resists a change of its motion",
        proof="by the first law nothing resists a uniform motion; in F = m a mass resists a",
    )
    yield misread(
        "before 1.3",
        "the law of angular momentum lacks a word before 'all the external forces'",
        right="the resultant moment, at the same point, of all the external forces",
        proof="a moment is that of forces; eqs. 1.8 and 1.10 are worded so",
    )
    yield misread(
        "before 1.11",
        "the center is written 'center or mass'",
        right="center of mass",
        proof="it is the point of eq. 1.5",
    )
    yield misread(
        "after 1.27",
        "the right side of eq. 1.27 is explained without saying what of the external forces it is",
        right="the virtual work done by the external forces during the same virtual displacement",
        proof="the left side is explained as the virtual work done by the internal forces",
    )
    yield misread(
        "before 1.27",
        "the principle of virtual work is spelled as a 'principal', here and twice below",
        right="principle",
        proof="the definition above eq. 1.27 spells it so",
    )
    yield misread(
        "sect. 1.3.5",
        "of theory and applications it says that neither has 'by no means' been exhausted",
        right="neither has by any means been exhausted",
        proof="the two negations cancel, and the opposite is meant",
    )


def _open_points() -> Iterator[ChapterRow]:
    yield open_point(
        "sect. 1.1 c",
        "space, time, inertial frames, and equality of inertial and gravitational mass",
        "assumptions and experience, which no computation decides",
    )
    yield open_point(
        "sect. 1.1 d",
        "classical mechanics does for slow and large bodies, the earth for an inertial frame",
        "the chapter gives no measure; how far it errs depends on the problem",
    )
    yield open_point(
        "sect. 1.3.1 b",
        "the forces of two particles on each other act along the line through both",
        "an assumption, from which eqs. 1.10 and 1.12 follow",
    )
    yield open_point(
        "sect. 1.2 c",
        "independent coordinates, as many as degrees of freedom, can always be found",
        "true near any regular position; one set need not reach every position (a sphere has none)",
    )
    yield open_point(
        "sect. 1.3.1",
        "Newton's laws as quoted, and dates, pages and editions of the works cited",
        "history; D. T. Greenwood's Classical Dynamics is usually dated 1977, not 1997",
    )
    yield open_point(
        "of 1.2-1.13",
        "the laws of systems of particles hold for every body",
        "checked on one cloud of particles and one plate, which is no proof for all",
    )
    yield open_point(
        "of 1.27-1.30",
        "the principles of virtual work and of Lagrange hold for every holonomic system",
        "checked on the systems that the rows name, which is no proof for all",
    )
    yield open_point(
        "of 1.20",
        "how small an amplitude must be for the linear equation to do",
        "the chapter gives no measure; only the linear equation itself is checked",
    )
    yield open_point(
        "figures", "Figures 1.1 to 1.15", "only what the text says of them was at hand"
    )
    yield open_point(
        "sect. 1.3.4 b",
        "which method is easier, and what engineers prefer",
        "a judgment, also in sect. 1.3 and 1.3.5",
    )
    yield open_point(
        "spelling",
        "other slips of spelling and grammar, and marks of vectors and indices left out",
        "only those are listed that change what is meant or leave it open",
    )
