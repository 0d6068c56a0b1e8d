"""Follow-through: one wrong blank costs its share of a stage and no more, and an empty one earns nothing."""

import re
import shlex
import time
import unittest
from pathlib import Path

from tests.project import BUILD
from tests.homework.samples import all_samples, blank_samples
from ch5_backend.course.grading import job
from ch5_backend.course.grading.follow_through import follow_through
from ch5_backend.course.grading.rubric import mark, read_rubric, share
from ch5_backend.course.grading.sandbox import Unguarded
from ch5_backend.course.grading.toolchain import Built, Clock
from ch5_backend.course.homework import judge as course_judge
from ch5_backend.course.homework.blanks import explain
from ch5_backend.course.homework.diagnosis import Verdict
from ch5_backend.course.homework.blanks import DEEP
from ch5_backend.course.homework.make_skeleton import skeleton
from ch5_backend.course.homework.mended import blanks_of, mended
from ch5_backend.course.homework.regions import FILES, STAGES, regions, solution_text, stage_of
from ch5_backend.course.homework.samples import Sample, source

BIN = BUILD / "bin"
SAMPLES = {one.name: one for one in all_samples()}
BLANKS = {one.name: one for one in blank_samples()}
STAGE = {stage["id"]: stage for stage in STAGES}


def in_regions(one) -> list:
    """The TODOs of the usual depth that a sample fills; none if it does more."""
    found = [todo for kind, todo in map(str.split, one.code) if kind == "REGION" and todo in stage_of(todo)["todos"]]
    return found if len(found) == len(one.code) else []


NUMBERS = re.compile(r"^#line \d+\n", re.MULTILINE)


def repaired(file: str, text: str, todos) -> str:
    """mended(), without the lines that keep the numbers of the others."""
    return NUMBERS.sub("", mended(file, text, todos))


class Texts(unittest.TestCase):
    def test_every_blank_of_both_depths_is_found_and_mended(self):
        for file in FILES:
            for deep in (False, True):
                todos = {region.todo for region in regions(solution_text(file)) if deep or region.kind == "SOLUTION"}
                text = skeleton(file, depth=1 + deep)
                self.assertEqual(set(blanks_of(file, text)), todos)
                self.assertEqual(repaired(file, text, todos), (DEEP if deep else "") + source(file))

    def test_blanks_are_found_whose_comments_are_deleted(self):
        for file in FILES:
            todos = {region.todo for region in regions(solution_text(file)) if region.kind == "SOLUTION"}
            text = re.sub(r" *// TODO:: .*\n( *//.*\n)*", "", source(file))
            self.assertEqual(set(blanks_of(file, text)), todos)

    def test_what_students_write_is_found_and_the_rest_stays(self):
        held, lost = 0, []
        for one in SAMPLES.values():
            todos = in_regions(one)
            if not todos:
                continue
            file = stage_of(todos[0])["file"]
            text = source(file, one.code)
            one_less = {key: code for key, code in one.code.items() if key != f"REGION {todos[0]}"}
            good = repaired(file, text, todos) == source(file) and repaired(file, text, todos[:1]) == source(file, one_less)
            held, lost = held + good, lost + [one.name] * (not good)
        self.assertGreater(held, 500)
        self.assertLess(len(lost), 3, lost)


class Judged:
    """Answers for texts that samples hold, with the judge and the prebuilt workers; all others are wrong."""

    def __init__(self, stage: dict, one):
        self.stage, self.file, self.asked = stage, stage["file"], 0
        self.names = {source(self.file, one.code): one.name, source(self.file): "linked"}

    def __call__(self, content: bytes) -> Verdict:
        self.asked += 1
        name = self.names.get(NUMBERS.sub("", content.decode()))
        if name is None:
            return Verdict("wrong")
        verdict = course_judge.judge(BIN / "homework_judge", self.stage, 60.0, ["--seed=3"],
                                     [str(BIN / "worker_samples"), f"--submission={name}"], fail_fast=False)
        return explain(verdict, self.stage, content)


@unittest.skipUnless((BIN / "worker_samples").exists(), "no worker_samples")
class Scores(unittest.TestCase):
    def found(self, one, stage: str) -> dict:
        content = source(STAGE[stage]["file"], one.code).encode()
        judge = Judged(STAGE[stage], one)
        return follow_through(STAGE[stage], content, judge(content), judge)

    def test_an_empty_blank_costs_its_share_and_the_others_count(self):
        for name, one in BLANKS.items():
            todo = next(iter(one.code)).split()[1]
            stage = stage_of(todo)
            if todo not in stage["todos"] or len(stage["todos"]) == 1:
                continue
            found = self.found(one, stage["id"])
            n = len(stage["todos"])
            self.assertEqual(found, {"replaced": [todo], "blanks": n}, name)
            self.assertEqual(share({**found, "points": 14}), 28 * (n - 1) // n / 2)

    def test_it_never_takes_points(self):
        rubric = {"1.2": {"a": 10, "b": 4}}
        row = {"id": "1.2", **self.found(SAMPLES["schur_sign"], "1.2"), "checks": [{"name": "a", "passed": True}, {"name": "b", "passed": False}]}
        self.assertEqual((mark({"stages": [row]}, rubric)["score"], row["followed"]), (10, False))
        rubric["1.2"].update(a=1, b=13)  # the instructor's word makes other points of the same facts
        self.assertEqual((mark({"stages": [row]}, rubric)["score"], row["followed"]), (9, True))

    def test_a_crash_counts_for_the_blank_that_it_happens_in(self):
        crash = SAMPLES["schur_never_written"]
        self.assertEqual(self.found(crash, "1.2")["replaced"], in_regions(crash))

    def test_who_asks_for_the_second_depth_without_writing_it_earns_no_more(self):
        for one, points in ((BLANKS["blank_1_1b"], 6), (SAMPLES["schur_sign"], 9)):
            stage = one.stages[0]
            content = source(stage["file"], one.code) + "".join(f"// home work {todo}.\n" for todo in stage["deep"])

            def judge(text, one=one, stage=stage):
                return Judged(stage, one)(re.sub(rb"// home work .*\n", b"", text))
            found = follow_through(stage, content.encode(), judge(content.encode()), judge)
            self.assertLessEqual(share({**found, "points": 12 if points == 6 else 14}), points)

    def test_a_file_without_end_is_not_compared_line_by_line(self):
        content = (source("problem.cc", SAMPLES["schur_sign"].code) + "\n" * 200_000).encode()
        begin = time.monotonic()
        self.assertEqual(follow_through(STAGE["1.2"], content, Verdict("wrong"), None), {})
        self.assertLess(time.monotonic() - begin, 1.0)

    def test_nothing_filled_in_earns_nothing(self):
        for stage in STAGES:
            untouched, asked = skeleton(stage["file"]), []
            for text, state in ((untouched, "not-started"), (re.sub(r".*throw HomeworkMissing.*\n", "", untouched), "wrong")):
                verdict = Verdict(state, {"todo": stage["todos"][0]})
                self.assertEqual(follow_through(stage, text.encode(), verdict, asked.append), {})
            self.assertEqual(asked, [], "nothing is judged for it")

    def test_what_is_no_text_of_the_homework_earns_nothing(self):
        for content in (b"", b"\xff\x00", b"int main() {}\n" * 1000):
            self.assertEqual(follow_through(STAGE["1.2"], content, Verdict("crashes"), None), {})


class Prebuilt:
    """A toolchain that compiles nothing: it knows the workers of some texts."""
    box, judge, solved = Unguarded, BIN / "homework_judge", lambda *_: {}

    def __init__(self, file: str, samples):
        self.names = {source(file, one.code): one.name for one in samples}
        self.names[source(file)] = "linked"
        self.compiled = []

    def compile(self, file: str, content: bytes, folder: Path, clock) -> Built:
        name = self.names.get(NUMBERS.sub("", content.decode()))
        self.compiled.append(name)
        if name is None:
            return Built(None, Verdict("does-not-compile"), 1.0, 100.0)
        worker = folder / "worker"
        worker.write_text(f"#!/bin/sh\nexec {shlex.quote(str(BIN / 'worker_samples'))} --submission={name}\n")
        worker.chmod(0o755)
        return Built(worker, None, 1.0, 100.0)


@unittest.skipUnless((BIN / "worker_samples").exists(), "no worker_samples")
class Grades(unittest.TestCase):
    def graded(self, one) -> tuple:
        file = "problem.cc"
        toolchain = Prebuilt(file, [one])
        found = job.grade_file(toolchain, file, source(file, one.code).encode(),
                               [stage for stage in STAGES if stage["file"] == file], read_rubric(), 3, Clock())
        return {row["id"]: row for row in mark(found, read_rubric())["stages"]}, toolchain.compiled

    def test_a_wrong_sign_leaves_eight_of_twelve_points(self):
        rows, compiled = self.graded(SAMPLES["schur_sign"])
        self.assertEqual({stage: (row["state"], row["score"]) for stage, row in rows.items()},
                         {"1.1": ("right", 10), "1.2": ("wrong", 8), "2": ("right", 11)})
        self.assertEqual((rows["1.2"]["replaced"], compiled), (["1.2b"], ["schur_sign", "linked"]))
        self.assertLessEqual(sum(check["score"] for check in rows["1.2"]["checks"]), 2)

    def test_a_blank_left_empty_is_half_done(self):
        rows, _ = self.graded(BLANKS["blank_1_2b"])
        self.assertEqual((rows["1.2"]["state"], rows["1.2"]["diagnosis"]["begun"], rows["1.2"]["score"]), ("not-started", True, 8))

    def test_what_is_right_is_compiled_once(self):
        self.assertEqual(self.graded(Sample("linked"))[1], ["linked"])
