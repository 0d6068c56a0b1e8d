"""A self-contained page: pictures, style and script inside, readable by day and by night, on a phone and by ear."""

import base64
import html
from pathlib import Path

from .atomic_write import atomic_write
from .words import NAMES, PAGES, Words

HERE = Path(__file__).resolve().parent


def table(head, rows, kind="", at=None):
    """A table of words, rows named by their first cell; with `at`, row i is shown while a slider stands at at[i]."""
    row = lambda i, cells: (f'<tr data-at="{at[i]}">' if at else "<tr>") + (
        f'<th scope="row">{html.escape(cells[0])}</th>') + "".join(
        f"<td>{html.escape(cell)}</td>" for cell in cells[1:]) + "</tr>"
    titles = "".join(f'<th scope="col">{html.escape(cell)}</th>' for cell in head)
    return (f'<div class="scroll {kind}"><table>\n<thead><tr>{titles}</tr></thead>\n<tbody>\n' +
            "\n".join(row(i, cells) for i, cells in enumerate(rows)) + "\n</tbody></table></div>\n")


def figure(directory, name, caption, alternative, say):
    """DIR/figures/NAME.png with its words, those for who does not see it, and a link to the SVG."""
    data = base64.b64encode((Path(directory) / "figures" / f"{name}.png").read_bytes()).decode()
    text, alt = html.escape(caption, quote=False), html.escape(alternative)
    svg = f'<a href="figures/{name}.svg" aria-label="{say("as_svg", picture=alt)}">SVG</a>'
    return (f'<figure><div class="scroll"><img alt="{alt}" src="data:image/png;base64,{data}"></div>'
            f"<figcaption>{text} {svg}</figcaption></figure>")


def links_to_tables(directory, say):
    names = sorted(path.name for path in (Path(directory) / "csv").glob("*.csv"))
    links = "".join(f'<li><a href="csv/{name}">{name}</a></li>' for name in names)
    return f'<h2 id="tables">{say("tables")}</h2>\n<ul>{links}</ul>'


def other_languages(say):
    """Links to the same page in the other languages."""
    links = " · ".join(f'<a href="{PAGES[other]}" lang="{other}" hreflang="{other}">{NAMES[other]}</a>' for other in PAGES
                       if other != say.language)
    return f"<p>{links}</p>"


def write_all(directory, title, body_of):
    """DIR/report.html and the same in the other languages; body_of(directory, say) gives the pieces."""
    for language, name in PAGES.items():
        say = Words(language)
        write(Path(directory) / name, say(title), body_of(directory, say), language)


def write(path, title, body, language="en"):
    """The page at once or not at all; `body` is a list of pieces of HTML."""
    style, script = ((HERE / name).read_text(encoding="utf-8") for name in ("page.css", "page.js"))
    needed = f"<script>\n{script}</script>" if any('class="explore' in piece for piece in body) else ""
    text = (f'<!doctype html>\n<html lang="{language}"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{html.escape(title)}</title><style>\n{style}</style></head>\n"
            f'<body data-scrolls="{Words(language)("scrolls")}"><main>\n' + "\n".join(body) +
            f"\n</main>\n{needed}</body></html>\n")
    with atomic_write(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="replace")
