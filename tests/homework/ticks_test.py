"""A mark for each TODO, from the checks that run its lines; and what is checked again when a file is saved."""

import io
import json
import os
import unittest
from unittest import mock

from ch5_backend.course.grading.rubric import read_rubric
from ch5_backend.course.homework import check
from ch5_backend.course.homework.diagnosis import Verdict, because
from ch5_backend.course.homework.make_skeleton import skeleton
from ch5_backend.course.homework.regions import FILES, STAGES, fill, regions, solution_text, todos_of
from ch5_backend.course.homework.ticks import exercised, ticks
from tests.folder import FolderTest

STAGE = {stage["id"]: stage for stage in STAGES}


def failing(name: str, todo: str = "", blank: str = "", **told) -> dict:
    words = f'C++ exception with description "TODO {blank} somewhere is not started" thrown' if blank else "what is wrong"
    return {"name": name, "failures": [{"failure": words}], **({"diagnosis": json.dumps({"todo": todo, **told})} if todo else {})}


def passing(*names) -> list:
    return [{"name": name} for name in names]


class Ticks(unittest.TestCase):
    EMPTY, FULL = skeleton("vins_window.cc").encode(), b""

    def marks(self, tests: list, content: bytes = FULL, stage: str = "6") -> str:
        return "".join(ticks(STAGE[stage], tests, content).values())

    def test_the_table_knows_every_check_and_every_todo(self):
        self.assertEqual({(stage, check) for stage, checks in read_rubric().items() for check in checks} - set(exercised()), set())
        for stage in STAGES:
            self.assertEqual(set().union(*(todos for (of, _), todos in exercised().items() if of == stage["id"])), {*todos_of(stage)})

    def test_what_is_right_has_a_tick_while_another_blank_is_empty(self):
        without_6c = [line for line in self.EMPTY.split(b"\n") if b"HomeworkMissing" not in line or b'"6c ' in line]
        tests = [*passing("RemembersTheFreeBlocks", "EvaluatesEachResidual"), failing("AOfOneResidual", blank="6c"), *passing("FactorsARegularSystem")]
        self.assertEqual(self.marks(tests, b"\n".join(without_6c)), "✓✓·?✓?????")

    def test_an_empty_file_has_no_tick(self):
        self.assertEqual(self.marks([failing("RemembersTheFreeBlocks", blank="6a")], self.EMPTY), "·" * 10)

    def test_a_check_that_names_a_todo_blames_it(self):
        tests = [*passing("RemembersTheFreeBlocks"), failing("AOfOneResidual", "6c"), failing("EqualsADenseSchurComplement", "6d")]
        self.assertEqual(self.marks(tests)[:4], "✓✓✗?", "what runs wrong lines says nothing of the others")

    def test_the_verdict_knows_more_than_its_check(self):
        tests = [*passing("RemembersTheFreeBlocks"), failing("AOfOneResidual", "6c")]
        self.assertEqual("".join(ticks(STAGE["6"], tests, b"", "6a").values())[:3], "✗✓?")

    def test_the_only_lines_that_are_not_known_to_be_right_are_wrong(self):
        self.assertEqual(self.marks([*passing("RemembersTheFreeBlocks"), failing("AOfOneResidual")])[:3], "✓✓✗")

    def test_what_fails_without_a_name_leaves_its_lines_in_doubt(self):
        tests = [*passing("RemembersTheFreeBlocks", "AOfOneResidual"), failing("AOfManyResiduals")]
        self.assertEqual(self.marks(tests)[:3], "???")

    def test_what_is_only_seen_or_may_be_in_two_places_blames_none(self):
        for told in ({"cause": {"id": "matrix.sign"}}, {"cause": {"id": "formula.sign_added"}, "elsewhere": True}):
            self.assertEqual(self.marks([failing("TheSlidesExample", "2d", **told)], stage="2"), "????")
        self.assertEqual(self.marks([failing("TheSlidesExample", "2d", cause={"id": "formula.sign_added"})], stage="2"), "???✗")

    def test_the_second_depth_has_marks_of_its_own(self):
        deep = skeleton("vins_window.cc", depth=2).encode()
        self.assertEqual((len(self.marks([], self.FULL)), len(self.marks([], deep))), (10, 11))


class Alone(FolderTest):
    """What waits for an empty blank is judged with the solution's lines in it. Here a text is right if it has no WRONG and no throw."""

    def marks(self, written: dict, stage: str = "1.1", todo: str = "", outside: bool = False) -> tuple:
        """The marks of a file in which these blanks hold code, and how many texts were compiled for them."""
        compiled, file = [], STAGE[stage]["file"]

        def compile_it(targets):
            self.assertEqual(targets, ["filled_check_" + file.removesuffix(".cc")])
            compiled.append((self.folder / "filled" / file).read_text(encoding="utf-8"))
            return mock.Mock(returncode=0)

        def tests(*_, **__):
            wrong = outside or "WRONG" in compiled[-1] or any(f'HomeworkMissing("{blank} ' in compiled[-1] for blank in STAGE[stage]["todos"])
            checks = [check for of, check in exercised() if of == stage]
            return tuple(failing(name, todo) for name in checks) if wrong else tuple(passing(*checks))

        def judge(*_, **__):
            return Verdict("wrong", {"todo": todo} if todo else {}, tests=tests()) if tests()[0].get("failures") else Verdict("right", tests=tests())
        content = fill(solution_text(file), lambda region: written.get(region.todo) or (
            region.solution if region.kind == "DEEP" else region.blank())).encode()
        empty = [blank for blank in STAGE[stage]["todos"] if blank not in written]
        before = ticks(STAGE[stage], [failing(check, blank=empty[0]) for of, check in exercised() if of == stage] if empty else tests_of_wrong(stage), content)
        with mock.patch.multiple(check, BUILD=self.folder, build=compile_it, judge=judge, every_test=tests, program=str):
            return "".join({**before, **check.marks_alone(STAGE[stage], content, before, [], todo)}.values()), len(compiled)

    def solved(self, *todos) -> dict:
        return {region.todo: region.solution for name in FILES for region in regions(solution_text(name)) if region.todo in todos}

    def test_beside_an_empty_blank(self):
        self.assertEqual(self.marks(self.solved("1.1a")), ("✓·", 1))
        self.assertEqual(self.marks(self.solved("1.1b")), ("·✓", 1))
        self.assertEqual(self.marks(self.solved("2a", "2c"), "2"), ("✓·✓·", 1))

    def test_what_is_wrong_is_blamed_by_name_or_one_by_one(self):
        wrong = {"2c": "  Arm = H_marg;  // WRONG\n"}
        self.assertEqual(self.marks({**self.solved("2a"), **wrong}, "2", "2c"), ("✓·✗·", 2))
        self.assertEqual(self.marks({**self.solved("2a"), **wrong}, "2"), ("✓·✗·", 3))

    def test_of_a_full_file_too(self):
        wrong = {"2c": "  Arm = H_marg;  // WRONG\n"}
        self.assertEqual(self.marks({**self.solved("2a", "2b", "2d"), **wrong}, "2"), ("✓✓✗✓", 4))
        self.assertEqual(self.marks({**self.solved("2a", "2b", "2d"), **wrong}, "2", "2c"), ("✓✓✗✓", 1), "one is enough where it is the one")
        self.assertEqual(self.marks({**self.solved("2a", "2b", "2d"), **wrong}, "2", "2d"), ("✓✓✗✓", 5), "not what was blamed")

    def test_lines_outside_of_the_blanks_are_no_blank_s_fault(self):
        self.assertEqual(self.marks(self.solved("2a", "2b", "2c", "2d"), "2", outside=True), ("????", 5))

    def test_not_without_the_solutions(self):
        with mock.patch.object(check, "ROOT", self.folder):
            self.assertEqual(self.marks(self.solved("1.1a")), ("?·", 0))


def tests_of_wrong(stage: str) -> list:
    return [failing(check) for of, check in exercised() if of == stage]


class Watch(FolderTest):
    def watch(self, on_terminal: bool) -> tuple:
        """The exit code, the stages judged each time, and what was printed; the third look finds gauge_prior.cc saved, and right."""
        judged, looks, out = [], [], io.StringIO()
        out.isatty = lambda: on_terminal
        for name in ("problem.cc", "gauge_prior.cc"):
            (self.folder / name).write_text(skeleton(name), encoding="utf-8")

        def judge(stages, options):
            judged.append([stage["id"] for stage in stages])
            right = Verdict("right"), Verdict("wrong", because("compiler.silent"))
            return [right[stage["id"] == "3" and len(judged) == 1] for stage in stages]

        def sleep(_):
            looks.append(1)
            if len(looks) == 3:
                os.utime(self.folder / "gauge_prior.cc", ns=(1, 1))
            self.assertLess(len(looks), 5)
        with mock.patch.dict(os.environ, CH5_CHECK_FOLDER=str(self.folder)), mock.patch.object(check, "judge_stages", judge), \
                mock.patch.object(check.time, "sleep", sleep), mock.patch("sys.stdout", out):
            return check.watch(["1.1", "3"], None, "en"), judged, out.getvalue()

    def test_a_save_is_checked_again_until_all_is_right(self):
        code, judged, printed = self.watch(on_terminal=True)
        self.assertEqual((code, judged), (0, [["1.1", "3"], ["3"]]))
        self.assertEqual(printed.count("Waiting for the next save"), 1)

    def test_in_a_pipe_it_is_checked_once(self):
        code, judged, printed = self.watch(on_terminal=False)
        self.assertEqual((code, judged), (1, [["1.1", "3"]]))
        self.assertNotIn("Waiting", printed)
