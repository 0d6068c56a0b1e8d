"""The one reader of tables, CSV files as columns of numbers or words, and their one writer."""
import csv
import os
from functools import lru_cache
from pathlib import Path

import numpy as np

from .atomic_write import atomic_write


class TableError(Exception):
    """A table that cannot be read; the message names the file, and the line where there is one."""


class Table:
    """The columns of a CSV file as arrays: of floats where all cells are numbers or empty (NaN), else of words."""

    def __init__(self, columns):
        self.columns = columns

    def __getitem__(self, name):
        return self.columns[name]

    def __len__(self):
        return len(next(iter(self.columns.values())))

    def where(self, **conditions):
        """The rows in which every named column has the given value."""
        keep = np.ones(len(self), dtype=bool)
        for name, value in conditions.items():
            keep &= self.columns[name] == value
        return Table({name: column[keep] for name, column in self.columns.items()})

    def matrix(self, *names):
        """These columns side by side."""
        return np.column_stack([self.columns[name] for name in names])

    def rows(self):
        """Each row as a dictionary."""
        return [dict(zip(self.columns, cells)) for cells in zip(*(column.tolist() for column in self.columns.values()))]

    def row(self, **conditions):
        """The only such row, as a dictionary."""
        rows = self.where(**conditions)
        if len(rows) != 1:
            raise TableError(f"{len(rows)} rows have {conditions}, expected one")
        return {name: column[0] for name, column in rows.columns.items()}


def _are_names(cells):
    """Names of digits, of which a float would round some."""
    return all(cell.isdigit() for cell in cells) and max(map(int, cells)) > 2**53


def _numbers_or_words(cells):
    if not cells:
        return np.empty(0, dtype=object)  # of any kind: it can be compared with numbers and words
    if _are_names(cells):
        return np.array(cells)
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells)


def read(directory, name, folder="csv", may_be_empty=False):
    """DIR/FOLDER/NAME.csv, see read_table(); read once, unless it has been written anew."""
    path = Path(directory) / folder / f"{name}.csv"
    stamp = (path.stat().st_mtime_ns, path.stat().st_size) if path.exists() else None
    return _read_once(path, may_be_empty, stamp)


def read_summary(directory):
    """DIR/summary.csv, of rows of key and value, as a dictionary of words."""
    table = read(directory, "summary", folder="")
    return dict(zip(table["key"], table["value"]))


@lru_cache(maxsize=64)
def _read_once(path, may_be_empty, _):
    return read_table(path, may_be_empty)


def read_table(path, may_be_empty=False, numbers=()):
    """A CSV file as a Table; TableError if it is missing, ragged or, unless it may be empty, without rows, or if one of
    the columns `numbers` is missing or holds anything but finite numbers."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise TableError(f"cannot read {path}: {error}") from error
    if len(rows) < (1 if may_be_empty else 2):
        raise TableError(f"{path}: no rows")
    for line, row in enumerate(rows, start=1):
        if len(row) != len(rows[0]):
            raise TableError(f"{path}, line {line}: {len(row)} cells under a header of {len(rows[0])}")
    for name in numbers:
        _check_numbers(path, rows, name)
    columns = zip(*rows[1:]) if len(rows) > 1 else [()] * len(rows[0])
    return Table({head: _numbers_or_words(column) for head, column in zip(rows[0], columns)})


def write(path, head, rows):
    """A CSV file, whole or not at all; None is an empty cell."""
    with atomic_write(path) as partial, open(partial, "w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows((head, *rows))


def _check_numbers(path, rows, name):
    if name not in rows[0]:
        raise TableError(f"{path}, line 1: there is no column '{name}' among {', '.join(rows[0])}")
    for line, row in enumerate(rows[1:], start=2):
        cell = row[rows[0].index(name)]
        try:
            known = np.isfinite(float(cell))
        except ValueError:
            known = False
        if not known:
            raise TableError(f"{path}, line {line}: {name} is '{cell}', expected a number")


def dense(table, rows=None, columns=None):
    """The matrix that a table of row, column, value holds; square up to its last entry unless its size is given."""
    rows = rows or int(max(table["row"].max(), table["column"].max())) + 1
    matrix = np.zeros((rows, columns or rows))
    matrix[table["row"].astype(int), table["column"].astype(int)] = table["value"]
    return matrix


class Tables:
    """The tables of one folder: tables("prior_sweep", variant="course") has the rows of that variant.

    A table that is in the folder `kept` is taken from there. Raises TableError also where no row is left.
    """

    def __init__(self, folder, kept=None):
        self.folder, self.kept = Path(folder), kept

    def __call__(self, name, **where):
        path = Path(os.path.normpath(self.folder / f"{name}.csv"))  # "../nees/csv/consistency" without a csv
        if self.kept and (self.kept / path.name).exists():
            path = self.kept / path.name
        if not path.exists():
            words = [f"{path} is missing"]
            if self.folder != self.kept:
                words.append("run ./course run first")
            if self.kept:
                words.append(f"git checkout {self.kept} brings back the tables that the project keeps")
            raise TableError("; ".join(words))
        table = read(path.parent, path.stem, folder="")
        if old := set(where) - set(table.columns):
            raise TableError(f"{name}.csv has no column {', '.join(sorted(old))}: run ./course run again")
        found = table.where(**where)
        if not len(found):
            raise TableError(f"{self.folder / name}.csv has no row with {where}")
        return found
