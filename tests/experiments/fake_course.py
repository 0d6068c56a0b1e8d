"""./course with a single set of figures: that of fake_trials.py, or of the program that FAKE_PROGRAM names."""

import os
import shlex
import sys
from pathlib import Path

from ch5_backend.course import __main__
from ch5_backend.course.experiments import figure_sets

TRIALS = shlex.quote(str(Path(__file__).resolve().with_name("fake_trials.py")))
figure_sets.SETS = (figure_sets.FigureSet(
    "fake", "fake", figure_sets.csv("squares cubes"), shlex.quote(os.environ["FAKE_PROGRAM"]) if "FAKE_PROGRAM" in os.environ else TRIALS,
    TRIALS + " draw {folder}", (1, 1), trials={"squares": (10, 3), "cubes": (4, 2)}),)

if __name__ == "__main__":
    sys.exit(__main__.main(sys.argv[1:]))
