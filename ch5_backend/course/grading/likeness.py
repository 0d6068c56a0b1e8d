"""Submissions that are alike, also after renaming: a hint for a human, no proof.

A text is read as the compiler reads it, without comments and spaces. Of every GRAM tokens in a row a hash is kept, in
which the names of variables and of own functions are numbered as they come: a copy with other names has the same hashes.

A copy of the solution has no grams of its own. It is known by the functions of which the compiler makes the solution's instructions.
"""

import json
import re
from collections import Counter
from functools import lru_cache
from pathlib import Path

from ch5_backend.figures.atomic_write import write_whole

from ..base.errors import CourseError
from ..homework.make_skeleton import untouched
from ..homework.regions import FILES, fill, solution_text
from .outputs import short_hash

GRAM = 16       # tokens
FEWEST = 40     # grams of one's own: three places or more; below that two people may have had one idea
SHARE = 0.7     # of the smaller file's own grams
STRING = r'"(?:\\.|[^"\\\n])*"?'  # or without an end: no quote in it is tried as a beginning
NOTHING = re.compile(rf'({STRING})|//[^\n]*|/\*.*?(?:\*/|\Z)|^[^\S\n]*#(?![^\S\n]*define\b)[^\n]*', re.DOTALL | re.MULTILINE)
DEFINE = re.compile(r'^[^\S\n]*#[^\S\n]*define\s+\w+(?:\([^)\n]*\))?', re.MULTILINE)  # but its replacement is read
EMPTY = re.compile(r'(?<=[;{}])\s*(?:\(\s*void\s*\)\s*\w+\s*;|;)+')  # statements that do nothing
FUNCTION = re.compile(r'^define (?:weak(?:_odr)? )?dso_local [^@\n]*@([\w$.]+)\(.*\n((?:(?!\}).*\n)*)', re.MULTILINE)
# Of an instruction: numbers of values, types, texts and lines, and what is for a debugger.
NUMBERS = re.compile(r'(?<=%)\d+|\.\d+(?=")|(?<=@\.str)[.\d]*|(?<=@__const)[\w.$]+|(?:, )?!\w+(?: !\d+)?| #\d+|(?<=, i32 noundef )\d+(?=, [^\n]*__PRETTY_FUNCTION__)')
TOKEN = re.compile(rf'{STRING}|[A-Za-z_]\w*|\d[\w.]*|->|::|[^\s\w]')
KEYWORDS = frozenset("auto bool break const continue double else false float for if int long nullptr return size_t static "
                     "std struct true void while".split())


def fingerprint(files: dict) -> dict:
    """{file: hashes of its grams that neither skeleton nor solution has}; to be compared, never shown."""
    return {file: sorted(grams(content.decode("utf-8", "replace"), calls_in(file)) - known(file))
            for file, content in files.items()}


def grams(text: str, calls: frozenset) -> set:
    text = NOTHING.sub(lambda nothing: nothing[1] or " ", text.replace("\\\n", " "))
    tokens = TOKEN.findall(EMPTY.sub("", DEFINE.sub(" ", text)))
    kinds = [kind(tokens, k, calls) for k in range(len(tokens))]
    return {gram_hash(kinds[k:k + GRAM]) for k in range(len(kinds) - GRAM + 1)}


def kind(tokens: list, k: int, calls: frozenset) -> str:
    """The token, or "$name" for a name that a student may change without changing anything."""
    token = tokens[k]
    if not re.match(r"[A-Za-z_]", token) or token in KEYWORDS:
        return token
    is_call = tokens[k + 1:k + 2] == ["("] or (k > 0 and tokens[k - 1] in (".", "->", "::"))
    return token if is_call and token in calls else "$" + token


def gram_hash(kinds: list) -> str:
    numbers = {}
    return short_hash(" ".join(f"${numbers.setdefault(one, len(numbers))}" if one[0] == "$" else one for one in kinds))[:10]


@lru_cache
def calls_in(file: str) -> frozenset:
    """The names in skeleton and solution: those of the library among them, which a copy cannot change."""
    return frozenset(re.findall(r"[A-Za-z_]\w*", "".join(own_texts(file))))


@lru_cache
def known(file: str) -> frozenset:
    return frozenset().union(*(grams(text, calls_in(file)) for text in own_texts(file)))


def own_texts(file: str) -> list:
    if file not in FILES:
        return []
    return [*untouched(file), fill(solution_text(file), lambda region: region.solution)]


def functions_in(code: str) -> dict:
    """{function: hash of its instructions}, of the intermediate code of a file, for the functions that others call."""
    return {name: short_hash("\n".join(NUMBERS.sub("", line) for line in body.splitlines() if " alloca " not in line))
            for name, body in FUNCTION.findall(code)}


def as_solution(records: list) -> list:
    """[(name, file, how many of its functions have the solution's instructions, of how many)] of files in which most have, but for
    those that so have a third of the class; None for how many where only the second compiler takes the file."""
    found = []
    for file in FILES:
        own = {record["name"]: record["solved"][file] for record in records if record.get("solved", {}).get(file)}
        times = Counter(one for names, _ in own.values() for one in names or ())
        for name, (names, of_all) in own.items():
            some = None if names is None else sum(times[one] <= max(2, len(own) / 3) for one in names)
            if some is None or some >= SHARE * of_all:
                found.append((name, file, some, of_all))
    return found


def earlier(folders: str) -> list:
    """What other calls have written into these folders, by FOLDER/NAME. Raises CourseError where one holds no record."""
    found = []
    for folder in filter(None, folders.split(",")):
        paths = sorted(Path(folder.strip()).glob("*/record.json"))
        if not paths:
            raise CourseError(f"--earlier {folder.strip()}: no record.json in its folders; name what --out was")
        records = [json.loads(path.read_text(encoding="utf-8")) for path in paths]
        found += [{**record, "name": f"{folder.strip()}/{record['name']}"} for record in records]
    return found


def alike_once(records: list, earlier: list, path: Path) -> list:
    """alike(), kept at `path` as long as the records are the same: it takes seconds for a class of 800."""
    key = short_hash(json.dumps([[record["name"], record["fingerprint"]] for record in [*records, *earlier]], sort_keys=True))
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
        if kept["key"] == key:
            return kept["found"]
    except (OSError, ValueError, KeyError, TypeError):
        pass
    found = alike(records, earlier)
    path.parent.mkdir(exist_ok=True)
    write_whole(path, json.dumps({"key": key, "found": found}))
    return found


def alike(records: list, earlier: list = ()) -> list:
    """[(name, name, file, share)], not of two earlier ones, of files that have most of their own grams in common, but for those of a third of the
    class: so many have them because they are what one writes."""
    found, old = [], {record["name"] for record in earlier}
    for file in FILES:
        own = {record["name"]: set(record["fingerprint"].get(file, ())) for record in [*records, *earlier]}
        count = {}
        for hashes in own.values():
            for one in hashes:
                count[one] = count.get(one, 0) + 1
        common = {one for one, times in count.items() if times > max(2, len(own) / 3)}
        own = {name: hashes - common for name, hashes in own.items() if len(hashes - common) >= FEWEST}
        # As numbers, 30 times quicker, in which what nobody else has has no bit.
        bits = {one: 1 << k for k, one in enumerate(sorted(one for one in set().union(*own.values()) if count[one] > 1))}
        sets = [(name, number, len(hashes)) for name, hashes in own.items()
                if (number := sum(bits[one] for one in hashes if one in bits)).bit_count() >= SHARE * FEWEST]
        for k, (a, of_a, size_a) in enumerate(sets):
            for b, of_b, size_b in sets[k + 1:]:
                share = (of_a & of_b).bit_count() / min(size_a, size_b)
                if share >= SHARE and not {a, b} <= old:
                    found.append((a, b, file, share))
    return found
