"""The students' archive: the same bytes from every clone, no line of a solution, and all that a student does works from it."""

import json
import os
import re
import shutil
import subprocess
import sys
import unittest
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path

from tests.folder import FolderTest
from tests.project import ROOT, run

os.environ.setdefault("CH5_BUILD_DIR", os.environ.get("CH5_BUILD", ""))  # before it is read
from ch5_backend.course.base.cmake_build import BUILD
from ch5_backend.course.base import prebuilt
from ch5_backend.course.grading import student
from ch5_backend.course.homework import answers
from ch5_backend.course.homework.regions import FILES, STAGES, regions, solution_text

WHY_NOT = ("" if (ROOT / ".git").exists() else "only a clone knows which files are the project's") or (
    "the archive is made with GCC" if "clang" in os.environ.get("CH5_CXX", "") else "")
# Lines of a solution that the library needs elsewhere, too.
ALLOWED = {
    "prior.x0.push_back(block.x0);": "each prior of the library keeps its linearization points so",
    "for (size_t i = 0; i < 2; ++i) {": "any loop over two",
    "const Frame& oldest = window.frames.front();": "the lab draws a window's frames",
}
# In a name: Eigen's types for a sum, a product, a block.
FORMULA = re.compile(r"_Z\w*5Eigen\w*(?:13CwiseBinaryOp|7Product|5Block|9Transpose)\w*")


def bare(text: str) -> str:
    return re.sub(r"\s+", "", text)


def secret_lines() -> dict:
    """{line of a solution, without its comment: TODO}, of those that say something and that no student is given."""
    given = bare("".join(path.read_text(encoding="utf-8") for pattern in ("*.cc", "README*.md", "handout/*.md")
                         for path in (ROOT / "ch5_homework").glob(pattern)))
    lines = {line.partition("//")[0].strip(): region.todo for name in FILES for region in regions(solution_text(name))
             if region.kind == "SOLUTION" for line in region.solution.splitlines()}
    return {line: todo for line, todo in lines.items() if len(line) > 20 and bare(line) not in given and line not in ALLOWED}


def put(files: dict, folder: Path) -> None:
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


@unittest.skipIf(WHY_NOT, WHY_NOT)
class Archive(FolderTest):
    @classmethod
    def setUpClass(cls):
        cls.compiled = student.compiled_solutions()
        cls.files = student.student_files(student.tracked_files(), cls.compiled, {})

    def test_no_line_of_a_solution_is_in_it(self):
        secrets = secret_lines()
        self.assertGreater(len(secrets), 50)
        self.assertEqual({todo[0] for todo in secrets.values()}, {stage["id"][0] for stage in STAGES})
        texts = {name: bare(content.decode("utf-8", "replace")) for name, content in self.files.items()}
        found = [(name, todo, line) for name, text in texts.items() for line, todo in secrets.items() if bare(line) in text]
        self.assertEqual(found, [])
        for line in ALLOWED:
            self.assertTrue(any(bare(line) in text for text in texts.values()), f"allowed for nothing: {line}")

    def test_no_name_in_the_objects_spells_a_formula_out(self):
        for name in FILES:
            self.assertRegex(self.compiled[f"solutions/{name}"], FORMULA)
            given = self.files[f"solutions/{name.removesuffix('.cc')}.o"].decode("latin-1")
            self.assertTrue(given.startswith("\x7fELF"), "no text that a file could carry")
            self.assertNotRegex(given, FORMULA)
            self.assertNotIn(str(ROOT), given)

    def test_what_gives_solutions_away_is_left_out(self):
        for name in self.files:
            self.assertNotRegex(name, r"^(solutions|ch5_homework/judge/right)/.*(\.cc|\.s|\.md)$|\.samples$|\.mistakes$|\.attacks$|INSTRUCTORS|GRADING|^slides/[^/]*\.md$|^\.git/")
        self.assertLessEqual({"course", "README.md", "solutions/problem.o", "ch5_homework/problem.cc", "ch5_homework/judge/right/problem.o",
                              "slides/figures/overview.en.svg", "ch5_homework/judge/stage_1_1.cc"}, set(self.files))

    def test_no_sentence_about_a_mistake_is_in_the_clear(self):
        named = {row.cause["id"] for row in answers.read_table() if not row.cause["id"].startswith("matrix.")}
        self.assertGreater(len(named), 300)
        texts = {name: content.decode("utf-8", "replace") for name, content in self.files.items()}
        for language in ("en", "zh"):
            words = json.loads((ROOT / f"ch5_backend/course/base/language/{language}.json").read_text(encoding="utf-8"))
            for topic, name in (cause.rsplit(".", 1) for cause in sorted(named)):
                piece = max(re.split(r"\{\w+\}", words[topic][name]), key=len)
                if len(piece) > 30:  # shorter ones are any words
                    self.assertEqual([file for file, text in texts.items() if piece in text], [], piece)

    def test_its_pages_link_to_nothing_that_is_missing(self):
        for name, content in self.files.items():
            for target in re.findall(r"\]\((?!https?:|#)([^)#\s]+)", content.decode()) if name.endswith(".md") else ():
                self.assertIn(os.path.normpath(os.path.join(os.path.dirname(name), target)), self.files, name)
        self.assertNotIn("instructors", self.files["README.md"].decode().lower())
        for page in ("README.md", "README.zh.md"):
            self.assertNotIn("./course slides", self.files[page].decode())
        self.assertNotIn("助教", self.files["README.zh.md"].decode())

    def test_what_it_cannot_do_it_says(self):
        put({"course": self.files["course"]}, self.folder)
        for command in ("grade", "pack", "slides", "docs", "site"):
            done = run("sh", self.folder / "course", command)
            self.assertEqual((done.returncode, f"students' archive, without '{command}'" in done.stderr), (2, True), command)

    def test_it_configures(self):
        put(self.files, self.folder)
        done = run("cmake", "--preset", "release", cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_the_skeletons_come_out_of_it(self):
        put(self.files, self.folder)
        for words in ((), ("--depth", "2")):
            for root, out in ((self.folder, "theirs"), (ROOT, "ours")):
                subprocess.run([sys.executable, "-m", "ch5_backend.course.homework.make_skeleton", *words, "--output",
                                self.folder / out], check=True, env={**os.environ, "PYTHONPATH": str(root)})
            for name in FILES:
                theirs, ours = ((self.folder / out / name).read_text() for out in ("theirs", "ours"))
                self.assertEqual(theirs, ours, (name, words))


class BuiltPages(FolderTest):
    def lab(self) -> Path:
        """The folder, with a page and the record of what it was made of."""
        (self.folder / "lab.html").write_text("<p>the lab</p>")
        prebuilt.record_lab(self.folder, prebuilt.lab_sources())
        return self.folder

    def said(self, out: Path) -> tuple:
        words = StringIO()
        with redirect_stderr(words):
            files = student.built_pages(out)
        return set(files), words.getvalue()

    def test_a_page_that_its_sources_would_give_is_packed(self):
        names, words = self.said(self.lab())
        self.assertEqual(names, {"lab.html", prebuilt.RECORD})
        self.assertNotIn("lab.html is left out", words)
        self.assertIn("1-back-end.en.pdf is left out: not built yet; ./course slides makes it", words)

    def test_a_page_is_left_out_with_words_once_a_source_or_the_page_has_changed(self):
        for change, why in ((lambda record: {**record, "ch5_backend/graph/loss.cc": "0"}, "ch5_backend/graph/loss.cc has changed"),
                            (lambda record: {**record, "ch5_backend/gone.cc": "0"}, "ch5_backend/gone.cc has changed"),
                            (lambda record: {**record, "lab.html": "0"}, "it is not as it was built")):
            out = self.lab()
            path = out / prebuilt.RECORD
            path.write_text(json.dumps(change(json.loads(path.read_text()))))
            names, words = self.said(out)
            self.assertEqual(names, set())
            self.assertIn(f"lab.html is left out: {why}", words)

    def test_a_link_leads_to_what_the_archive_has_or_is_words(self):
        text = "[a](../../slides/reading/1-back-end.en.md#conventions-written-once) [b](../../slides/2-solvers.en.md)"
        files = {"slides/reading/1-back-end.en.md": b""}
        self.assertEqual(student.without_dead_links("ch5_homework/handout/stage_1.1.md", text, files),
                         "[a](../../slides/reading/1-back-end.en.md#conventions-written-once) b")


@unittest.skipIf(WHY_NOT, WHY_NOT)
class Bytes(FolderTest):
    def test_another_clone_gives_the_same_ones(self):
        one, other = self.folder, self.folder / "clone"
        student.pack_student(one / "a.tar.gz", one / "out")
        student.pack_student(one / "b.tar.gz", one / "out")
        self.assertEqual((one / "a.tar.gz").read_bytes(), (one / "b.tar.gz").read_bytes())
        put(student.tracked_files(), other)
        build = other / "elsewhere"
        assembly = "solutions/gauge_prior.cc.s"  # the quickest
        for command in (["cmake", "--preset", "release", "-B", build, "-DBUILD_TESTING=OFF", "-DCH5_BENCHMARKS=OFF",
                         f"-DCMAKE_CXX_COMPILER={os.environ.get('CH5_CXX', 'c++')}"], ["ninja", "-C", build, assembly]):
            subprocess.run(command, cwd=other, check=True, capture_output=True, env={**os.environ, "CCACHE_DISABLE": "1"})
        self.assertEqual((build / assembly).read_bytes(), (BUILD / assembly).read_bytes())


@unittest.skipIf(WHY_NOT, WHY_NOT)
@unittest.skipUnless("CH5_LONG" in os.environ, "takes a quarter of an hour: set CH5_LONG")
class Unpacked(FolderTest):
    """What a student does, with nothing but the archive."""

    def course(self, *words) -> subprocess.CompletedProcess:
        own = {key: value for key, value in os.environ.items() if not key.startswith("CH5_")}
        return run(self.place / "course", *words, cwd=self.place, env=own)

    def states(self, *words) -> set:
        done = self.course("check", *words, "--json")
        return {stage["state"] for stage in json.loads(done.stdout)["stages"]}

    def test_its_commands_work(self):
        student.pack_student(self.folder / "a.tar.gz", self.folder / "out")
        subprocess.run(["tar", "xzf", self.folder / "a.tar.gz", "-C", self.folder], check=True)
        self.place = self.folder / student.TOP
        self.assertEqual(self.states(), {"not-started"})
        for name in FILES:
            shutil.copy(ROOT / "solutions" / name, self.place / "ch5_homework")
        self.assertEqual(self.states(), {"right"})
        for words in (["run"], ["hint", "1.1", "1"], ["status"], ["test"]):
            done = self.course(*words)
            self.assertEqual(done.returncode, 0, done.stdout[-3000:] + done.stderr[-3000:])
        self.assertIn("students' archive, without 'grade'", self.course("grade", "ch5_homework").stderr)
