"""A self-contained page: pictures, style and script inside, readable by day and by night, on a phone and by ear.

Its pieces are made by page.html and by Markup("<p>{}</p>").format(words): both escape what they are given.
"""

import base64
import json
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from .atomic_write import atomic_write
from .words import NAMES, PAGES, Words

HERE = Path(__file__).resolve().parent
TEMPLATES = Environment(loader=FileSystemLoader(HERE), autoescape=True, undefined=StrictUndefined, keep_trailing_newline=True)
TEMPLATES.filters.update(json=lambda value: json.dumps(value, ensure_ascii=False), tail=lambda row: row[1:])
PIECES = TEMPLATES.get_template("page.html").module

table = PIECES.table
"""table(head, rows, kind="", at=None): a table of words, rows named by their first cell; with `at`, row i is shown while a
slider stands at at[i]."""


def figure(directory, name, caption, alternative, say):
    """DIR/figures/NAME.png with its words, alternative text for screen readers, and a link to the SVG."""
    data = base64.b64encode((Path(directory) / "figures" / f"{name}.png").read_bytes()).decode()
    return PIECES.picture(name, data, caption, alternative, say)


def links_to_tables(directory, say):
    return PIECES.files(sorted(path.name for path in (Path(directory) / "csv").glob("*.csv")), say)


def other_languages(say):
    """Links to the same page in the other languages."""
    return PIECES.languages([(PAGES[other], other, NAMES[other]) for other in PAGES if other != say.language])


def write_all(directory, title, body_of):
    """DIR/report.html and the same in the other languages; body_of(directory, say) gives the pieces."""
    for language, name in PAGES.items():
        say = Words(language)
        write(Path(directory) / name, say(title), body_of(directory, say), language)


def write(path, title, body, language="en"):
    """The page at once or not at all; `body` is a list of pieces of HTML."""
    style, script = (Markup((HERE / name).read_text(encoding="utf-8")) for name in ("page.css", "page.js"))
    needed = any('class="explore' in piece for piece in body)
    text = PIECES.page(language, title, style, needed and script, Words(language)("scrolls"), Markup("\n".join(body)))
    with atomic_write(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="replace")
