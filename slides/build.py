#!/usr/bin/python3
"""Builds the decks to HTML and PDF in out/slides/: fills in the numbers, draws the figures, calls Marp and Chromium.

usage: build.py [--csv DIR] [--out DIR] [--html] [--images] [--tools] [--check] [--figures [--deck N]] [--overview]
                [--reading] [DECK…]

  --csv DIR    tables of ./course run, default out/csv
  --out DIR    where the decks go, default out/slides
  --html       no PDF; needs no Chromium
  --images     also one PNG a page, in build/slides/pages, and sheets of twelve pages, to look at
  --tools      builds nothing: fails with words if Node.js or, without --html, Chromium is missing or too old
  --check      builds nothing: says which numbers, figures and words of the built decks are no longer those of the tables
  --figures    only draw the figures, SVG and PDF, into the folder figures of --out; needs no Node.js
  --overview   only redraw the pictures of the guide and of the homework's pages, slides/figures/
  --reading    only write the reading edition, slides/reading/, which the handouts link: see reading.py; needs no Node.js
  DECK         only those whose names begin so, such as 2-solvers.en or 2-solvers

A deck is N-name.en.md and N-name.zh.md beside this file. Each page begins with <!-- slide: id -->, or with
<!-- slide: id result --> where no digit may be typed, and ends with its speaker note, <!-- (2 min) what to say -->, the
same minutes in both languages, 60 to 90 a deck. A last page repeats the answers to its questions, since a PDF shows none
that is folded. What a deck shows comes from the module deck_name.py:

  FIGURES         {name: draw(tables, lang) -> SVG text}; the deck shows figures/name.svg; no two decks share a name
  facts(tables)   {name: text for {{name}}, or what an expression such as {{large.points | f0}} can name}, see figures/queries.py;
                  {{code.1.1a}} is the blank part of a TODO and known to every deck

measured/*.csv are tables that are kept because making them measures time, see course/documents/measure_speed.py; they hide those of --csv.
The tables of --csv that a deck needs, and the program that writes them, are of_deck(N, …) in
ch5_backend/course/experiments/figure_sets.py. Shared: tex.py, and in ch5_backend/figures slide.py (canvas, axes, colors),
tables.py, numbers/ and words/figures.zh.json, the Chinese of every label.
"""

import argparse
import base64
import hashlib
import importlib
import json
import re
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from itertools import product
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent

from . import browser, npm
from .browser import BuildError
from .decks import choose, decks
from .facts import written
from .npm import WORK
from .reading import reading
from ch5_backend.figures.atomic_write import atomic_write, write_whole
from ch5_backend.figures.queries import PLACEHOLDER
from ch5_backend.figures.tables import TableError, Tables

LANGUAGES = ("en", "zh")
SLIDE_ID = re.compile(r"^<!-- slide: [^>]*-->\n", re.M)
TITLE = re.compile("<title>(.*?)</title>")
FIGURE = re.compile(r"\(figures/(\w+)\.svg\)")


def language(deck):
    return deck.name.split(".")[-2]


def module_of(deck):
    """The module deck_name of N-name.en.md."""
    return importlib.import_module("slides.deck_" + deck.name.split(".")[0].partition("-")[2].replace("-", "_"))


def tables_of(csv):
    return Tables(csv, kept=HERE / "measured")


def blanks():
    """The BLANK part of every TODO in solutions/, what a student sees in its place: {"code.1.1a": lines}."""
    found = {}
    for path in sorted((ROOT / "solutions").glob("*.cc")):
        text = path.read_text(encoding="utf-8")
        for todo, hidden in re.findall(r"// BEGIN SOLUTION (\S+).*?// BLANK\n(.*?)\s*// END SOLUTION", text, re.S):
            lines = [re.sub(r"^\s*// ?", "", line) for line in hidden.splitlines() if line.strip()]
            found[f"code.{todo}"] = "\n".join(lines)
    return found


def fill(text, facts, tables, where):
    """The text with every placeholder written, and {placeholder: what is written}; an unknown name is an error that tells the place."""
    found = {}

    def value(match):
        try:
            found[match[1]] = written(match[1], facts, tables)
        except NameError as error:
            line = text.count("\n", 0, match.start()) + 1
            raise BuildError(f"{where}:{line}: nothing is known of {error}", code=1) from error
        return found[match[1]]
    return PLACEHOLDER.sub(value, text), found


@contextmanager
def of_this_version(folder):
    """Whoever has older tables is told so, not which row is missing where."""
    try:
        yield
    except (LookupError, ValueError) as error:
        raise TableError(f"{folder} and the folders beside it: their tables are not what this version writes ({error}); "
                         "./course plots --rerun makes them anew") from error


class Prepared:
    """A deck before Marp: its words with their numbers, and its figures."""

    def __init__(self, deck, csv):
        tables, module, source = tables_of(csv), module_of(deck), deck.read_text(encoding="utf-8")
        self.name, self.lang, self.source = deck.stem, language(deck), source
        with of_this_version(tables.folder):
            facts = module.facts(tables)
        filled, self.numbers = fill(source, {**blanks(), **facts}, tables, deck)
        self.figures = {}
        for name in sorted(set(FIGURE.findall(source))):
            if name not in module.FIGURES:
                raise BuildError(f"{deck}: no script draws figures/{name}.svg", code=1)
            with of_this_version(tables.folder):
                self.figures[name] = module.FIGURES[name](tables, self.lang)
        self.text = SLIDE_ID.sub("", filled)

    def reading(self):
        return reading(self.name, self.lang, self.text, {name: TITLE.search(svg)[1] for name, svg in self.figures.items()})

    def record(self):
        """What the deck was made of, for --check."""
        return {"words": digest(self.source), "numbers": self.numbers,
                "figures": {name: digest(svg) for name, svg in self.figures.items()}}


def answers(text, lang):
    """The last page: each question's title and answer."""
    found = re.findall(r"^## ([^\n]*)\n(?:(?!^---$|^## ).)*?<details><summary>[^\n]*</summary>\n\n(.*?)\n\n</details>", text, re.M | re.S)
    title = {"en": "Answers", "zh": "答案"}[lang]
    return "\n\n".join(["\n\n---\n<!-- _class: small -->", f"## {title}", *(f"**{question}** {answer}" for question, answer in found)]) + "\n"


def digest(text):
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def digest_of_file(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def inline(html, figures, lang):
    """Puts every figure into the page itself, and its title beside it for those who do not see it."""
    for name, svg in figures.items():
        data = "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()
        html = html.replace(f'"figures/{name}.{lang}.svg" alt=""', f'"{data}" alt="{TITLE.search(svg)[1]}"')
    outside = re.findall(r'(?:src="|url\(&quot;|url\("?|href="[^"]*\.css)(?!data:|#|&quot;data:)[^")]{3,60}', html)
    if outside:
        raise BuildError(f"the page would load {outside[0]!r} from outside", code=1)
    # No line begins with the full stop behind a formula, nor behind emphasis that ends with one.
    formula = "(<mjx-container(?:[^<]|<(?!/mjx-container))*</mjx-container>)"
    return re.sub(formula + "(</(?:em|strong)>)?([，。；：、！？）])", r'<span style="white-space: nowrap">\1\3</span>\2', html)


def marp(prepared, out):
    """All decks to HTML in one call of Marp, which is installed from the lock file when that changes."""
    node, script = browser.node(), npm.installed() / "@marp-team/marp-cli/marp-cli.js"
    with tempfile.TemporaryDirectory(dir=WORK) as folder:
        folder = Path(folder)
        for deck in prepared:
            write(folder / f"{deck.name}.md", FIGURE.sub(rf"(figures/\1.{deck.lang}.svg)", deck.text + answers(deck.text, deck.lang)))
        browser.run([node, str(script), "--no-stdin", "--no-config-file", "--theme-set", str(HERE / "theme.css"),
                     "--html", "--input-dir", str(folder), "-o", str(folder)], "Marp could not build the decks", cwd=WORK)
        for deck in prepared:
            html = (folder / f"{deck.name}.html").read_text(encoding="utf-8")
            write(out / f"{deck.name}.html", inline(html, deck.figures, deck.lang))


def say(words):
    print(f"slides: {words}", file=sys.stderr)


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, text)


def find_tools(arguments):
    browser.node()
    if not arguments.html:
        browser.chromium()


def prepare(chosen, arguments):
    with ProcessPoolExecutor() as pool:
        return list(pool.map(Prepared, chosen, [arguments.csv] * len(chosen)))


def build(chosen, arguments):
    """The chosen decks, and the record of what they were made of."""
    out = arguments.out
    find_tools(arguments)  # before the work
    prepared = prepare(chosen, arguments)
    marp(prepared, out)
    record = read_record(out)
    for deck in prepared:
        page = out / f"{deck.name}.html"
        print(page)
        if not arguments.html:
            browser.pdf(page, page.with_suffix(".pdf"))
            print(page.with_suffix(".pdf"))
        if arguments.images:
            browser.images(page.with_suffix(".pdf"), WORK / "pages")
        record[deck.name] = {**deck.record(), "html": digest(page.read_text(encoding="utf-8"))}
        if not arguments.html:
            record[deck.name]["pdf"] = digest_of_file(page.with_suffix(".pdf"))
    write(out / "made_of.json", json.dumps(record, indent=1, sort_keys=True, ensure_ascii=False) + "\n")


def read_record(out):
    path = out / "made_of.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def check(chosen, arguments):
    """What of the built decks is out of date, a line each; the exit code."""
    record, stale = read_record(arguments.out), []
    built = [deck for deck in chosen if deck.stem in record and (arguments.out / f"{deck.stem}.html").exists()]
    stale += [f"{deck.stem}: not built yet" for deck in chosen if deck not in built]
    prepared = dict(zip(built, prepare(built, arguments)))
    for deck in built:
        page, old = arguments.out / f"{deck.stem}.html", record[deck.stem]
        new = prepared[deck].record()
        if old["html"] != digest(page.read_text(encoding="utf-8")):
            stale.append(f"{deck.stem}: {page} is not as it was built")
        pdf = page.with_suffix(".pdf")
        if pdf.exists() and old.get("pdf") != digest_of_file(pdf):
            stale.append(f"{deck.stem}: {pdf} was not built with it")
        if old["words"] != new["words"]:
            stale.append(f"{deck.stem}: {deck} has changed")
        for kind in ("numbers", "figures"):
            for name in sorted({*old[kind], *new[kind]}):
                was, now = (one[kind].get(name, "nothing") for one in (old, new))
                if was != now:
                    change = f": {was} on the slide, {now} in the tables" if kind == "numbers" else ""
                    stale.append(f"{deck.stem}: {kind[:-1]} {name} is out of date{change}")
    for line in stale:
        say(line)
    return 1 if stale else 0


def draw_figures(chosen, arguments):
    for deck in chosen:
        for name, draw in module_of(deck).FIGURES.items():
            place, tables, lang = arguments.out / "figures" / f"{name}.{language(deck)}", tables_of(arguments.csv), language(deck)
            write(place.with_name(f"{place.name}.svg"), draw(tables, lang))
            if lang == "en":  # matplotlib embeds Chinese letters under a wrong kind
                with atomic_write(place.with_name(f"{place.name}.pdf")) as partial:
                    partial.write_bytes(draw(tables, lang, "pdf"))


def write_reading(chosen, arguments):
    for deck in prepare(chosen, arguments):
        write(HERE / "reading" / f"{deck.name}.md", deck.reading())
        for name, svg in deck.figures.items():
            write(HERE / "reading" / "figures" / f"{name}.{deck.lang}.svg", svg)


def pictures():
    """{name: draw} of slides/figures/: the guide's, from the tables, and the homework's, from none."""
    from . import deck_back_end, handout_figures
    return {"overview": deck_back_end.overview, **handout_figures.FIGURES}


def main(argv):
    parser = argparse.ArgumentParser(prog="build.py", description=__doc__.split("\n\n")[0], allow_abbrev=False)
    parser.add_argument("--csv", type=Path, default=ROOT / "out" / "csv", help="tables of ./course run")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "slides", help="where the decks go")
    parser.add_argument("--html", action="store_true", help="no PDF")
    parser.add_argument("--images", action="store_true", help="also one PNG a page")
    parser.add_argument("--tools", action="store_true", help="only see that what is needed is there")
    parser.add_argument("--check", action="store_true", help="only say what is out of date")
    parser.add_argument("--figures", action="store_true", help="only draw the figures, into the folder figures of --out")
    parser.add_argument("--overview", action="store_true", help="only redraw the pictures of the guide and the homework")
    parser.add_argument("--reading", action="store_true", help="only write the reading edition, slides/reading/")
    parser.add_argument("names", nargs="*", metavar="DECK", help="such as 2-solvers; default: all")
    arguments = parser.parse_args(argv)
    try:
        if arguments.overview:
            for (name, draw), lang in product(pictures().items(), LANGUAGES):
                write(HERE / "figures" / f"{name}.{lang}.svg", draw(Tables(arguments.csv), lang))
        elif arguments.figures:
            draw_figures(choose(arguments.names), arguments)
        elif arguments.reading:
            write_reading(choose(arguments.names), arguments)
        elif arguments.tools:
            find_tools(arguments)
        elif arguments.check:
            return check(choose(arguments.names), arguments)
        else:
            build(choose(arguments.names), arguments)
        return 0
    except TableError as missing:
        say(missing)
        return 2
    except BuildError as error:
        say(error)
        return error.code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
