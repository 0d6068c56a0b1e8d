"""Hostile submissions through ./course grade: none scores, leaves a process or a file, learns a secret, writes into a page
of the class, or harms an honest submission that is graded beside it. hostile.py tells what they are.
"""

import json
import os
import re
import sys
import tempfile
import time
import unittest
from pathlib import Path

from tests.project import BUILD, ROOT, run
from tests.grading.hostile import FOLDER, DECLARATIONS, HEAD, TAIL, read_attacks
from tests.grading.sandbox_test import NO_OWN_USER
from ch5_backend.course.grading.rubric import read_rubric
from ch5_backend.course.base.language import speaker
from ch5_backend.course.homework.diagnosis import in_short
from ch5_backend.course.homework.regions import FILES, STAGES, fill, solution_text

MARK = f"atk{os.getpid()}"  # the name of processes and files that should not be there, and of what must not be found out
LIMITS = """
import sys
from ch5_backend.course import __main__ as entry
from ch5_backend.course.grading import job, toolchain
job.SECONDS_A_TEST = 6.0  # so that attacks on time take less of ours; of the clock, since the machine may be busy
job.RUNNING = job.RUNNING._replace(seconds=3, wall_seconds=9.0)
if sys.argv.pop() == "one-compiler":  # the second needs five times as long for what the first refuses
    made = toolchain.Toolchain.__init__
    def with_one(self, box):
        made(self, box)
        del self.compilers[1:]
    toolchain.Toolchain.__init__ = with_one
    toolchain.COMPILING = toolchain.COMPILING._replace(seconds=6)  # what is right takes three
sys.exit(entry.main(sys.argv[1:]))
"""

REACHING_OUT = ("kill_the_parent", "kill_everybody", "daemon", "fork_bomb_at_a_large_weight", "disk", "disk_elsewhere", "secrets_read", "seed_sought",
                "judges_memory", "remembered_from_another_test", "memory_that_nobody_counts", "modes_owners_and_times_changed", "locks_and_leases")


def awkward_bytes() -> dict:
    """Files that are no proper text."""
    plain = (HEAD + TAIL).replace("@MARK@", MARK)
    solution = (ROOT / "solutions" / "gauge_prior.cc").read_text(encoding="utf-8")
    return {"nul_bytes": b"\0" * 1000 + plain.encode().replace(b"\n", b"\0\n"), "utf_16": solution.encode("utf-16"),
            "utf_32": solution.encode("utf-32"), "no_text": bytes(range(256)) * 500, "empty": b"",
            "one_long_line": b"int x = 0" + b" + 1" * 60_000 + b";", "an_archive": b"PK\x03\x04" + b"x" * 1000,
            "deep_brackets": b"int x = " + b"(" * 100_000 + b"1" + b")" * 100_000 + b";"}


@unittest.skipUnless((BUILD / "grader" / "toolchain.json").exists(), "no Clang: without ./course grade")
class Attacks(unittest.TestCase):
    """Every twelfth attack of each kind; all_attacks_test.py takes the rest, by night, and all of them with the other engine."""
    STEP = 12  # from the first on
    SANDBOX = "bubblewrap"

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        cls.folder.chmod(0o755)
        cls.secret = cls.folder / "secret.h"
        cls.secret.write_text(f"int secret_{MARK}_of_the_host;\n")

    def grade(self, texts: dict, compilers: str, file: str, stages: list) -> dict:
        """The records of these submissions of a file, {name: bytes}, with one or two honest ones in between."""
        subs, temporary, out = (self.folder / f"{self.id()}.{name}" for name in ("submitted", "tmp", "out"))
        subs, temporary, out = (path.with_name(path.name + file) for path in (subs, temporary, out))
        temporary.mkdir(mode=0o755)
        solution = (ROOT / "solutions" / file).read_bytes()
        step = len(texts) // 2 + 1
        for k, (name, text) in enumerate(texts.items()):
            (subs / f"{k:02}{name}").mkdir(parents=True)
            (subs / f"{k:02}{name}" / file).write_bytes(text)
            if k % step == step - 1 or k == len(texts) - 1:
                (subs / f"{k:02}{name}_then_honest").mkdir()
                (subs / f"{k:02}{name}_then_honest" / file).write_bytes(solution + b"// %d" % k)
        done = run(sys.executable, "-X", "utf8", "-c", LIMITS, "grade", *sorted(subs.iterdir()), "--stages", ",".join(stages), "--jobs", "2",
                   "--sandbox", self.SANDBOX, "--out", out, compilers, timeout=1500,
                   env={**os.environ, "CH5_BUILD_DIR": str(BUILD), "TMPDIR": str(temporary), "PYTHONPATH": str(ROOT)})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(list(temporary.iterdir()), [], "files of the grader are left")
        self.out = out
        self.records = {path.parent.name: json.loads(path.read_text(encoding="utf-8")) for path in out.glob("*/record.json")}
        return self.records

    def none_scores(self, texts: dict, compilers: str = "one-compiler", file: str = "gauge_prior.cc", step: int = 0) -> None:
        texts = {name: texts[name] for name in list(texts)[::step or self.STEP]}
        stages = [stage["id"] for stage in STAGES if stage["file"] == file]
        points = sum(sum(read_rubric()[stage].values()) for stage in stages)
        found = self.grade(texts, compilers, file, stages)
        self.assertGreater(len(found), len(texts))  # one or two honest ones
        for name, record in sorted(found.items()):
            with self.subTest(attack=name):
                row = record["stages"][0] if record["stages"] else {"state": record.get("error")}
                if os.environ.get("CH5_VERBOSE"):
                    print(f"{name:45} {record['score']:g} {record['cpu_seconds']:5} {record['seconds']:5} {row['state']:18} {in_short(row.get('diagnosis', {}), speaker('en'))[:90]}")
                self.assertEqual(record["status"], "graded")
                self.assertEqual(record["score"], points if name.endswith("honest") else 0, row)
                self.assertEqual(record["points"], points)
                if name.endswith("honest"):  # it is the solution
                    names, of_all = record["solved"][file]
                    self.assertEqual(len(names), of_all)
        self.nothing_is_left()
        self.nothing_has_leaked(texts)

    def nothing_is_left(self) -> None:
        places = [ROOT, ROOT / "solutions", Path("/tmp"), Path("/var/tmp"), Path("/dev/shm"), Path("/root"), Path("/home"),
                  Path("/"), self.folder]
        self.assertEqual([place for place in places if any(entry.startswith(MARK) for entry in listed(place))], [])
        self.assertTrue((ROOT / "solutions" / "gauge_prior.cc").exists())
        time.sleep(0.2)
        names = [text for text in map(name_of_process, Path("/proc").glob("[0-9]*")) if text == MARK]
        self.assertEqual(names, [], "processes are left")

    def nothing_has_leaked(self, texts: dict) -> None:
        """The attacks print the mark where they have had success; a page holds no tag of theirs."""
        for path in sorted(self.out.glob("*/*")):
            text = path.read_text(encoding="utf-8")
            with self.subTest(page=path.relative_to(self.out)):
                self.assertNotIn(f"secret_{MARK}_of_the_host", text)
                self.assertNotIn("root:x:0:", text)
                self.assertNotRegex(text if path.name in ("feedback.html", "results.json", "junit.xml") else "", "[\x00-\x08\x0e-\x1f\x7f-\x9f]", "steers a terminal")
                self.assertLess(len(text), 1 << 20)
                self.assertNotIn("prior_weight * Mat66::Identity()", text)
                self.assertNotIn(f"<script>{MARK}", text if path.suffix in (".html", ".xml") else "")
                if path.name == "record.json" and "script" not in path.parent.name and "traces" not in path.parent.name:
                    printed = "".join(row["printed"] + row["output"] + json.dumps(row["diagnosis"], ensure_ascii=False) for row in json.loads(text)["stages"])
                    self.assertNotIn(MARK, printed.replace(str(self.folder), ""))
        self.assertNotIn("<script>" + MARK, (self.out / "summary.html").read_text(encoding="utf-8"))

    def texts_of(self, name: str) -> dict:
        words = {"@ROOT@": str(ROOT), "@MARK@": MARK, "@SECRET@": str(self.secret), "@TMP@": str(self.folder)}
        attacks = read_attacks(name)
        # What the compiler should not survive comes first: it then has nothing else to do.
        whole = {attack: (text + HEAD + TAIL if name == "compiling" else HEAD + text + TAIL) for attack, text in attacks.items()}
        return {attack: re.sub("@[A-Z]+@", lambda found: words[found[0]], text).encode() for attack, text in whole.items()}

    def test_none_that_acts_before_main_scores(self):
        self.none_scores(self.texts_of("start"))

    @unittest.skipIf(NO_OWN_USER, NO_OWN_USER)
    def test_none_that_reaches_out_scores_with_a_user_of_its_own(self):
        self.SANDBOX = "landlock"
        texts = self.texts_of("running")
        self.none_scores({name: texts[name] for name in REACHING_OUT}, step=1)

    def test_none_that_acts_in_a_graded_function_scores(self):
        self.none_scores(self.texts_of("running"))

    def test_none_that_calls_an_answer_scores(self):
        attacks = re.findall(r"^// ATTACK (\w+) (\S+) (\S+)\n((?:(?!// ATTACK ).*\n)+)",
                             (FOLDER / "answers.attacks").read_text(encoding="utf-8"), re.MULTILINE)
        attacked = {file for _, file, _, _ in attacks}
        self.assertEqual({*FILES} - attacked, {"open_tasks.cc"}, "which earns no points")
        for file in sorted(attacked):
            texts = {name: (DECLARATIONS + fill(solution_text(file), lambda region, todo=todo, code=code:
                                           code if region.todo == todo else region.solution)).encode()
                     for name, where, todo, code in attacks if where == file}
            self.none_scores(texts, file=file)
            for name, record in self.records.items():
                if not name.endswith("honest"):
                    self.assertEqual(record["stages"][0]["state"], "does-not-compile", name)
                    self.assertRegex(json.dumps(record), "undefined|declared", name)

    def test_none_that_attacks_the_compiler_scores(self):
        self.none_scores(self.texts_of("compiling"))

    def test_no_right_answer_that_brings_machine_code_scores(self):
        solution = solution_text("gauge_prior.cc")
        texts = {name: (code + fill(solution, lambda region: region.solution)).encode() for name, code in read_attacks("provenance").items()}
        self.none_scores(texts, "both-compilers")
        for name, record in self.records.items():
            if not name.endswith("honest"):
                self.assertIn("compiler.machine_code", json.dumps(record["stages"][0]["diagnosis"]), name)

    def test_what_the_first_compiler_refuses_does_not_score_with_the_second(self):
        texts = {**self.texts_of("start"), **self.texts_of("compiling")}
        self.none_scores({name: texts[name] for name in ("the_librarys_function_again", "compiler_crash")}, "both-compilers", step=1)

    @unittest.skipUnless("CH5_LONG" in os.environ, "CH5_LONG=1: a quarter of an hour")
    def test_none_that_attacks_the_second_compiler_scores(self):
        refused = b"#ifdef __clang__\n#error not this one\n#endif\n"
        self.none_scores({name: refused + text for name, text in self.texts_of("compiling").items()}, "both-compilers")

    def test_none_that_is_no_proper_text_scores(self):
        self.none_scores(awkward_bytes(), step=1)


def listed(folder: Path) -> list:
    try:
        return os.listdir(folder)
    except OSError:
        return []


def name_of_process(folder: Path) -> str:
    try:
        return (folder / "comm").read_text().strip()
    except OSError:
        return ""
