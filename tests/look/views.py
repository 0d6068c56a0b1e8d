"""Every kind of page in every condition, as gray cells that can be kept and compared.

A cell is SIDE pixels wide, and its mean gray is kept in steps of STEP of 255. A view has changed if its size has, or if a cell
differs by more than a step: a word that is missing or elsewhere is seen, a dot is not. Digits are drawn as zeros: what a run has
measured is no part of how its page looks.
"""

import base64
import io
import itertools
import json
import zlib
from pathlib import Path
from unittest import mock

import numpy as np
from PIL import Image

from ch5_backend.course.base.language import speaker
from ch5_backend.course.grading import pages, summary
from ch5_backend.figures import mine, odometry
from tests.experiments.mine_numbers_test import write_run
from tests.experiments.report_texts import write_reports
from tests.grading.languages_test import record

WIDTHS, SCHEMES, LANGUAGES, HEIGHT = (1280, 768, 390), ("light", "dark"), ("en", "zh"), 900
CONDITIONS = tuple(itertools.product(LANGUAGES, WIDTHS, SCHEMES))
SIDE, STEP = {1280: 32, 768: 24, 390: 20}, 4
ACCEPTED = Path(__file__).with_name("accepted.json")
PIECE = 8000  # pixels that Chromium draws at a time
READY = """document.readyState === 'complete' && !document.querySelector('#MathJax_Message') && Promise.all([window.MathJax?.startup?.promise,
...[...document.images].map(one => one.decode().catch(() => 0))]).then(() => true)"""
RESTS = "ready.then(() => !present && !jobs.length)"
ZEROS = """(() => { const walk = document.createTreeWalker(document.documentElement, NodeFilter.SHOW_TEXT);
while (walk.nextNode()) { const one = walk.currentNode; if (!one.parentNode.closest('script, style, option, mjx-container')) {
const zeros = one.data.replace(/\\d[\\d.,]*\\d|\\d/g, '0').replace(/0 × 10[⁻⁰¹²³⁴-⁹]+/g, '0'); if (zeros !== one.data) one.data = zeros; } } })()"""


def kinds(site, lab, folder):
    """{kind: {language: (address, when it is ready)}}; what is not on the site is made in a folder."""
    end = {"en": "", "zh": ".zh"}
    found = {name: {language: ((site / place.format(end=end[language], language=language)).as_uri(), READY) for language in LANGUAGES}
             for name, place in (("site", "index.html"), ("handout", "homework/stage_1.1{end}.html"),
                                 ("lecture", "lectures/1-back-end.{language}.html"), ("deck", "slides/1-back-end.{language}.html"),
                                 ("guide", "guide{end}.html"))}
    found["site"] = {language: (f"{address}#{language}", ready) for language, (address, ready) in found["site"].items()}
    for name in ("chapter", "recording", "gauge"):
        (folder / name).mkdir()
        with mock.patch.object(odometry, "machine", return_value="2026-01-01, a processor, one thread, load 1"):
            write_reports(folder / name, name)
        found[name] = {language: ((folder / name / f"report{end[language]}.html").as_uri(), READY) for language in LANGUAGES}
    write_run(folder, H=2, S=2)
    mine.make(folder, "en")
    found["mine"] = {language: ((folder / mine.PAGES[language]).as_uri(), READY) for language in LANGUAGES}
    for language in LANGUAGES:
        say, one = speaker(language), record()
        (folder / language).mkdir()
        pages.write_feedback(folder / language, one, say)
        summary.write(folder / language, [one, record("s2")], {row["id"]: row["points"] for row in one["stages"]}, None, [], [], say)
    for name in ("feedback", "summary"):
        found[name] = {language: ((folder / language / f"{name}.html").as_uri(), READY) for language in LANGUAGES}
    for name, state in (("lab", "panel=solve&information=noise"), ("lab flight", "panel=window"), ("lab game", "panel=eliminate&order=0,3"), ("lab chain", "panel=marginalize&system=chain&drop=1"),
                        ("lab steps", "panel=steps&stop=judge"), ("lab beside", "panel=solve&beside=weight%3D100"), ("lab task", "task=baseline")):
        found[name] = {language: (f"{lab.as_uri()}?lang={language}#{state}", RESTS) for language in LANGUAGES}
    return found


def show(page, address, ready, width, scheme):
    page.show_as(width, HEIGHT, scheme == "dark")
    page.open(address, ready)


def look(page, width, first=""):
    """A picture of the whole page that is shown; `first` is done in it before. On a busy machine Chromium draws what is far below
    late: the picture counts once two in a row have the same cells."""
    page.evaluate(f"{first}{ZEROS}; document.querySelector('.bespoke-marp-osc')?.remove(); document.activeElement?.blur(); scrollTo(0, 0)")
    picture = drawn(page, width)
    for _ in range(4):
        before, picture = picture, drawn(page, width)
        if before.size == picture.size and np.array_equal(cells_of(before), cells_of(picture)):
            break
    return picture


def drawn(page, width):
    tall = page.evaluate("document.documentElement.scrollHeight")
    picture = Image.new("RGB", (width, tall))
    for top in range(0, tall, PIECE):
        clip = {"x": 0, "y": top, "width": width, "height": min(PIECE, tall - top), "scale": 1}
        shot = page.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png", "clip": clip, "captureBeyondViewport": True, "optimizeForSpeed": True})
        picture.paste(Image.open(io.BytesIO(base64.b64decode(shot["data"]))), (0, top))
    return picture


def cells_of(picture):
    """The mean gray of each cell, in steps."""
    width, height = picture.size
    side = SIDE[width]
    gray = picture.convert("L").resize((round(width / side), round(height / side)), Image.BOX)
    return np.asarray(gray) // STEP


def packed(cells, size):
    return [*size, *cells.shape, base64.b85encode(zlib.compress(cells.astype(np.uint8).tobytes(), 9)).decode()]


def unpacked(kept):
    return np.frombuffer(zlib.decompress(base64.b85decode(kept[4])), np.uint8).reshape(kept[2], kept[3])


def changed(kept, picture):
    """The cells (row, column) that differ; those of a page's new end, or (0, 0) for a size that is hardly another."""
    before, after = unpacked(kept).astype(int), cells_of(picture).astype(int)
    both, all_rows = sorted((len(before), len(after)))
    found = np.argwhere(np.abs(before[:both] - after[:both]) > 1).tolist()
    found += [[row, column] for row in range(both, all_rows) for column in range(before.shape[1])]
    return found or [[0, 0]] * (kept[:2] != [*picture.size])


def accepted():
    return json.loads(ACCEPTED.read_text(encoding="utf-8")) if ACCEPTED.exists() else {}


def accept(seen, words):
    """Keeps what was seen of the views whose names have all of these words; returns their names. A view that no page has any
    longer is left out when all are accepted."""
    names = [name for name in seen if all(word in name for word in words)]
    kept = {**(accepted() if words else {}), **{name: seen[name] for name in names}}
    ACCEPTED.write_text("{\n" + ",\n".join(f"{json.dumps(name)}: {json.dumps(kept[name])}" for name in sorted(kept)) + "\n}\n", encoding="utf-8")
    return names


def write_page(folder, found):
    """FOLDER/index.html: of each view (name, kept, rows and columns, cells) what was accepted, what is, and where they differ."""
    def gray(cells):
        packed_image = io.BytesIO()
        Image.fromarray((cells * STEP).astype(np.uint8)).save(packed_image, "PNG")
        return base64.b64encode(packed_image.getvalue()).decode()
    parts = []
    for name, kept, (rows, columns), cells in found:
        marks = "".join(f'<rect x="{column}" y="{row}" width="1" height="1"/>' for row, column in cells)
        before = f'<img src="data:image/png;base64,{gray(unpacked(kept))}" alt="accepted">' if kept else "<p>new</p>"
        parts.append(f'<h2>{name}</h2><div>{before}<span><img src="{file_of(name)}" alt="now"><svg viewBox="0 0 {columns} {rows}" '
                     f'preserveAspectRatio="none">{marks}</svg></span></div>')
    (folder / "index.html").write_text(f"""<!doctype html><meta charset="utf-8"><title>{len(found)} views differ</title><style>
div {{ display: flex; gap: 1em; align-items: start; }} div > * {{ width: 48%; position: relative; }} img {{ width: 100%; border: 1px solid gray;
image-rendering: pixelated; }} svg {{ position: absolute; inset: 0; width: 100%; height: 100%; fill: rgb(255 0 0 / .35); }}</style>
<h1>{len(found)} views differ from what was accepted</h1><p>python3 -m tests.look accept [WORD…] accepts those whose names have the words.</p>
{"".join(parts)}""", encoding="utf-8")


def file_of(name):
    return name.replace(" ", "_") + ".jpg"
