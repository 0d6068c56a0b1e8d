"""How a command ends when it cannot do what was asked."""


class CourseError(Exception):
    """A message for the user and the exit code: 2 for bad input or a bad place, 1 for work that failed."""

    def __init__(self, message: str, exit_code: int = 2):
        super().__init__(message)
        self.exit_code = exit_code
