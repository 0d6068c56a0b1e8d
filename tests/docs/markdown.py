"""Markdown taken apart, for the tests of the documents."""

import re
from pathlib import Path

from tests.project import ROOT

FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.S | re.M)
READMES = (ROOT / "README.md", ROOT / "README.zh.md")
HANDOUTS = (ROOT / "ch5_homework/README.md", ROOT / "ch5_homework/README.zh.md")  # where all pages are listed
PAGES = [(page, page.with_name(page.stem + ".zh.md")) for page in sorted((ROOT / "ch5_homework/handout").glob("*.md"))
         if not page.name.endswith(".zh.md")]
ENGINEERS = [(ROOT / f"ch5_backend/{page}.md", ROOT / f"ch5_backend/{page}.zh.md") for page in ("GUIDE", "MAP", "experiments/README", "experiments/EVIDENCE")]
GUIDES = (ROOT / "ch5_homework/INSTRUCTORS.md", ROOT / "ch5_homework/INSTRUCTORS.zh.md")
LIBRARY = (ROOT / "ch5_backend/README.md", ROOT / "ch5_backend/sparse/README.md")
PAPERS = sorted((ROOT / ".github").glob("*.md"))
READING = sorted((ROOT / "slides/reading").glob("*.md"))
DECKS = sorted((ROOT / "slides").glob("[0-9]-*.en.md"))


def read(path):
    return Path(path).read_text(encoding="utf-8")


def handouts():
    """The two languages' handouts: each its list of pages and all of their text."""
    both = zip(*[HANDOUTS, *PAGES])
    return [(pages, "\n".join(map(read, pages))) for pages in both]


def fences(text):
    """Code blocks: [(language, code)]."""
    return FENCE.findall(text)


def prose(text):
    """The text without code blocks."""
    return FENCE.sub("", text)


def headings(text):
    """[(level, words)] of the headings outside of code."""
    return [(len(marks), words) for marks, words in re.findall(r"^(#+) (.*)$", prose(text), re.M)]


def spans(text):
    """Inline code that is code, not a sentence in code's dress."""
    return [span for span in re.findall(r"`([^`\n]+)`", prose(text)) if not re.search(r"[\u3000-\u9fff]|\w \w+ \w", span)]


def links(text):
    return re.findall(r"\]\(([^)\s]+)\)", prose(text))


def sections(text, level=2):
    """[(heading, body)] at one level; what stands before the first heading comes first, with an empty heading."""
    parts = re.split(rf"^{'#' * level} (.*)$", FENCE.sub(lambda m: m[0].replace("\n#", "\n\x00"), text), flags=re.M)
    parts = [part.replace("\x00", "#") for part in parts]
    return [("", parts[0])] + list(zip(parts[1::2], parts[2::2]))


def slides(text):
    """[(id, is a result page, body)] of a deck."""
    pages = re.split(r"^---$", text, flags=re.M)[2:]
    found = []
    for page in pages:
        mark = re.search(r"^<!-- slide: ([\w-]+)( result)? -->$", page, re.M)
        found.append((mark[1] if mark else None, bool(mark and mark[2]), page))
    return found


def formulas(text):
    """TeX of a page without the words in \\text{…}."""
    found = re.findall(r"\$\$(.*?)\$\$|\$([^$]+)\$", prose(text), re.S)
    return [re.sub(r"\\text\{[^}]*\}", r"\\text{}", display or inline).split() for display, inline in found]


def plain(text):
    """A page with its matrices row by row, and without dollars."""
    for tex, words in ((r"\begin{bmatrix}", "[ "), (r"\end{bmatrix}", " ]"), ("\\\\", " ] [ "), ("&", " "), ("$", ""), (r"\cdot", "·"), (r"\to ", "→ "),
                       (r"\Delta ", "Δ"), ("-", "−"), ("： ", "：")):
        text = text.replace(tex, words)
    return re.sub(r"\s+", " ", text)
