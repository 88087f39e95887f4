"""The names of this room and where they live; `mecanique.lazy` reads this."""

from mecanique.generation.languages import Code as Code
from mecanique.generation.languages import generate as generate
from mecanique.generation.named_results import write_recursion as write_recursion
