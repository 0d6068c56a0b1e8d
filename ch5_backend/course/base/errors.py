"""How a command ends when it cannot do what was asked."""

import sys

from .language import speaker


class CourseError(Exception):
    """A message for the user, in English or as data (see language), and the exit code: 2 for bad input or a bad place, 1 for
    work that failed."""

    def __init__(self, message, exit_code: int = 2):
        super().__init__(message)
        self.message, self.exit_code = message, exit_code

    def __str__(self) -> str:
        return speaker("en").text(self.message)


def warn(text: str) -> None:
    """A line for who reads the terminal, which standard output may not be."""
    print(f"course: {text}", file=sys.stderr)
