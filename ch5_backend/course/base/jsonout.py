"""The one JSON object that --json promises on standard output."""

import csv
import json
import math
import sys
from pathlib import Path


def emit(fields: dict) -> None:
    """Prints the object on a line of its own; letters that standard output cannot take become JSON's escapes."""
    text = json.dumps(fields, ensure_ascii=False, allow_nan=False)
    try:
        text.encode(sys.stdout.encoding)
    except UnicodeEncodeError:
        text = json.dumps(fields, allow_nan=False)
    print(text, flush=True)


def read_summary(path: Path) -> dict:
    """Reads a summary.csv of key,value rows."""
    return {row["key"]: row["value"] for row in read_rows(path)}


def read_rows(path: Path) -> list:
    """Reads a table: one dictionary a row. Numbers become numbers; empty cells, and numbers that JSON cannot hold, null."""
    with open(path, newline="", encoding="utf-8") as file:
        return [{key: _value(text) for key, text in row.items()} for row in csv.DictReader(file)]


def _value(text: str):
    if text == "":
        return None
    for kind in (int, float):
        try:
            number = kind(text)
        except ValueError:
            continue
        return number if math.isfinite(number) else None
    return text
