"""Sheets graded and exercises made."""

from mecanique.teaching.exercise import Exercise, make_exercise
from mecanique.teaching.marks import Grades, Mark, grade

__all__ = ["Exercise", "Grades", "Mark", "grade", "make_exercise"]
