"""A self-contained page: pictures embedded, readable by day and by night."""

import base64
import html
from pathlib import Path

from whole_file import whole

CSS = """
:root { color-scheme: light dark; --ink: #222; --paper: #fff; --pale: #f4f4f2; --line: #d9d9d9; --accent: #0072b2; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e6e6; --paper: #17191c; --pale: #22252a; --line: #3a3e44; --accent: #56b4e9; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 62rem; padding: 2rem 1.2rem 4rem; background: var(--paper); color: var(--ink);
       font: 1rem/1.6 system-ui, sans-serif; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.3rem; margin: 3rem 0 .5rem; padding-top: .8rem; border-top: 1px solid var(--line); }
a { color: var(--accent); }
figure { margin: 1.4rem 0 2rem; }
figure img { width: 100%; background: #fff; border: 1px solid var(--line); border-radius: .5rem; padding: .6rem; }
figcaption { margin-top: .5rem; }
.scroll { overflow-x: auto; }
table { margin-top: 1.2rem; border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .55rem; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { background: var(--pale); font-weight: 600; }
th:first-child, td:first-child { text-align: left; }
nav { columns: 2; }
nav a { display: block; }
pre { background: var(--pale); padding: .6rem .8rem; border-radius: .4rem; white-space: pre-wrap; }
code { background: var(--pale); padding: .1em .3em; border-radius: .2em; }
"""


def table(head, rows):
    """A table of words."""
    cells = lambda tag, row: "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row) + "</tr>"
    return ('<div class="scroll"><table>\n' + cells("th", head) + "\n" + "\n".join(cells("td", row) for row in rows) +
            "\n</table></div>\n")


def figure(directory, name, caption):
    """DIR/figures/NAME.png with its words and a link to the SVG."""
    data = base64.b64encode((Path(directory) / "figures" / f"{name}.png").read_bytes()).decode()
    text = html.escape(caption, quote=False)
    return (f'<figure><img alt="{name.replace("_", " ")}" src="data:image/png;base64,{data}">'
            f'<figcaption>{text} <a href="figures/{name}.svg">SVG</a></figcaption></figure>')


def links_to_tables(directory):
    names = sorted(path.name for path in (Path(directory) / "csv").glob("*.csv"))
    links = "".join(f'<li><a href="csv/{name}">{name}</a></li>' for name in names)
    return f'<h2 id="tables">Tables</h2>\n<ul>{links}</ul>'


def write(path, title, body, language="en"):
    """The page at once or not at all; `body` is a list of pieces of HTML."""
    text = (f'<!doctype html>\n<html lang="{language}"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{html.escape(title)}</title><style>{CSS}</style></head>\n<body>\n" + "\n".join(body) +
            "\n</body></html>\n")
    with whole(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="replace")
