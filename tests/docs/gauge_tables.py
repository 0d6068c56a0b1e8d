"""gauge_tables.py CH5_GAUGE OUT: the tables of ./course plots gauge in OUT/csv, from a few trials of each study."""

import subprocess
import sys
from pathlib import Path

TRIALS = {"methods": 3, "sweep": 1, "near_start": 2, "variants": 2, "convergence": 2, "spectrum": 1, "covariance": 1, "deviations": 1, "matrices": 1,
          "prior_choice": 1, "audit": 1}


def main(program, out):
    folder = Path(out) / "csv"
    folder.mkdir(parents=True, exist_ok=True)
    for study, trials in TRIALS.items():
        table, text = folder / f"{study}.csv", ""
        for trial in range(trials):
            subprocess.run([program, study, "--trial", str(trial), "--out", str(table)], check=True)
            rows = table.read_text(encoding="utf-8")
            text += rows if trial == 0 else rows.partition("\n")[2]
        table.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
