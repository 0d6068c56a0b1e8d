#!/usr/bin/python3
"""Draws how the solve converges against the prior's weight: iterations, time, and RMSE of the positions."""
import argparse
import sys
from pathlib import Path

import numpy as np

from . import prior, style
from .tables import Table, TableError, read_table

TABLE = ("a table such as out/csv/prior_sweep.csv; the columns weight, iterations, milliseconds and rmse_position [m] are "
         "drawn, a line for each word in the column variant, where there is one")
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
    parser = argparse.ArgumentParser(prog="plot_prior_weight.py", description=__doc__.partition("\n")[0])
    parser.add_argument("csv", metavar="CSV", type=Path, help=TABLE)
    parser.add_argument("-o", metavar="FILE", type=Path, dest="target",
                        help="the picture: .png, .svg or .pdf; default: prior_weight.png in the folder of the table")
    words = parser.parse_args(arguments)
    target = words.target or words.csv.with_name("prior_weight.png")
    if target.suffix not in style.METADATA:
        parser.error(f"{target}: cannot draw '{target.suffix}', only {', '.join(style.METADATA)}")
    try:
        style.save_as(prior.sweep_figure(read_sweep(words.csv)), target)
    except (TableError, OSError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    print(target)


if __name__ == "__main__":
    main(sys.argv[1:])
