"""Reads the tables that ./course run writes."""

import csv
import math
import os
from pathlib import Path


class MissingTable(Exception):
    """A table that is not there or lacks a column; the message says what to do."""


class Tables:
    """The CSV files of one folder, read once each; a cell is a number where it can be one.

    A table that is in the folder `kept` is taken from there.
    """

    def __init__(self, folder, kept=None):
        self.folder, self.kept, self._cache = Path(folder), kept, {}

    def rows(self, name, **where):
        """All rows of NAME.csv, as dictionaries, whose columns equal `where`."""
        if name not in self._cache:
            path = Path(os.path.normpath(self.folder / f"{name}.csv"))  # "../nees/csv/consistency" without a csv
            if self.kept and (self.kept / path.name).exists():
                path = self.kept / path.name
            self._cache[name] = self._read(path)
        found = [row for row in self._cache[name] if all(row[key] == value for key, value in where.items())]
        if not found:
            raise MissingTable(f"{self.folder / name}.csv has no row with {where}")
        return found

    def row(self, name, **where):
        """The only row that equals `where`."""
        found = self.rows(name, **where)
        if len(found) != 1:
            raise MissingTable(f"{self.folder / name}.csv has {len(found)} rows with {where}, one is wanted")
        return found[0]

    def column(self, name, column, **where):
        rows = self.rows(name, **where)
        if column not in rows[0]:
            raise MissingTable(f"{name}.csv has no column {column}: it is of an older version; run ./course run again")
        return [row[column] for row in rows]

    def matrix(self, name, **where):
        """A table of row, column, value as a dictionary {(row, column): value}."""
        return {(int(r["row"]), int(r["column"])): r["value"] for r in self.rows(name, **where)}

    @staticmethod
    def _read(path):
        if not path.exists():
            raise MissingTable(f"{path} is missing; run ./course run first")
        with open(path, newline="", encoding="utf-8") as file:
            return [{key: _cell(text) for key, text in row.items()} for row in csv.DictReader(file)]


def _cell(text):
    try:
        return float(text) if text else math.nan
    except (TypeError, ValueError):
        return text
