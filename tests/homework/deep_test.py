"""The second depth: more blanks, no lines to fill in, and never over a student's work."""

import re
import sys

from tests.folder import FolderTest
from ch5_backend.course.homework.blanks import asks_deep, depth_of
from ch5_backend.course.homework.make_skeleton import skeleton
from ch5_backend.course.homework.regions import FILES, ROOT, regions, solution_text
from tests.project import run


class Deep(FolderTest):
    def course_deep(self, *words, command="deep"):
        return run(ROOT / "course", command, *words, env={"PATH": "/usr/bin:/bin", "CH5_HOMEWORK_DIR": str(self.folder)})

    def texts(self):
        return {name: (self.folder / name).read_text(encoding="utf-8") for name in FILES}

    def test_deep_blanks_are_blank_and_no_line_is_given(self):
        for name in FILES:
            first, deep = skeleton(name), skeleton(name, depth=2)
            for region in regions(solution_text(name)):
                throw = f'throw HomeworkMissing("{region.todo} '
                self.assertIn(throw, deep)
                self.assertEqual(throw in first, region.kind == "SOLUTION", region.todo)
                if region.solution or region.kind == "DEEP":  # of the others the students' archive has none
                    self.assertEqual(region.solution in first, region.kind == "DEEP", region.todo)
                    self.assertNotIn(region.solution, deep)
                if region.kind == "SOLUTION":
                    self.assertNotIn(region.hints, deep)
                self.assertIn(f"TODO:: home work {region.todo}.", deep)
            self.assertFalse(asks_deep(first.encode()))
            without_comments = re.sub(r"^ +//.*\n", "", deep, flags=re.MULTILINE)  # as one deletes a task that is done
            self.assertTrue(asks_deep(without_comments.encode()))

    def test_at_the_third_depth_only_the_names_of_tasks_are_left(self):
        for name in FILES:
            bare = skeleton(name, depth=3)
            self.assertEqual((depth_of(skeleton(name).encode()), depth_of(skeleton(name, depth=2).encode()), depth_of(bare.encode())), (1, 2, 3))
            for body in re.findall(r"^(?!namespace)\S[^\n]*\{\n((?: [^\n]*\n|\n)*)\}\n", bare, re.MULTILINE):
                code = [line for line in body.splitlines() if line.strip() and not line.strip().startswith("//")]
                throws = [line for line in code if "HomeworkMissing" in line]
                self.assertIn(throws, ([], code), body)
            for region in regions(solution_text(name)):
                self.assertEqual(bare.count(f'throw HomeworkMissing("{region.todo} '), 1)
                self.assertEqual(bare.count(f"TODO:: home work {region.todo}. {region.place}."), 1)
            self.assertIsNone(re.search(r"^// .*Stage [^:\n]*:.*=", bare, re.MULTILINE), name)

    def test_there_and_back(self):
        for words, depth in (([], 2), (["--bare"], 3), ([], 2)):
            self.assertEqual(self.course_deep(*words).returncode, 0)
            self.assertEqual(self.texts(), {name: skeleton(name, depth=depth) for name in FILES})
        self.assertEqual(self.course_deep("--bare", "--off").returncode, 2)
        self.assertEqual(self.course_deep("--off").returncode, 0)
        self.assertEqual(self.texts(), {name: skeleton(name) for name in FILES})

    def test_work_is_never_overwritten(self):
        self.course_deep("--off")
        begun = skeleton("problem.cc").replace("???", "Hmm_inv * bmm")
        (self.folder / "problem.cc").write_text(begun, encoding="utf-8")
        for words, depth in (([], "second"), (["--off"], "first")):
            done = self.course_deep(*words)
            self.assertEqual(done.returncode, 0, done)
            self.assertEqual("problem.cc contains work of yours and stays as it is" in done.stdout, not words)
            self.assertIn(f"files are at the {depth} depth", done.stdout)
            wanted = {name: skeleton(name, depth=1 if words else 2) for name in FILES} | {"problem.cc": begun}
            self.assertEqual(self.texts(), wanted)

    def test_a_file_begins_anew_and_what_stood_in_it_is_kept(self):
        self.course_deep("--off")
        wanted = self.texts()
        begun = skeleton("problem.cc").replace("???", "Hmm_inv * bmm")
        (self.folder / "problem.cc").write_text(begun, encoding="utf-8")
        for said in ("saved as problem.cc.before.\n", "at the first depth.\n"):  # a second time there is nothing to keep
            done = self.course_deep("ch5_homework/problem.cc", command="reset")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn(said, done.stdout)
            self.assertEqual((self.texts(), (self.folder / "problem.cc.before").read_text(encoding="utf-8")), (wanted, begun))
        for words in ((), ("problem.cc", "problen.cc")):
            done = self.course_deep(*words, command="reset")
            self.assertEqual(done.returncode, 2, done)
            self.assertIn("reset needs a file of the homework: block_solver.cc, ", done.stderr)

    def test_what_was_kept_is_never_overwritten(self):
        self.course_deep("--off")
        versions = [skeleton("problem.cc") + f"// version {n}\n" for n in (1, 2, 3)]
        for version in versions:
            (self.folder / "problem.cc").write_text(version, encoding="utf-8")
            self.assertEqual(self.course_deep("problem.cc", "problem.cc", command="reset").returncode, 0)
        kept = [(self.folder / f"problem.cc.before{n}").read_text(encoding="utf-8") for n in ("", ".2", ".3")]
        self.assertEqual(kept, versions)

    def test_a_file_begins_anew_at_its_depth(self):
        for words, depth, said in ((), 2, "at the second depth"), (("--bare",), 3, "at the third depth"):
            self.course_deep(*words)
            begun = skeleton("problem.cc", depth=depth) + "// begun\n"
            (self.folder / "problem.cc").write_text(begun, encoding="utf-8")
            (self.folder / "vins_window.cc").unlink()  # then the others tell
            done = self.course_deep("problem.cc", "vins_window.cc", command="reset")
            self.assertEqual(self.texts(), {name: skeleton(name, depth=depth) for name in FILES})
            self.assertEqual(done.stdout.count(said), 2, done.stdout)

    def test_a_deep_file_is_a_student_at_work(self):
        self.course_deep()
        done = run(sys.executable, "-m", "ch5_backend.course.homework.make_skeleton", "--check", "--output", self.folder,
                   env={"PATH": "/usr/bin:/bin", "PYTHONPATH": str(ROOT)})
        self.assertEqual(done.returncode, 77, done)
