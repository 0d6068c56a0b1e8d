"""A self-contained page: pictures, style and script inside, readable by day and by night, on a phone and by ear.

Its pieces are made by page.html and by Markup("…{}…").format(words): both escape what they are given.
"""

import base64
import io
import json
import math
import re
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape
from PIL import Image

from .atomic_write import write_whole
from .digits import minus
from .words import NAMES, PAGES, Words

HERE = Path(__file__).resolve().parent
TEMPLATES = Environment(loader=FileSystemLoader(HERE), autoescape=True, undefined=StrictUndefined, keep_trailing_newline=True)
TEMPLATES.filters.update(minus=lambda cell: minus(cell) if type(cell) is str else cell, json=lambda value: json.dumps(value, ensure_ascii=False), tail=lambda row: row[1:])
PIECES = TEMPLATES.get_template("page.html").module

crossed = PIECES.crossed
table = PIECES.table
"""table(head, rows, kind="", at=None): a table of words, rows named by their first cell; with `at`, row i is shown while a
slider stands at at[i]."""


def formulas(text):
    """The words, in which H_pm and J_i are set as in a book. See setFormulas in page.js."""
    return Markup(re.sub(r"([A-Za-z])_([A-Za-z]{1,2})", r"<i>\1</i><sub>\2</sub>", str(escape(text))))


def figure(directory, name, caption, alternative, say, note=""):
    """DIR/figures/NAME.png, or NAME.zh.png on a Chinese page, with its words, alternative text for screen readers, and links to
    the SVG and the PDF. What follows the first line of the words is folded."""
    path = picture_of(directory, name, say)
    folder, own = path.parent, {kind: f"{name}.{say.language}.{kind}" for kind in ("svg", "pdf")}
    files = {kind: file if (folder / file).exists() else f"{name}.{kind}" for kind, file in own.items()}
    first, _, more = caption.partition("\n")
    return PIECES.picture([(file, kind.upper()) for kind, file in files.items()], small(path, path.stat().st_mtime_ns), first, more, note, alternative, say)


def picture_of(directory, name, say):
    """The path of DIR/figures/NAME.png, or of NAME.zh.png on a Chinese page."""
    folder = Path(directory) / "figures"
    own = folder / f"{name}.{say.language}.png"
    return own if own.exists() else folder / f"{name}.png"


def thumbnail(directory, name, part, say):
    """Part of a figure (left, top, right, bottom, as shares of it), so small that it is recognized and not read, as base64."""
    packed = io.BytesIO()
    with Image.open(picture_of(directory, name, say)) as image:
        box = [end(share * size) for end, share, size in zip(2 * (math.floor,) + 2 * (math.ceil,), part, 2 * image.size)]
        small_one = image.convert("RGB").crop(box)
        small_one.thumbnail((360, 220))
        small_one.save(packed, "WEBP", quality=70, method=4)
    return base64.b64encode(packed.getvalue()).decode()


@lru_cache(maxsize=64)
def small(path, _):
    """The same picture in 256 colors of its own, in a third of the bytes, as base64: both languages show it. Where lines and
    letters fade into the paper a thousandth of the pixels change, hardly one by more than 5 %."""
    packed = io.BytesIO()
    with Image.open(path) as image:
        palette = image.convert("RGB").quantize(256, method=0, kmeans=300, dither=0)  # median cut, no dither; a smaller kmeans only takes longer
        palette.convert("RGB").save(packed, "WEBP", lossless=True, quality=90, method=4)
    return base64.b64encode(packed.getvalue()).decode()


def links_to_tables(directory, say):
    return PIECES.files(sorted(path.name for path in (Path(directory) / "csv").glob("*.csv")), say)


def paragraph(words, say=None):
    """What follows the first line of the words is folded."""
    first, _, more = words.partition("\n")
    return PIECES.folded(first, more, say) if more else Markup("<p>{}</p>").format(first)


def opening(heading, lead, say, pages=PAGES):
    """The first pieces of a page: its heading, links to it in the other languages, and what it is about."""
    others = [(pages[other], other, NAMES[other]) for other in pages if other != say.language]
    return [Markup("<h1>{}</h1>").format(heading), PIECES.languages(others), paragraph(lead)]


def write_all(directory, title, body_of, pages=PAGES):
    """DIR/report.html and the same in the other languages, unless other `pages` are meant; body_of(directory, say) gives the
    pieces."""
    from .translate import warn_without_font  # Matplotlib, which other pages do without
    warn_without_font()
    says = [Words(language) for language in pages]
    with ThreadPoolExecutor() as pool:  # most of the time goes into packing pictures, which Pillow does without Python's lock
        bodies = list(pool.map(lambda say: body_of(directory, say), says))
    for say, body in zip(says, bodies):
        write(Path(directory) / pages[say.language], say(title), body, say.language)


def write(path, title, body, language="en"):
    """The page at once or not at all; `body` is a list of pieces of HTML."""
    style, script = (Markup((HERE / name).read_text(encoding="utf-8")) for name in ("page.css", "page.js"))
    text = PIECES.page(language, title, style, script, Words(language)("scrolls"), Markup("\n".join(body)))
    write_whole(path, text, errors="replace")
