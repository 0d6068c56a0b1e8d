#!/usr/bin/env python3
"""A program of trials and a script that draws them, as ./course plots wants them, but small and known.

fake_trials.py STUDY --trial K --out FILE     writes the rows of one trial
fake_trials.py draw FOLDER                    writes FOLDER/figures from FOLDER/csv

FAKE_LOG takes a line a run, FAKE_SECONDS says how long one takes, and FAKE_FAILS which trial fails.
"""

import os
import sys
import time
from pathlib import Path


def draw(folder: Path) -> None:
    (folder / "figures").mkdir(exist_ok=True)
    (folder / "figures" / "fake.png").write_bytes(b"".join(sorted(file.read_bytes() for file in folder.glob("csv/*.csv"))))


def trial(study: str, k: int, file: str) -> None:
    with open(os.environ["FAKE_LOG"], "a", encoding="utf-8") as log:
        log.write(f"{study} {k}\n")
    with open(file, "w", encoding="utf-8") as out:
        out.write("study,trial,square\n")
        out.flush()
        time.sleep(float(os.environ.get("FAKE_SECONDS", "0")))
        if str(k) == os.environ.get("FAKE_FAILS"):
            sys.exit(f"fake_trials: trial {k} fails, as it was told to")
        out.writelines(f"{study},{k},{k * k + i}\n" for i in range(2))


if __name__ == "__main__":
    if sys.argv[1] == "draw":
        draw(Path(sys.argv[2]))
    else:
        trial(sys.argv[1], int(sys.argv[3]), sys.argv[5])
