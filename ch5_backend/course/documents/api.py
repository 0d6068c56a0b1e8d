"""./course docs: makes the pages of the API with Doxygen and MathJax: readable offline, the index of formulas in front.

Any warning of Doxygen's is a failure.
"""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from slides import npm
from slides.browser import BuildError

from ..base.cmake_build import ROOT
from ..base.errors import CourseError
from ..base.output_dir import made_dir

AT_LEAST = (1, 9, 4)  # knows WARN_IF_INCOMPLETE_DOC


def docs(folder: str) -> int:
    """Makes FOLDER, by default out/api; 0. Raises CourseError."""
    out = Path(folder or "out/api").absolute()
    with made_dir(out.parent):
        try:
            build(out)
        except BuildError as error:
            raise CourseError(str(error), error.code) from None
    return 0


def find_doxygen():
    path = shutil.which("doxygen")
    if not path:
        raise BuildError("Doxygen is missing; Debian: apt-get install doxygen")
    version = subprocess.run([path, "--version"], capture_output=True, text=True).stdout
    if tuple(map(int, re.findall(r"\d+", version)[:3])) < AT_LEAST:
        raise BuildError(f"{path} is version {version.strip()}, at least {'.'.join(map(str, AT_LEAST))} is needed; Debian 12 "
                         "and Ubuntu 24.04 have it")
    return path


def doxygen(**settings):
    """Runs it with these settings besides those of the Doxyfile; what it says."""
    lines = "".join(f'{name} = "{value}"\n' for name, value in settings.items())
    return subprocess.run([find_doxygen(), "-"], cwd=ROOT, input=(Path(__file__).parent / "Doxyfile").read_text(encoding="utf-8") + lines,
                          capture_output=True, text=True)


def build(out):
    """All pages at once: they are made beside their place."""
    find_doxygen()
    if out.exists() and any(out.iterdir()) and not (out / "doxygen.css").exists():
        raise BuildError(f"{out} holds something else than pages of an API; choose another folder with --out")
    mathjax = npm.installed() / "mathjax-full" / "es5" / "tex-svg.js"
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=".api-") as folder:
        done = doxygen(OUTPUT_DIRECTORY=folder, HTML_OUTPUT="api")
        if done.returncode or done.stderr:  # a filter that fails is no warning
            raise BuildError(f"Doxygen warns:\n{done.stderr.strip()}", code=1)
        pages = Path(folder) / "api"
        for page in pages.glob("*.html"):
            mend(page)
        (pages / "mathjax").mkdir()
        shutil.copy(mathjax, pages / "mathjax" / "MathJax.js")  # version 3 where Doxygen looks for version 2: see the Doxyfile
        if out.exists():
            shutil.rmtree(out)
        pages.rename(out)
    print(out / "index.html")


def mend(page):
    """Doxygen 1.9 names no language, lets no key scroll what is wide, and links to a list of nested classes where all are hidden."""
    text = page.read_text(encoding="utf-8").replace("<html ", '<html lang="en" ', 1)
    text = re.sub(r'<(pre class="fragment"|div class="(?:fragment|memproto)")', r'<\1 tabindex="0"', text)
    if '<a name="nested-classes">' not in text:
        text = re.sub(r'<a href="#nested-classes">\w+</a>(?: &#124;)?\s*', "", text)
    page.write_text(text, encoding="utf-8")
