"""The READMEs, the guides and the handouts: both languages say the same, and what they say is so."""

import json
import re
import unittest
from collections import Counter

from ch5_backend.course.base.commands import COMMANDS
from ch5_backend.course.base.anchors import anchor
from ch5_backend.course.homework import stage_tables
from tests.docs.markdown import (DECKS, ENGINEERS, GUIDES, HANDOUTS, LIBRARY, PAGES, PAPERS, READING, READMES, ROOT, fences, formulas,
                                 handouts, headings, links, prose, read, sections, slides, spans)
from tests.project import BUILD, run

from slides import build

HOSTED = "../../deployments/github-pages"  # beside the repository on its host: what .github/workflows/site.yml publishes
PAIRS = (READMES, *ENGINEERS, HANDOUTS, *PAGES, GUIDES)
ALL = [path for pair in PAIRS for path in pair]


def symbols(code):
    """What a figure shows in every language: its letters, numbers, signs and lines, without words and punctuation."""
    code = re.sub(r"[\u3000-\u9fff\uff00-\uffef]+|(?<![\w.])(a|[A-Za-z]?[a-z]{2,}('s)?)(?![\w(])", " ", code)
    return Counter(re.sub(r"[,:;.](?=\s|$)", " ", code).split())


def solutions():
    return {path.name: re.findall(r"// BEGIN SOLUTION (\S+)", read(path)) for path in (ROOT / "solutions").glob("*.cc")}


class Documents(unittest.TestCase):
    def test_both_languages_have_the_same_sections(self):
        for english, chinese in PAIRS:
            levels = [[level for level, _ in headings(read(path))] for path in (english, chinese)]
            self.assertEqual(*levels, f"{english.name} and {chinese.name}")
            stages = [re.findall(r"^##? (?:Stage|阶段) ([\d.]+[AB]?) ·", read(path), re.M) for path in (english, chinese)]
            self.assertEqual(*stages)

    def test_both_languages_have_the_same_code_and_pictures(self):
        for english, chinese in PAIRS:
            for (language, one), (other_language, other) in zip(fences(read(english)), fences(read(chinese)), strict=True):
                self.assertEqual(language, other_language, chinese)
                self.assertEqual(symbols(one), symbols(other), chinese)
                if language:  # words of a figure may be translated, and comments to a command, but no code
                    self.assertEqual(*(re.sub(r" +# .*", "", code) if language == "sh" else code for code in (one, other)), chinese)

    def test_handouts_have_the_same_formulas_and_a_code_host_sets_them(self):
        """A host takes \\\\ only at the end of a line, and dollars only beside blanks and punctuation; it reads the rest as Markdown first."""
        count = 0
        for english, chinese in (HANDOUTS, *PAGES):
            self.assertEqual(*({" ".join(formula) for formula in formulas(read(path))} for path in (english, chinese)), chinese)
            for path in (english, chinese):
                text = prose(read(path))
                for display in re.findall(r"\$\$.*?\$\$", text, re.S):
                    self.assertRegex(display, r"^\$\$\n(?s:.+)\n\$\$$", path)
                    self.assertNotRegex(display, r"\\\\[^\n]|\n\n|\n[-+*>#] |[<>]", path)
                for inline in re.finditer(r"(.?)\$([^$]+)\$(.?)", re.sub(r"\$\$.*?\$\$", "", text, flags=re.S)):
                    count += 1
                    self.assertNotRegex(inline[2], r"\\[^A-Za-z]|[<>*|\n]|[})]_", path)
                    self.assertRegex(inline[1] + " " + inline[3], r"^[\s(|*]? [^\w]?$", f"{path}: {inline[0]}")
        self.assertGreater(count, 500)

    def test_the_labs_addresses_are_ones_that_it_knows(self):
        words = json.loads(read(ROOT / "ch5_backend/lab/page/text.json"))
        addresses = {address for _, text in handouts() for address in re.findall(r"`lab\.html#(.*?)`", text)}
        self.assertGreater(len(addresses), 5)
        for name, value in (setting.split("=") for address in addresses for setting in address.split("&")):
            self.assertTrue(f"{name}.{value}" in words or name in words and value.isdigit(), f"{name}={value}")

    def test_both_languages_name_the_same_things(self):
        for english, chinese in PAIRS:
            for (title, one), (_, other) in zip(sections(read(english)), sections(read(chinese))):
                named = [Counter(span.replace(".zh", "") for span in spans(body)) for body in (one, other)]
                self.assertEqual(set(named[0]), set(named[1]), f"{chinese}: {title}")
                for pattern in (r"<details>", r"^\|.*\|$", r"^[-*] |^\d\. ", r"!\["):
                    counts = [len(re.findall(pattern, prose(body), re.M)) for body in (one, other)]
                    self.assertEqual(*counts, f"{chinese}: {title}: {pattern}")

    def test_local_links_lead_somewhere(self):
        count = 0
        for path in (*ALL, *LIBRARY, *PAPERS, *READING):
            for link in links(read(path)):
                if link.startswith("http") or link == HOSTED:
                    continue
                count += 1
                file, _, fragment = link.partition("#")
                target = (path.parent / file).resolve() if file else path
                self.assertTrue(target.exists(), f"{path}: {link}")
                if fragment:
                    self.assertIn(fragment, [anchor(words) for _, words in headings(read(target))], f"{path}: {link}")
        self.assertGreater(count, 10)

    def test_files_that_are_named_exist(self):
        count = 0
        for path in [*ALL, *PAPERS, *DECKS]:
            for name in re.findall(r"`((?:\w+/)*\w+(?:\.\w+)?\.(?:h|cc|py|md|txt|html))`", read(path)):
                if name.startswith("out/"):
                    continue
                count += 1
                places = [ROOT / folder / name for folder in ("", "ch5_backend", "ch5_homework", "solutions")]
                self.assertTrue(any(place.exists() for place in places), f"{path}: {name}")
        self.assertGreater(count, 20)

    def test_commands_that_are_named_exist(self):
        named = {word for path in [*ALL, *PAPERS, *DECKS] for word in re.findall(r"\./course (\w+)", read(path))}
        self.assertLessEqual({"run", "test", "check", "status", "slides"}, named)
        self.assertLessEqual(named, {"help", "watch", *COMMANDS})  # that each has help: tests/conventions/command_line_test.py

    def test_modules_that_are_named_exist(self):
        named = {(path.name, program) for path in (*ALL, *LIBRARY, *PAPERS, *DECKS, ROOT / "tests/grading/MUTANTS.md")
                 for program in re.findall(r"python3 (-m [\w.]+\w|\S+\.py)", read(path))}
        self.assertTrue(named)
        for page, program in sorted(named):
            self.assertTrue(program.startswith("-m "), f"{page}: {program}: imports by their full names need -m")
            place = ROOT / program[3:].replace(".", "/")
            self.assertTrue(place.with_suffix(".py").exists() or (place / "__main__.py").exists(), f"{page}: {program}")

    def test_the_version_is_one(self):
        """The Python module's is proven where its wheel is made."""
        version = ".".join(re.findall(r"define CH5_VERSION_\w+ (\d+)", read(ROOT / "ch5_backend/version.h")))
        for path, words in ((BUILD / "CMakeCache.txt", f"CMAKE_PROJECT_VERSION:STATIC={version}\n"),
                            (ROOT / ".github/CITATION.cff", f"\nversion: {version}\n"), (ROOT / ".github/CHANGELOG.md", f"\n## {version} (")):
            self.assertIn(words, read(path), path)
        self.assertEqual(run(ROOT / "course", "--version").stdout, version + "\n")

    def test_front_page_is_short(self):
        for path in READMES:
            self.assertLessEqual(len(re.findall(r"[\u4e00-\u9fff]|\S+", read(path))), 700, path)

    def test_tables_of_stages_are_current(self):
        for path, language in stage_tables.PAGES.items():
            self.assertEqual(read(path), stage_tables.with_stages(read(path), language), f"run python3 -m {stage_tables.__name__}")

    def test_syllabus_has_the_minutes_of_the_notes(self):
        for path in READMES:
            for (lecture, minutes), deck in zip(re.findall(r"^\| (\d) \| [^|]+ \| (\d+) \|", read(path), re.M), DECKS, strict=True):
                spoken = sum(map(int, re.findall(r"^<!-- \((\d+) min\)", read(deck), re.M)))
                self.assertAlmostEqual(int(minutes), spoken, delta=2, msg=f"{path}: lecture {lecture}")

    def test_handout_treats_every_todo(self):
        for (path, *_), text in handouts():
            table = re.findall(r"^\| \[[\d.]+[AB]?\]\S* \| ([^|]+) \| `(\w+\.cc)` \|", text, re.M)
            listed = {}
            for todos, file in table:
                listed.setdefault(file, []).extend(todo.strip() for todo in todos.split(","))
            self.assertEqual(listed, {file: solutions()[file] for file in listed}, path)
            rows = re.findall(r"^\| (\d[\d.]*[a-z]?) \| .*\|$", text, re.M)
            self.assertEqual(rows, [todo for todos in listed.values() for todo in todos], path)

    def test_the_second_depth_has_the_gaps_of_the_table(self):
        stages = json.loads(read(ROOT / "ch5_homework/stages.json"))["stages"]
        wanted = [todo for stage in stages for todo in stage.get("deep", [])]
        for (path, *_), text in handouts():
            self.assertEqual(re.findall(r"^\| \*\*(\S+)\*\* \|", text, re.M), wanted, path)

    def test_instructors_guide_shows_every_page_of_the_first_deck(self):
        pages = [name for name, _, _ in slides(read(DECKS[0]))]
        for path in GUIDES:
            rows = re.findall(r"^\| \d+ \| (`[^|]+) \|", read(path), re.M)
            self.assertEqual([name for row in rows for name in re.findall(r"`([\w-]+)`", row)], pages, path)

    def test_names_that_a_stage_needs_are_in_their_header(self):
        for (path, *_), text in handouts():
            boxes = re.findall(r"^\| (`.+?) \| `([\w/]+\.h)` \|", text, re.M)
            self.assertGreater(len(boxes), 10, path)
            for names, header in boxes:
                declared = read(ROOT / "ch5_backend" / header)
                for name in re.findall(r"`(\w+)", names):
                    self.assertRegex(declared, rf"\b{name}\b", f"{path}: {name} is not in {header}")

    def test_handout_has_no_answer(self):
        """The answers are the lines between BEGIN SOLUTION and BLANK."""
        answers = [line.strip() for file in (ROOT / "solutions").glob("*.cc")
                   for answer in re.findall(r"BEGIN SOLUTION.*?\n(.*?)// BLANK", read(file), re.S) for line in answer.splitlines()]
        for (path, *_), text in handouts():
            self.assertEqual([line for line in answers if len(line) > 12 and line in text], [], f"{path} gives answers away")

    def test_reading_edition_has_the_words_of_the_decks(self):
        """Whatever the numbers are: what stands between two placeholders is there, one after the other."""
        code = build.blanks()
        for deck in build.decks():
            place, lang = ROOT / "slides/reading", build.language(deck)
            titles = {name: build.TITLE.search(read(place / f"figures/{name}.{lang}.svg"))[1] for name in build.FIGURE.findall(read(deck))}
            text = build.PLACEHOLDER.sub(lambda found: code.get(found[1], found[0]), build.SLIDE_ID.sub("", read(deck)))
            made, end = read(place / deck.name), 0
            for part in build.PLACEHOLDER.split(build.reading(deck.stem, lang, text, titles))[::2]:
                start = made.find(part, end)
                self.assertTrue(end <= start < end + 500, f"{deck.name} has changed: python3 -m slides.build --reading {deck.stem}\n{part}")
                end = start + len(part)
            self.assertEqual(end, len(made), deck.name)

    def test_every_stage_begins_with_its_lecture(self):
        for pages, _ in handouts():
            for page in pages:
                if page.name.startswith("stage_"):
                    head = read(page).partition("\n## ")[0]
                    self.assertRegex(head, r"\]\(\.\./\.\./slides/reading/\d-[\w-]+\.(en|zh)\.md#", f"{page} names no page of a lecture")

    def test_map_shows_every_folder(self):
        for path in ENGINEERS[1]:
            rows = re.findall(r"^\| (`\w+/`.*?) \|", read(path), re.M)
            there = sorted(folder.name for folder in (ROOT / "ch5_backend").iterdir()
                           if folder.is_dir() and not folder.name.startswith("_"))
            self.assertEqual(sorted(re.findall(r"`(\w+)/`", " ".join(rows))), there, path)

    def test_chinese_text_has_chinese_punctuation(self):
        for path in [pair[1] for pair in PAIRS] + [str(deck).replace(".en.", ".zh.") for deck in DECKS]:
            text = re.sub(r"`[^`\n]*`|\$[^$]*\$|\]\([^)]*\)|\{\{.*?\}\}|^\w+: ", "·", prose(read(path)), flags=re.M)
            faults = re.findall(r".{0,12}[\u4e00-\u9fff][,:;?!()].{0,6}|.{0,6}[,;?!()][\u4e00-\u9fff].{0,12}", text)
            self.assertEqual(faults, [], f"{path}: half-width punctuation in Chinese text")
