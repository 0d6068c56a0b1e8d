"""Node.js and Chromium: finding them, printing a deck, looking at it, and measuring that nothing leaves its page."""

import json
import re
import shutil
import subprocess
import tempfile
from html import unescape
from pathlib import Path

HERE = Path(__file__).resolve().parent
NODE_AT_LEAST = 18


class BuildError(Exception):
    """A message for the user and an exit code: 2 for something missing, 1 for a step that failed."""

    def __init__(self, message, code=2):
        super().__init__(message)
        self.code = code


def run(command, failure, cwd=None):
    """Runs a command and returns its output, which is shown only if it fails."""
    done = subprocess.run(command, cwd=cwd, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode:
        raise BuildError(f"{failure}:\n{(done.stdout + done.stderr).strip()[-2000:]}", code=1)
    return done.stdout


def node():
    """The first Node.js that is new enough; on Ubuntu 22.04 the system's is version 12."""
    old = []
    for name in ("node", "/usr/bin/node", "nodejs", "/usr/local/bin/node"):
        path = shutil.which(name)
        version = path and run([path, "--version"], f"{path} does not run").strip()
        if version and int(re.match(r"v?(\d+)", version)[1]) >= NODE_AT_LEAST:
            return path
        if version:
            old.append(f"{path} is {version}")
    found = f", but {old[0]}" if old else ", which is missing"
    raise BuildError(f"the slides need Node.js {NODE_AT_LEAST} or newer{found}; Debian 12 and Ubuntu 24.04 have it "
                     "(apt-get install nodejs npm), for older systems see nodejs.org")


def chromium():
    """The path of Chromium or Chrome."""
    for name in ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"):
        if path := shutil.which(name):
            return path
    raise BuildError("a PDF needs Chromium; Debian: apt-get install chromium; with --html there is none")


def chromedriver():
    """The path of the program by which Selenium drives Chromium."""
    if path := shutil.which("chromedriver"):
        return path
    raise BuildError("a page is driven with chromedriver, which is missing")


# A page is drawn alike in every container, as every user.
HEADLESS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
            "--force-color-profile=srgb")


def headless(*words):
    """Runs Chromium with a profile of its own, which is deleted again."""
    with tempfile.TemporaryDirectory(prefix="ch5-chromium-") as profile:
        return run([chromium(), *HEADLESS, f"--user-data-dir={profile}", *words], "Chromium failed")


def pdf(page, target):
    target.unlink(missing_ok=True)
    headless("--no-pdf-header-footer", f"--print-to-pdf={target}", page.resolve().as_uri())
    if not target.exists():
        raise BuildError(f"Chromium did not print {target}", code=1)
    target.write_bytes(relative_links(target.read_bytes(), page.resolve().parent.parent.as_uri()))


def relative_links(printed, base):
    """The same PDF, of the same length, with ../NAME where Chromium has put this machine's BASE/NAME."""
    return re.sub(rb"\(" + re.escape(base.encode()) + rb"/([^)]*)\)", lambda link: (b"(../" + link[1] + b")").ljust(len(link[0])),
                  printed)


def images(source, folder):
    """Pages of a PDF as FOLDER/NAME-01.png …, with Debian's poppler-utils."""
    if not shutil.which("pdftoppm"):
        raise BuildError("images need pdftoppm; Debian: apt-get install poppler-utils")
    folder.mkdir(parents=True, exist_ok=True)
    run(["pdftoppm", "-r", "72", "-png", str(source), str(folder / source.stem)], f"no images of {source}")


def overflow(pages):
    """What reaches out of its place in built decks, which share their styles: {deck: (pages, sentences)}; see overflow.js. All
    at once: Chromium's start takes as long as a deck."""
    decks = []
    for page in pages:
        html = re.sub(r"<script\b.*?</script>", "", page.read_text(encoding="utf-8"), flags=re.S)  # all pages at once, not one by one
        head, body = html.split("<body>", 1)
        language = re.search(r'<html lang="(\w+)"', head)[1]
        decks.append(f'<template id="{page.stem}" lang="{language}">{body.split("</body>")[0]}</template>')
    probe = (HERE / "overflow.js").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory(prefix="ch5-overflow-") as folder:
        copy = Path(folder) / "decks.html"
        copy.write_text(f"{head}<body>{''.join(decks)}<script>{probe}</script></body></html>", encoding="utf-8")
        dom = headless("--window-size=1400,900", "--virtual-time-budget=20000", "--dump-dom", copy.as_uri())
    found = re.search(r'<pre id="overflow">(.*?)</pre>', dom, re.S)
    if not found:
        raise BuildError(f"{', '.join(page.name for page in pages)} could not be measured", code=1)
    return {deck: tuple(measured) for deck, measured in json.loads(unescape(found[1])).items()}
