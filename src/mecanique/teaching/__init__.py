"""Sheets graded, and exercises made and exported."""

from mecanique.teaching.benchmark import Score, Task, make_tasks, score_answers
from mecanique.teaching.class_page import write_class_page
from mecanique.teaching.course_formats import COURSES, export_exercise
from mecanique.teaching.exercise import Exercise, make_exercise
from mecanique.teaching.marks import Grades, Mark, grade, mark_answer

__all__ = [
    "COURSES",
    "Exercise",
    "Grades",
    "Mark",
    "Score",
    "Task",
    "export_exercise",
    "grade",
    "make_exercise",
    "make_tasks",
    "mark_answer",
    "score_answers",
    "write_class_page",
]
