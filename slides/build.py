#!/usr/bin/python3
"""Builds the decks to self-contained HTML in out/slides/: fills in the numbers, draws the figures, calls Marp.

usage: build.py [--csv DIR] [--out DIR] [--images] [--overview] [--figures]

  --csv DIR    tables of ./course run, default out/csv
  --out DIR    where the HTML goes, default out/slides
  --images     also one PNG a page, to look at; needs Chromium
  --overview   only redraw the READMEs' picture, slides/figures/overview.*.svg
  --figures    only draw the figures, into the folder figures of --out; needs no Node.js
"""

import argparse
import base64
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import blocks
import facts
import plots
from tables import MissingTable, Tables

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
WORK = ROOT / "build" / "slides"
LANGUAGES = ("en", "zh")
PLACEHOLDER = re.compile(r"\{\{([A-Za-z0-9_.]+)\}\}")
SLIDE_ID = re.compile(r"^<!-- slide: [^>]*-->\n", re.M)


class BuildError(Exception):
    """A message for the user and an exit code: 2 for something missing, 1 for a step that failed."""

    def __init__(self, message, code=2):
        super().__init__(message)
        self.code = code


def decks():
    return sorted(HERE.glob("[0-9]-*.??.md"))


def language(deck):
    return deck.name.split(".")[-2]


def fill(text, values, where):
    """Replaces every {{name}}; an unknown name is an error that tells the place."""
    def value(match):
        if match[1] not in values:
            line = text.count("\n", 0, match.start()) + 1
            raise BuildError(f"{where}:{line}: nothing is known of {{{{{match[1]}}}}}", code=1)
        return values[match[1]]
    return PLACEHOLDER.sub(value, text)


def draw(names, lang, tables):
    """{name: SVG text} of the figures that a deck asks for."""
    drawn = {}
    for name in names:
        if name in blocks.ALL:
            drawn[name] = blocks.ALL[name](lang)
        elif name in plots.ALL:
            drawn[name] = plots.ALL[name](tables, lang)
        else:
            raise BuildError(f"no script draws figures/{name}.svg", code=1)
    return drawn


def prepare(deck, tables, values):
    """The deck with its numbers, and its figures."""
    text = fill(deck.read_text(encoding="utf-8"), values, deck)
    names = sorted(set(re.findall(r"\(figures/(\w+)\.svg\)", text)))
    return SLIDE_ID.sub("", text), draw(names, language(deck), tables)


def inline(html, figures):
    """Puts every figure into the page itself."""
    for name, svg in figures.items():
        data = "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()
        html = html.replace(f"figures/{name}.svg", data)
    outside = re.findall(r'(?:src="|url\(&quot;|url\("?|href="[^"]*\.css)(?!data:|#|&quot;data:)[^")]{3,60}', html)
    if outside:
        raise BuildError(f"the page would load {outside[0]!r} from outside", code=1)
    return html


def marp():
    """The command that runs Marp; installed from the lock file into build/slides when that changes."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if not node or not npm:
        raise BuildError("Marp needs Node.js 18 or newer and npm; Debian: apt-get install nodejs npm")
    lock = (HERE / "package-lock.json").read_text(encoding="utf-8")
    stamp, script = WORK / "installed.lock", WORK / "node_modules/@marp-team/marp-cli/marp-cli.js"
    if not (script.exists() and stamp.exists() and stamp.read_text(encoding="utf-8") == lock):
        WORK.mkdir(parents=True, exist_ok=True)
        for name in ("package.json", "package-lock.json"):
            shutil.copy(HERE / name, WORK / name)
        say("installing Marp into build/slides …")
        run([npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund"], "npm could not install Marp")
        stamp.write_text(lock, encoding="utf-8")
    return [node, str(script), "--no-stdin", "--no-config-file", "--theme-set", str(HERE / "theme.css"), "--html"]


def run(command, failure):
    """Runs a command in WORK; its output is shown only if it fails."""
    done = subprocess.run(command, cwd=WORK, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode:
        raise BuildError(f"{failure}:\n{(done.stdout + done.stderr).strip()[-2000:]}", code=1)


def say(words):
    if sys.stderr.isatty():
        print(f"slides: {words}", file=sys.stderr)


def write(path, text):
    """Whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(path.name + ".partial")
    partial.write_text(text, encoding="utf-8")
    os.replace(partial, path)


def build(deck, tables, values, out, images):
    """One deck to OUT/NAME.html, and with `images` its pages to WORK/pages/NAME.001.png …"""
    text, figures = prepare(deck, tables, values)
    folder = WORK / deck.stem
    write(folder / deck.name, text)
    for name, svg in figures.items():
        write(folder / "figures" / f"{name}.svg", svg)
    page = folder / f"{deck.stem}.html"
    run([*marp(), str(folder / deck.name), "-o", str(page)], f"Marp could not build {deck.name}")
    write(out / page.name, inline(page.read_text(encoding="utf-8"), figures))
    if images:
        (WORK / "pages").mkdir(exist_ok=True)
        run([*marp(), "--images", "png", "--allow-local-files", str(folder / deck.name), "-o",
             str(WORK / "pages" / f"{deck.stem}.png")], f"no images of {deck.name}")
    return out / page.name


def main(argv):
    parser = argparse.ArgumentParser(prog="build.py", description=__doc__.split("\n\n")[0], allow_abbrev=False)
    parser.add_argument("--csv", type=Path, default=ROOT / "out" / "csv", help="tables of ./course run")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "slides", help="where the HTML goes")
    parser.add_argument("--images", action="store_true", help="also one PNG a page; needs Chromium")
    parser.add_argument("--overview", action="store_true", help="only redraw the READMEs' picture")
    parser.add_argument("--figures", action="store_true", help="only draw the figures, into the folder figures of --out")
    arguments = parser.parse_args(argv)
    tables = Tables(arguments.csv)
    try:
        if arguments.overview:
            for lang in LANGUAGES:
                write(HERE / "figures" / f"overview.{lang}.svg", plots.overview(tables, lang))
            return 0
        if arguments.figures:
            for lang in LANGUAGES:
                for name, svg in draw([*blocks.ALL, *plots.ALL], lang, tables).items():
                    write(arguments.out / "figures" / f"{name}.{lang}.svg", svg)
            return 0
        values = facts.all_facts(tables)
        for deck in decks():
            say(deck.name)
            print(build(deck, tables, values, arguments.out, arguments.images))
        return 0
    except MissingTable as missing:
        print(f"slides: {missing}", file=sys.stderr)
        return 2
    except BuildError as error:
        print(f"slides: {error}", file=sys.stderr)
        return error.code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
