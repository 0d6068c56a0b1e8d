"""./course site: lectures, homework, report, API and lab as one folder that any static host can show.

What another command makes is taken from out/ if it is up to date and made otherwise; only the lab, whose compiler is large, is
left out where it is neither there nor can be compiled. Run as a module with DIR, it makes DIR/site of what DIR holds.
"""

import json
import re
import shutil
import sys
import tempfile
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from ch5_backend.figures import page
from ch5_backend.figures.words import PAGES

from ..base import prebuilt
from ..base.cmake_build import ROOT
from ..base.errors import CourseError, warn
from ..base.output_dir import locked_dir, made_dir
from ..base.processes import running

HERE = Path(__file__).resolve().parent
MARK = ".nojekyll"  # GitHub shows the files as they are; and a folder with it is ours to replace
LANGUAGES = tuple(PAGES)
LINK = re.compile(r'(?:href|src)="([^"#?:]+)[^":]*"')
# A student may read the site: what a lecturer says stays in out/slides.
NOTE = re.compile(r'<div class="bespoke-marp-note".*?</div>', re.DOTALL)
LAB_LINK_OF_PDF = re.compile(rb"\(\.\./lab\.html[^)]*\)")
LAB_LINK = re.compile(r'<a href="(?:\.\./)?lab\.html[^"]*"[^>]*>(.*?)</a>', re.DOTALL)


def site(folder: str) -> int:
    """Makes what is missing or out of date in the project's out/, and FOLDER/site of it; 0."""
    from . import handouts  # noqa: F401  what is missing is said before minutes are spent
    parts, target = ROOT / "out", Path(folder or "out")
    with made_dir(parts), made_dir(target):
        course("run", "--out", parts)
        if stale := prebuilt.stale_decks(parts):
            course("slides", *sorted(stale))
        course("docs", "--out", parts / "api")
        if prebuilt.why_not_lab(parts) and shutil.which("em++"):
            course("lab", "--out", parts)
        with locked_dir(target):
            assemble(parts, target / "site")
    return 0


def course(*words) -> None:
    """Another command of ours; raises CourseError if it fails."""
    with running([sys.executable, "-X", "utf8", "-m", "ch5_backend.course", *map(str, words)]) as process:
        if code := process.wait():
            raise CourseError(f"./course {words[0]} failed; its message is above", code)


def assemble(out: Path, target: Path) -> None:
    """The site from what OUT holds, at once; says what is left out."""
    from .handouts import FIGURES, Links, sources, write_pages
    if target.exists() and any(target.iterdir()) and not (target / MARK).exists():
        raise CourseError(f"{target} holds something else than a site; choose another folder with --out")
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".site-") as folder:
        new = Path(folder) / "site"
        new.mkdir()
        (new / MARK).touch()
        left_out = [*bring_lab(out, new), *bring_decks(out, new), *bring_report(out, new), *bring_api(out, new)]
        for folder, place in FIGURES.items():
            shutil.copytree(ROOT / folder, new / place, dirs_exist_ok=True)
        there = {str(path.relative_to(new)) for path in new.rglob("*") if path.is_file()} | {"index.html", *sources().values()}
        write_pages(new, Links(there))
        write_front(new)
        if target.exists():
            shutil.rmtree(target)
        new.rename(target)
    for what in left_out:
        warn(f"the site is without {what}")
    size = sum(path.stat().st_size for path in target.rglob("*") if path.is_file())
    print(f"The site: {target / 'index.html'}   {size / 1e6:.1f} MB")


def bring_lab(out: Path, new: Path) -> list:
    """The page, if it is up to date; what is left out, in words, as from the others."""
    if why_not := prebuilt.why_not_lab(out):
        return [f"the lab, {out / 'lab.html'}: {why_not}; ./course lab makes it, with emscripten"]
    shutil.copy(out / "lab.html", new)
    return []


def bring_decks(out: Path, new: Path) -> list:
    """Without their speaker notes; without the lab, what leads there is words."""
    left_out, has_lab = [], (new / "lab.html").exists()
    (new / "slides").mkdir()
    for deck in sorted((ROOT / "slides").glob("[0-9]-*.md")):
        for built in (out / "slides" / f"{deck.stem}.html", out / "slides" / f"{deck.stem}.pdf"):
            if not built.exists():
                left_out.append(f"{built}; ./course slides makes it")
            elif built.suffix == ".pdf":
                pdf = built.read_bytes()
                (new / "slides" / built.name).write_bytes(pdf if has_lab else without_lab(pdf))
            else:
                html = NOTE.sub("", built.read_text(encoding="utf-8"))
                (new / "slides" / built.name).write_text(html if has_lab else LAB_LINK.sub(r"\1", html), encoding="utf-8")
    return left_out


def without_lab(pdf: bytes) -> bytes:
    """Every byte at its place, since a PDF counts them."""
    return LAB_LINK_OF_PDF.sub(lambda link: b"()".ljust(len(link[0])), pdf)


def bring_report(out: Path, new: Path) -> list:
    """Both languages, and the tables and figures that they link to."""
    pages = [out / name for name in PAGES.values() if (out / name).exists()]
    for report in pages:
        html = report.read_text(encoding="utf-8")
        (new / report.name).write_text(html if (new / "lab.html").exists() else LAB_LINK.sub(r"\1", html), encoding="utf-8")
        for link in set(LINK.findall(html)):
            if link.startswith(("csv/", "figures/", "kept/")) and (out / link).is_file():
                (new / link).parent.mkdir(exist_ok=True)
                shutil.copy(out / link, new / link)
    return [] if pages else [f"{out / 'report.html'}; ./course run makes it"]


def bring_api(out: Path, new: Path) -> list:
    if not (out / "api" / "index.html").exists():
        return [f"{out / 'api'}; ./course docs makes it"]
    shutil.copytree(out / "api", new / "api")
    return []


def write_front(new: Path) -> None:
    """index.html, in both languages, with links to what is there."""
    words = json.loads((HERE / "site.json").read_text(encoding="utf-8"))
    about = {"en": {}, "zh": {}}
    for lang in LANGUAGES:
        end = "" if lang == "en" else ".zh"
        places = ((PAGES[lang], "report"), (f"lab.html?lang={lang}", "lab"), ("api/index.html", "api"), (f"guide{end}.html", "guide"))
        about[lang] = [(place, words[lang][name], words[lang][f"{name}_about"]) for place, name in places
                       if (new / place.partition("?")[0]).exists()]
    template = Environment(loader=FileSystemLoader(HERE), autoescape=True, undefined=StrictUndefined).get_template("site.html")
    body = template.render(words=words, decks={lang: decks(new, lang) for lang in LANGUAGES},
                           pages={lang: homework(lang) for lang in LANGUAGES}, more=about)
    page.write(new / "index.html", f"{words['en']['title']} · {words['zh']['title']}", [Markup(body)])


def decks(new: Path, lang: str) -> list:
    """[(title, [(file, kind)])]: to read, and the slides."""
    found = []
    for deck in sorted((ROOT / "slides").glob(f"[0-9]-*.{lang}.md")):
        title = re.search(r"^title: (.*)$", deck.read_text(encoding="utf-8"), re.MULTILINE)[1].strip('"')
        files = [(f"lectures/{deck.stem}.html", {"en": "text", "zh": "文字"}[lang])]
        files += [(f"slides/{deck.stem}.{kind}", kind.upper()) for kind in ("html", "pdf")
                  if (new / "slides" / f"{deck.stem}.{kind}").exists()]
        found.append((title, files))
    return found


def homework(lang: str) -> list:
    """[(file, title)] of the pages of this language: where they are listed, the stages, and what belongs to all of them."""
    from .handouts import sources
    found = []
    for source, place in sources().items():
        if place.startswith("homework/") and source.endswith(".zh.md") == (lang == "zh"):
            title = re.search(r"^# (.*)$", (ROOT / source).read_text(encoding="utf-8"), re.MULTILINE)[1]
            found.append((place, title.replace("`", "")))
    return sorted(found, key=lambda page: (not page[0].startswith("homework/index"), not page[0].startswith("homework/stage_")))


if __name__ == "__main__":
    try:
        assemble(Path(sys.argv[1]), Path(sys.argv[1]) / "site")
    except CourseError as error:
        warn(error)
        sys.exit(error.exit_code)
