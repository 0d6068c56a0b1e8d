"""gauge_tables.py CH5_GAUGE OUT: the tables of ./course plots gauge in OUT/csv, from a few trials of each study."""

import sys
from pathlib import Path

from tests.experiments.programs_under_test import make_trials

TRIALS = {"methods": 3, "sweep": 1, "near_start": 2, "variants": 2, "convergence": 2, "spectrum": 1, "covariance": 1, "deviations": 1, "matrices": 1,
          "prior_choice": 1, "audit": 1}

if __name__ == "__main__":
    for study, trials in TRIALS.items():
        make_trials(sys.argv[1], study, trials, Path(sys.argv[2]) / "csv" / f"{study}.csv")
