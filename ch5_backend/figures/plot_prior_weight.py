#!/usr/bin/python3
"""Draws how the solve converges against the prior's weight: iterations, time, and RMSE of the positions.

usage: plot_prior_weight.py CSV [-o FILE]

  CSV       a table such as out/csv/prior_sweep.csv; the columns weight, iterations, milliseconds and rmse_position [m]
            are drawn, a line for each word in the column variant, where there is one
  -o FILE   the picture: .png, .svg or .pdf; default: prior_weight.png in the folder of the table
"""
import sys
from pathlib import Path

import numpy as np

from . import prior, style
from .tables import Table, TableError, read_table

COLUMNS = ("weight", "iterations", "milliseconds", "rmse_position")


def read_sweep(path):
    """The table, each variant by ascending weight; TableError names file, line and value."""
    table = read_table(path, numbers=COLUMNS)
    for line, (weight, iterations, milliseconds) in enumerate(zip(*(table[name] for name in COLUMNS[:3])), start=2):
        for name, value, bad in (("weight", weight, weight < 0), ("iterations", iterations, iterations < 0),
                                 ("milliseconds", milliseconds, milliseconds <= 0)):
            if bad:
                raise TableError(f"{path}, line {line}: {name} is {value:g}, which cannot be")
    if not np.any(table["weight"] > 0):
        raise TableError(f"{path}: no weight is above 0, so there is nothing to compare")
    order = np.argsort(table["weight"], kind="stable")
    return Table({name: column[order] for name, column in table.columns.items()})


def main(arguments):
    if arguments in (["-h"], ["--help"]):
        print(__doc__)
        return 0
    words = list(arguments)
    target = words.pop(words.index("-o") + 1) if "-o" in words[:-1] else None
    words = [word for word in words if word != "-o"] if target else words
    if len(words) != 1 or words[0].startswith("-"):
        print(f"plot_prior_weight.py: expected CSV [-o FILE], got '{' '.join(arguments)}'", file=sys.stderr)
        return 2
    target = Path(target or Path(words[0]).with_name("prior_weight.png"))
    if target.suffix not in style.METADATA:
        print(f"plot_prior_weight.py: {target}: cannot draw '{target.suffix}', only {', '.join(style.METADATA)}",
              file=sys.stderr)
        return 2
    try:
        style.save_as(prior.sweep_figure(read_sweep(words[0])), target)
    except (TableError, OSError) as error:
        print(f"plot_prior_weight.py: {error}", file=sys.stderr)
        return 2
    print(target)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
