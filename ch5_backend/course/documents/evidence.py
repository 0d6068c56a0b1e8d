"""./course evidence: what the project claims, on what each claim rests, and the command that computes it again.

experiments/evidence.json has a row for each claim: its sentence, whose numbers ask the kept tables (figures/queries.py), what
must hold in its tables, where it stands, how often it was measured and in which settings, what else was tried, and the command
where none of figure_sets.py writes its tables. "stated" are the numbers of a page that are limits, options or given, and nobody's
claim. python3 -m ch5_backend.course.documents.evidence writes the pages.
"""

import json
import re
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from shutil import get_terminal_size

import numpy as np

from ch5_backend.figures.atomic_write import write_whole
from ch5_backend.figures.numbers import gauge, peers, systems, windows
from ch5_backend.figures.queries import EVALUATE, fill
from ch5_backend.figures.tables import Tables

from ..base import language
from ..base.cmake_build import BUILD, ROOT, build_or_fail
from ..base.errors import CourseError
from ..base.output_dir import made_dir
from ..experiments.figure_sets import SETS, csv
from ..experiments.plots import due_of, make_tables
from ..experiments.programs import run_programs

try:
    from slides import deck_fast_solver_facts as fast
except ImportError:
    raise CourseError("this is the students' archive: what the claims rest on is in the project itself") from None

FILE = ROOT / "ch5_backend" / "experiments" / "evidence.json"
WORDS, ROWS, STATED = json.loads(FILE.read_text(encoding="utf-8")).values()
KEPT = (ROOT / "ch5_backend" / "figures" / "kept", ROOT / "slides" / "measured")
PAGES = {"en": FILE.with_name("EVIDENCE.md"), "zh": FILE.with_name("EVIDENCE.zh.md")}


class Found:
    """The tables of several folders and those below; of two of one name that of the first. `gauge/sweep` is in gauge/csv."""

    def __init__(self, *folders: Path):
        self.folders = folders

    def __call__(self, name: str, **where):
        for folder in self.folders:
            for path in sorted(folder.rglob(name.replace("/", "/csv/") + ".csv")):
                return Tables(path.parent)(path.stem, **where)
        return Tables(self.folders[0])(name, **where)  # says that it is missing


def names(tables) -> dict:
    """What a row of evidence.json may ask; `table` and what follows from it."""
    def ended(name, column, **where):
        return tables(name, **where)[column].tolist()[-1]

    def step(name, simd="avx2"):
        return tables("speed_steps").row(problem=fast.ROOFED, step=name, solver="sparse", simd=simd)

    def condition(preconditioner):
        values = tables("solver_spectrum", preconditioner=preconditioner)["eigenvalue"]
        return values.max() / values.min()

    def winner(problem):
        rules = ("nielsen", "ceres", "tenfold")
        return min(rules, key=lambda rule: ended("solver_rules", "trial", problem=problem, rule=rule))

    @cache
    def paper(study):
        return getattr(gauge, study)(tables(f"gauge/{study}"))

    def recorded(policy, setting):
        return tables("consistency_recording", recording="euroc_v1_01_easy").row(policy=policy, setting=setting)

    def keyframes(count, temporal):
        rows = tables("window_size", recording="euroc_v1_01_easy", temporal_frames=temporal, keyframes=count)
        return rows["ate_m"].mean()

    def spans(*key):
        return peers.spans(peers.kept(tables))[key]

    def means():
        return [row[3] for row in peers.kinds_of(peers.kept(tables)) if row[1:3] == (peers.BEST, "to 0.1 %")]

    helpers = (ended, step, condition, winner, paper, recorded, keyframes, spans, means)
    return {"table": tables, "np": np, "fast": fast, "gauge": gauge, "systems": systems, "windows": windows,
            **{one.__name__: one for one in helpers},
            **{one.__name__: partial(one, tables=tables) for one in (windows.paired, windows.kept_summary)}}


def filled(row: dict, field: str, lang: str, tables=Found(*KEPT)) -> str:
    return fill(row[field][lang], names(tables)) if field in row else WORDS[lang][f"no {field}"]


def conditions(row: dict) -> list:
    """What must hold: a name of "each" in it stands for every one of its values."""
    every = row.get("holds", [])
    for name, values in row.get("each", {}).items():
        every = [made for one in every for made in ([one.replace(name, value) for value in values] if name in one else [one])]
    return every


def broken(row: dict, tables) -> list:
    """Which of its conditions do not hold."""
    known = names(tables)
    return [one for one in conditions(row) if EVALUATE(one, known) != "True"]


def makers(row: dict) -> list:
    """What writes its tables, of figure_sets.py, each with no more studies than it needs."""
    found = {}
    for name in row["tables"]:
        place, _, stem = name.rpartition("/")
        one = next(one for one in SETS if one.made_by and f"csv/{stem}.csv" in one.tables and place in ("", one.folder))
        found.setdefault(one.name, (one, []))[1].append(stem)
    return [replace(one, tables=csv(" ".join(stems)), trials={study: one.trials[study] for study in stems if one.trials},
                    seconds=(one.seconds[0] * share(one, stems), 0))
            for one, stems in found.values()]


def share(one, studies: list) -> float:
    """How much of a set's time its studies take."""
    counts = {study: trials for study, (trials, _) in one.trials.items()}
    return sum(counts[study] for study in studies) / sum(counts.values()) if counts else 1.0


def commands(row: dict, typed=True) -> list:
    """{out} and {data} still open; unless `typed`, with the names that FigureSet.command takes."""
    found = row["command"] if "command" in row else [f"{one.made_by} {study}".strip() for one in makers(row) for study in one.trials or ("",)]
    return found if not typed else [one.replace("ch5_backend.course ", "./course ").replace("ch5_backend.", "python3 -m ch5_backend.") for one in found]


def origin(row: dict, lang: str) -> str:
    """When and where its kept tables were measured."""
    found, about = [], {one["table"]: one for one in Tables(KEPT[0])("measured").rows()}
    for name in row["tables"]:
        columns = about.get(name)
        if not columns and (KEPT[1] / f"{name}.csv").exists():
            own = Tables(KEPT[1])(name)
            own = own if "processor" in own.columns else Tables(KEPT[1])("speed_about")
            columns = {key: ", ".join(sorted(set(own[key]))) for key in ("date", "processor") if key in own.columns}
            columns["processor"] += f", {WORDS[lang]['threads']}{', '.join(f'{n:.0f}' for n in sorted(set(own['threads'])))}"
        if columns:
            found.append(f"`{name}`: " + ", ".join(filter(None, (columns.get(key, "") for key in ("date", "processor")))))
    return "; ".join(dict.fromkeys(found)) or WORDS[lang]["each run"]


def link(place: str, lang: str) -> str:
    path, _, part = place.partition("#")
    if path.startswith("slides/"):
        return f"[{Path(path).name[0]}, {part}](../../slides/reading/{Path(path).name}.{lang}.md)"
    path = path.replace(".md", ".zh.md") if lang == "zh" else path
    return f"[{path}](../../{path})" if not part or lang == "zh" else f"[{path}, {part}](../../{path}#{part})"


def page(lang: str) -> str:
    word, parts = WORDS[lang], [WORDS[lang]["head"]]
    for name, row in ROWS.items():
        lines = {"n": filled(row, "n", lang), "settings": filled(row, "settings", lang), "rivals": filled(row, "rivals", lang),
                 "command": "; ".join(f"`{one}`" for one in commands(row)) or filled(row, "by hand", lang),
                 "measured": origin(row, lang), "where": ", ".join(link(place, lang) for place in row["where"])}
        parts.append(f"## {name}\n\n{filled(row, 'claim', lang)}\n\n" + "\n".join(f"- {word[key]}{text}" for key, text in lines.items()))
    return "\n\n".join(parts) + "\n"


def evidence(arguments) -> int:
    """Lists the claims, or computes one again; returns 1 if one of its conditions does not hold."""
    refuse(arguments.name)
    lang = arguments.language
    if not arguments.name:
        for name, row in ROWS.items():
            print(name, *language.fold(filled(row, "claim", lang).partition("\n")[0], get_terminal_size().columns - 3).splitlines(), sep="\n  ")
        return 0
    row, word, out = ROWS[arguments.name], WORDS[lang], Path(arguments.out or "out") / "evidence" / arguments.name
    print(filled(row, "claim", lang), *(word[key] + filled(row, key, lang) for key in ("n", "settings", "rivals")), sep="\n")
    if not commands(row):
        print(word["command"] + filled(row, "by hand", lang))
        return 0
    print(word["command"] + "; ".join(commands(row)), flush=True)
    with made_dir(out):
        compute(row, out)
    fresh = Found(out)
    failed = broken(row, fresh)
    if "{{" in row["claim"][lang]:
        print(f"\n{word['now']}\n{filled(row, 'claim', lang, fresh)}")
    for one in conditions(row):
        print(word["fails" if one in failed else "holds"] + one + sides(one, names(fresh)))
    return int(bool(failed))


def sides(condition: str, known: dict) -> str:
    """The numbers that a condition compares, if that is all it does."""
    parts = re.split(r"( (?:[<>]=?|==|!=) )", condition)
    if len(parts) < 3 or any(part.count(a) != part.count(b) for part in parts for a, b in ("()", "[]")) or re.search(" (and|or) ", condition):
        return ""
    values = [part if k % 2 else EVALUATE(part, known) for k, part in enumerate(parts)]
    return f"   [{''.join(re.sub(r'^(-?[0-9.]+(e-?[0-9]+)?)$', lambda found: f'{float(found[1]):.4g}', value) for value in values)}]"


def compute(row: dict, out: Path) -> None:
    if "command" not in row:
        make_tables(due_of(makers(row), out, rerun=True), out)
        return
    words = [SETS[0].command(one, out) for one in row["command"]]
    if targets := [Path(program).name for program, *_ in words if BUILD in Path(program).parents]:
        build_or_fail(targets)
    run_programs(words, as_json=False)


def refuse(name: str) -> None:
    if name and name not in ROWS:
        raise CourseError(f"no claim is called '{name}'; there are {', '.join(ROWS)}")


if __name__ == "__main__":
    for lang, path in PAGES.items():
        write_whole(path, page(lang))
