"""Tables of numbers as loggers write them: columns by their names, units by names or sizes, clocks by their rates."""

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

RADIANS, GRAVITY = np.pi / 180, 9.81
IMU_RATES, IMAGE_RATES = (8.0, 4000.0), (1.5, 300.0)  # [Hz], between which the unit of stamps is clear
QUANTITIES = (("gyroscope", re.compile(r"gyr|omega|ang.*vel|rot.*rate|^g?w$|^[gw]$")), ("accelerometer", re.compile(r"acc|^a$|^i?a$|^gf$|g_?force|grav_incl")))


@dataclass
class Table:
    path: Path
    names: list  # of the columns, [] if the file has none
    values: np.ndarray  # NaN where there is no number
    lines: list = field(default_factory=list)  # the words of each row
    cut: int = 0  # rows that are left out, since they have fewer or more columns

    def times(self, rates) -> list:
        """Columns that never decrease much and have a possible rate: [(name, stamps [ns])], in the file's order."""
        found = []
        for k, name in enumerate(self.names or [""] * self.values.shape[1]):
            if self.names and not re.search(r"time|stamp|^t\b|^t_|_ns$|elapsed|\bsec", name) or "sample" in name:
                continue
            if (stamps := nanoseconds([row[k] for row in self.lines], rates)) is not None:
                found.append((name, stamps))
            if not self.names:
                break
        return found

    def vectors(self) -> dict:
        """{quantity: [columns of x, y, z]} by names, or by the file's name where columns are called x, y, z alone."""
        found = {}
        file = re.sub(r"[^a-z]+", "_", self.path.stem.lower())
        for k, name in enumerate(self.names):
            plain = re.sub(r"[\s_.-]*axis$", "", re.sub(r"[\[(].*", "", name).strip())
            axis = re.search(r"([xyz])(_(rad|deg|m).*)?$", plain)
            if not axis:
                continue
            stem = plain[:axis.start()].strip(" _.-")
            of = [quantity for quantity, words in QUANTITIES if words.search(stem if len(stem) > 0 else file)]
            if of and not re.search(r"quat|mag|orient|user|bias|drift", stem or file):
                found.setdefault((of[0], stem), {}).setdefault(axis[1], k)
        whole = {}
        for (quantity, _), axes in found.items():
            if len(axes) == 3:
                whole.setdefault(quantity, []).append([axes[axis] for axis in "xyz"])
        if not self.names:
            whole = self.vectors_by_size(file)
        return whole

    def vectors_by_size(self, file: str) -> dict:
        """Without names: a stamp and three columns, which the file's name tells, or six, of which gravity is in three."""
        columns = self.values.shape[1]
        if columns == 4:
            return {quantity: [[1, 2, 3]] for quantity, words in QUANTITIES if words.search(file)}
        if columns != 7:
            return {}
        triples = [[1, 2, 3], [4, 5, 6]]
        triples.sort(key=lambda triple: gravity_unit(self.values[:, triple]) is None)
        return {"accelerometer": triples[:1], "gyroscope": triples[1:]}


def read_table(path: Path):
    """A table of at least ten rows of numbers, or None."""
    try:
        text = path.read_text(encoding="utf-8-sig", errors="strict")
    except (OSError, UnicodeDecodeError):
        return None
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    first = next((k for k, line in enumerate(lines) if any(map(is_number, words_of(line)))), None)
    if first is None:
        return None
    rows = [words_of(line) for line in lines[first:]]
    width = len(rows[0])
    whole = [row for row in rows if len(row) == width]
    if len(whole) < 10:
        return None
    head = words_of(lines[first - 1].lstrip("#% ")) if first else []
    names = [name.lower().replace("-", "_") for name in split_case(head)] if len(head) == width else []
    return Table(path, names, np.array([[number(word) for word in row] for row in whole]), whole, len(rows) - len(whole))


def split_case(names: list) -> list:
    """accelerometerAccelerationX(G) → accelerometerAcceleration_X(G), gFx → gF_x."""
    return [re.sub(r"(?<=[a-z])(?=[XYZ]\b)", "_", name) for name in names]


def words_of(line: str) -> list:
    separator = next((mark for mark in (";", "\t", ",") if mark in line), None)
    words = [word.strip().strip('"') for word in line.split(separator)]
    if separator == ";":
        words = [word.replace(",", ".") for word in words]
    return words[:-1] if len(words) > 1 and not words[-1] else words


def number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return np.nan


def is_number(word: str) -> bool:
    return not np.isnan(number(word))


def nanoseconds(words: list, rates):
    """Stamps in whole nanoseconds, from the unit that gives a rate between these; None if they are no clock. Digits are kept: a
    double holds no nanoseconds of today."""
    values = np.array([number(word) for word in words])
    good = values[np.isfinite(values)]
    steps = np.diff(good)
    if len(good) < 0.9 * len(values) or not np.any(steps > 0) or np.mean(steps < 0) > 0.05:
        return None
    step = np.median(steps[steps > 0])
    unit = next((power for power in (0, 3, 6, 9) if rates[0] <= 1e9 / (step * 10**power) <= rates[1]), None)
    return None if unit is None else np.array([scaled(word, unit) for word in words], dtype=np.int64)


def scaled(word: str, power: int) -> int:
    """A decimal number times 10^power, rounded down; −1 for what is no number."""
    if found := re.fullmatch(r"(\d+)(?:\.(\d*))?", word):
        return int(found[1] + (found[2] or "").ljust(power, "0")[:power])
    value = number(word)
    return -1 if np.isnan(value) else int(round(value * 10**power))


def gravity_unit(vectors):
    """What turns accelerations into m/s²: 1, or that of g, mg or cm/s², by their median size; None if gravity is not in them."""
    sizes = np.linalg.norm(vectors, axis=1)
    size = np.nanmedian(sizes)
    if np.nanpercentile(sizes, 10) < 0.5 * size:
        return None  # what it moves by alone comes near zero again and again
    return next((GRAVITY / g for g in (GRAVITY, 1.0, 1000.0, 981.0) if 0.75 * g < size < 1.3 * g), None)
