"""A class: whose submission is whose, which one counts, what lateness and a human's word do to it, and who is like whom."""

import csv
import io
import re
import unittest
from contextlib import redirect_stderr, redirect_stdout
from datetime import datetime
from types import SimpleNamespace
from unittest import mock

from tests.folder import FolderTest
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.base.language import sentence, speaker
from ch5_backend.course.__main__ import main
from ch5_backend.course.grading import anonymous, classbook, grade, gradebooks, outputs, pages, summary, talk
from ch5_backend.course.grading.engines import choose
from ch5_backend.course.grading.likeness import alike, as_solution, earlier, fingerprint, functions_in
from ch5_backend.course.grading.toolchain import Toolchain
from ch5_backend.course.homework.make_skeleton import untouched
from ch5_backend.course.homework.regions import STAGES, fill, solution_text
from ch5_backend.course.grading.rubric import read_rubric
from ch5_backend.course.grading.sandbox import Unguarded
from ch5_backend.course.homework.samples import source
from tests.homework.samples import all_samples
from tests.grading.one_stage import READY
from tests.grading.languages_test import CHINESE, ENGLISH, english_in, row, words_of

POINTS = {"1.1": 12, "1.2": 14}
STAGE = {stage["id"]: stage for stage in STAGES}


def record(name: str, first=12, second=0, handed_in="2026-12-01T12:00", states=("right", "not-started"), folder="submissions",
           **more) -> dict:
    stages = [{**row(STAGE[stage], state), "score": score, "points": POINTS[stage]}
              for stage, state, score in zip(POINTS, states, (first, second))]
    return {"name": name, "path": f"/{folder}/{name}", "status": "graded", "stages": stages, "score": first + second,
            "points": 26, "handed_in": datetime.fromisoformat(handed_in).astimezone().isoformat(), "seed": 7, "faults": [], "unread": [],
            "cpu_seconds": 1.0, "peak_mib": 300, "content": name, "key": "k", "fingerprint": {}, "seconds": 1.0, **more}


class Terminal(io.StringIO):
    def reconfigure(self, **_):
        """As a stream of the terminal has."""


class InAFolder(FolderTest):
    def sheet(self, *lines):
        self.path = self.folder / "class.csv"
        self.path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return self.path

    def read(self, *lines) -> classbook.Class:
        return classbook.read_class(self.sheet(*lines), POINTS)

    def settled(self, book, *records) -> dict:
        return {mark.student.id: mark for mark in classbook.settle(book, list(records), POINTS)[0]}


class Sheets(InAFolder):
    def test_bad_lines_are_named_with_their_value(self):
        for line, told in (("7,Ada,,1.2=99,too kind", "class.csv:2: override of 1.2: must be a number from 0 to 14, got '99'"),
                           ("7,Ada,,1.2=9,", "class.csv:2: an override needs its reason, got '1.2=9'"),
                           ("7,Ada,,9=1,x", "class.csv:2: override: such as 1.2=10; there are the stages 1.1, 1.2, got '9=1'"),
                           ("7,Ada,,1.2=9; 1.2＝8,x", "class.csv:2: override of 1.2 is there twice, got '1.2=9; 1.2＝8'"),
                           ('7,"Ada\n8,Bob', "class.csv:2: cannot be read as a table: unexpected end of data"),
                           ("7,Ada,soon,,", "class.csv:2: a time is written 2026-12-01T18:30, got 'soon'"),
                           ("7,Ada,,,,,,", "class.csv:2: more cells than the header has, got ''"),
                           ("7,Ada\n7,Bob", "class.csv:3: this id is also in line 2, got '7'"),
                           ("", "class.csv: nobody is in it"), (",Ada", "class.csv:2: this row has no id, got 'Ada'"),
                           ("7,Ada,2026-12-01;2026-12-02,,", "class.csv:2: 2 times in the column handed_in for 0 submissions"),
                           ("2.02101E+09,Ada", "class.csv:2: a spreadsheet has turned this id into a rounded number"),
                           ("2021012345.0,Ada", "class.csv:2: a spreadsheet has turned this id into a rounded number")):
            with self.assertRaises(CourseError) as caught:
                self.read("id,name,handed_in,override,reason", line)
            self.assertIn(told, str(caught.exception))
        with self.assertRaisesRegex(CourseError, "class.csv:1: needs the columns id and name .*, got 'who'"):
            self.read("who", "Ada")
        with self.assertRaisesRegex(CourseError, "read proof /10: must be a number from 0 to 10, got '11'"):
            self.read("id,name,read proof /10", "7,Ada,11")
        with self.assertRaisesRegex(CourseError, "class.csv:1: this column is there twice, got 'read proof /10'"):
            self.read("id,name,read proof /10,Read proof /10", "7,Ada,11,3")
        self.path.write_bytes(b"PK\3\4" + bytes(99))
        with self.assertRaisesRegex(CourseError, "class.csv: is a workbook"):
            classbook.read_class(self.path, POINTS)
        for raw in (b"\xff\xfe\x00", b"id,name\n7,\x81\xff\n"):
            self.path.write_bytes(raw)
            with self.assertRaisesRegex(CourseError, "class.csv: cannot be read as a table"):
                classbook.read_class(self.path, POINTS)
        with self.assertRaisesRegex(CourseError, "nowhere.csv: cannot be read"):
            classbook.read_class(self.folder / "nowhere.csv", POINTS)

    def test_a_sheet_is_read_as_it_comes_from_any_spreadsheet(self):
        for raw in ("学号;姓名\n7;张三丰\n".encode("gb18030"), "\ufeffid,name\r\n7,张三丰\r\n".encode(), "id\tname\n7\t张三丰\n".encode("utf-16"),
                    "sep=;\nid;name\n7;张三丰\n".encode(), "学号,姓名\n7,张三丰\n".encode("utf-16-le")):
            self.path = self.folder / "class.csv"
            self.path.write_bytes(raw)
            self.assertEqual([(one.id, one.name) for one in classbook.read_class(self.path, POINTS).students], [("7", "张三丰")], raw)
        for name, encoding in (("赵喆, 周玥, 钱镕", "gb18030"), ("Zoë Müller-Ångström", "cp1252"), ("Søren Ünal", "cp1252"), ("קורן אבי", "utf-8")):
            self.path.write_bytes(f'id,name\n7,"{name}"\n'.encode(encoding))
            self.assertEqual(classbook.read_class(self.path, POINTS).students[0].name, name)


class Settled(InAFolder):
    def test_an_id_is_found_as_a_word_in_a_name_or_its_folder(self):
        book = self.read("id,name,submissions", "12,Ada,", "123,Bob,", "eve,Eve,final.zip", "77,Dan,")
        marks, nobodys = classbook.settle(book, [record("x_123_hw.zip"), record("a-12.zip"), record("final.zip"),
                                                 record("homework.zip", folder="77"), record("other1234")], POINTS)
        self.assertEqual([mark.record["name"] for mark in marks], ["a-12.zip", "x_123_hw.zip", "final.zip", "homework.zip"])
        self.assertEqual([name for name, _ in nobodys], ["other1234"])

    def test_what_two_may_claim_is_no_mark_for_either_and_stops_nobody(self):
        book = self.read("id,name,submissions", "12,Ada,", "123,Bob,", "9,Eve,", "4,Dan,pair", "5,Fay,pair")
        marks, lost = classbook.settle(book, [record("12-123"), record("hw 9"), record("pair")], POINTS)
        self.assertEqual([(mark.student.name, mark.total) for mark in marks], [("Ada", None), ("Bob", None), ("Eve", 12), ("Dan", 12), ("Fay", 12)])
        self.assertEqual([(name, speaker("en").text(why)) for name, why in lost],
                         [("12-123", "may belong to 12 (Ada), 123 (Bob); write its name into the column submissions of the right one")])
        self.assertIn("12-123 may be theirs", gradebooks.status(marks[0], speaker("en")))

    def test_a_name_in_the_sheet_that_nobody_handed_in_is_told(self):
        book = self.read("id,name,submissions", "7,Ada,first；second", "8,Bob,third.zip")
        self.assertEqual([(one.id, name) for one, name in classbook.not_there(book, [record("First"), record("third.zip")])], [("7", "second")])

    def test_who_handed_in_nothing_has_a_row_and_no_number(self):
        mark = self.settled(self.read("id,name", "7,Ada"))["7"]
        self.assertEqual((mark.record, mark.total, mark.stages), (None, None, {"1.1": None, "1.2": None}))
        mark = self.settled(self.read("id,name,override,reason", "7,Ada,1.1=5,an oral"))["7"]
        self.assertEqual((mark.total, mark.stages), (5, {"1.1": 5, "1.2": 0}))

    def test_what_could_not_be_read_is_no_mark_until_a_human_has_one(self):
        half = record("7", 12, 0, states=("right", "unread"), status="not-read", unread=[{"id": "submission.not_opened", "file": "x.rar"}])
        mark = self.settled(self.read("id,name", "7,Ada"), half)["7"]
        self.assertEqual((mark.total, mark.stages), (None, {"1.1": 12, "1.2": None}))
        self.assertIn("x.rar is an archive", gradebooks.status(mark, speaker("en")))
        mark = self.settled(self.read("id,name,override,reason", "7,Ada,1.2=3,unpacked by hand"), half)["7"]
        self.assertEqual((mark.total, mark.doubts), (15, []))

    def test_the_last_or_the_best_counts(self):
        both = [record("7-a", 12, 10), record("7-b", 12, 4, "2026-12-03T12:00")]
        book = self.read("id,name", "7,Ada")
        self.assertEqual(self.settled(book, *both)["7"].total, 16)
        book.keep = "best"
        self.assertEqual(self.settled(book, *both)["7"].total, 22)

    def test_a_day_begun_costs_and_an_excused_one_does_not(self):
        book = self.read("id,name,excused,handed_in", "7,Ada,,", "8,Bob,1,", "9,Eve,,2026-12-01T23:59", "10,Dan,,")
        book.due = classbook.read_due("2026-12-01T23:59", POINTS)
        late = lambda name, time: record(name, 12, 8, time)
        marks = self.settled(book, late("7", "2026-12-02T00:00"), late("8", "2026-12-02T23:00"), late("9", "2026-12-09T00:00"),
                             late("10", "2027-01-31T00:00"))
        self.assertEqual([(mark.days_late, mark.lost, mark.total) for mark in marks.values()],
                         [(1, 2, 18), (0, 0, 20), (0, 0, 20), (61, 20, 0)])

    def test_a_minute_ends_with_its_last_second_and_stages_have_dates_of_their_own(self):
        due = classbook.read_due("2026-12-01T23:59; 1.2=2026-12-08", POINTS)
        for time, days in (("2026-12-01T23:59:59", 0), ("2026-12-02T00:00:00", 1), ("2026-12-02T23:59:59", 1), ("2026-12-03T00:00:00", 2)):
            book = self.read("id,name", "7,Ada")
            book.due = due
            mark = self.settled(book, record("7", 12, 8, time))["7"]
            self.assertEqual((mark.days, mark.lost), ({"1.1": days, "1.2": 0}, 1.2 * days), time)
        self.assertEqual(due["1.2"], datetime.fromisoformat("2026-12-09T00:00").astimezone())
        self.assertEqual(classbook.read_due("1.2=2026-12-08T23:59:59", POINTS), {"1.2": due["1.2"]})
        for text in ("noon", "9=2026-12-01", "9999-12-31", "2026-12-01; 2026-12-02", "1.1=2026-12-01; 1.1=2026-12-02"):
            with self.assertRaisesRegex(CourseError, f"got '{text}'"):
                classbook.read_due(text, POINTS)

    def test_each_stage_counts_from_the_last_submission_that_has_its_file(self):
        book = self.read("id,name", "7,Ada")
        book.due = classbook.read_due("1.1=2026-12-01; 1.2=2026-12-08", POINTS)
        first, second = record("7-a", 12, 0, states=("right", "missing")), record("7-b", 0, 14, "2026-12-08T12:00", states=("missing", "right"))
        mark = self.settled(book, first, second)["7"]
        self.assertEqual((mark.total, mark.lost, {stage: one["name"] for stage, one in mark.records.items()}), (26, 0, {"1.1": "7-a", "1.2": "7-b"}))

    def test_a_humans_word_knows_the_hour(self):
        book = self.read("id,name,override,reason", "7,Ada,1.2=10,ill")
        book.due = classbook.read_due("2026-11-30", POINTS)
        mark = self.settled(book, record("7", 12, 0))["7"]
        self.assertEqual((mark.lost, mark.total), (1.2, 20.8))

    def test_a_human_has_the_last_word_and_reads_what_no_machine_reads(self):
        book = self.read("id,name,override,reason,read proof /10,read style /10", '7,Ada,"1.2=10",explained the sign,8.5,', "8,Bob,,,,")
        marks = self.settled(book, record("7", 12, 9))
        self.assertEqual((marks["7"].total, marks["7"].stages), (30.5, {"1.1": 12, "1.2": 10}))
        head, ada, _ = gradebooks.tables(book, list(marks.values()), POINTS, speaker("en"))["students.csv"][0]
        told = dict(zip(head, ada))
        self.assertEqual((told["total"], told["of"], told["override"], told["reason"], told["read style"]),
                         ("30.5", "46", "1.2=10", "explained the sign", ""))

    def test_a_fault_of_ours_is_no_mark(self):
        mark = self.settled(self.read("id,name", "7,Ada"), record("7", 0, 0, status="infrastructure-error"))["7"]
        self.assertIsNone(mark.total)

    def test_no_cell_is_a_formula(self):
        outputs.write_table(self.folder / "t.csv", [["=1+1", "@x", "张三", 3, "-", "-2.5", "-2+3"]])
        with open(self.folder / "t.csv", encoding="utf-8", newline="") as file:
            self.assertEqual(next(csv.reader(file)), ["'=1+1", "'@x", "张三", "3", "-", "-2.5", "'-2+3"])


class Page(InAFolder):
    def test_it_counts_apart_who_did_nothing(self):
        book = self.read("id,name,read proof /10,override,reason", "7,阿达,8,1.1=5,口头解释过", "8,Bob,,,", "9,Eve,,,", "10,Dan,1,,")
        book.due = classbook.read_due("2026-12-01T23:59", POINTS)
        records = [record("7", 12, 14, states=("right", "right")), record("8", 0, 0, states=("not-started", "missing")),
                   record("10", 6, 0, states=("wrong", "not-started")), record("strange")]
        marks, lost = classbook.settle(book, records, POINTS)
        for language in ("en", "zh"):
            say = speaker(language)
            summary.write(self.folder, records, POINTS, book, marks, grade.look_at(records, book, marks, lost, POINTS, say), say)
            text, words = (self.folder / "summary.html").read_text(encoding="utf-8"), words_of(self.folder / "summary.html")
            if language == "zh":
                self.assertEqual(english_in(words), "")
                self.assertNotRegex(words, r"[\u4e00-\u9fff][,:] |[,:] [\u4e00-\u9fff]", "a mark of half width")
            for part in ("阿达", "口头解释过", "strange", "Eve") + (("两个位姿之间的一条边",) if language == "zh" else
                         ("3 of 4 students have handed in", "one edge between two poses", "nothing started")):
                self.assertIn(part, words)
            self.assertEqual(text.count('class="bar"'), 12)
            self.assertIn("sortable", text)

    def test_numbers_hide_names_and_stay(self):
        book = self.read("id,name,read proof /10", "20210007,阿达,8", "20210008,Bob,", "20210009,Evariste,")
        records = [record("20210007_阿达", 12, 14, faults=[sentence("submission.file_twice", file="阿达.cc")]), record("20210008_Bob"), record("stranger")]
        marks, _ = classbook.settle(book, records, POINTS)
        folder, kept = self.folder / "numbers", []
        for say in (ENGLISH, CHINESE):
            anonymous.write(folder, self.folder, records, POINTS, book, marks, say)
            seen = "".join(path.read_text(encoding="utf-8") for path in folder.rglob("*.html"))
            for one in ("阿达", "Bob", "Evariste", "stranger", "20210007"):
                self.assertFalse(one in seen, one)
            with open(self.folder / "numbers.csv", encoding="utf-8", newline="") as file:
                kept.append({row["name"]: row["number"] for row in csv.DictReader(file)})
            self.assertEqual({path.name for path in folder.iterdir() if path.is_dir() and path.name != ".cache"}, set(kept[-1].values()))
        self.assertEqual(kept[0], kept[1])
        self.assertIn("34", words_of(folder / "summary.html"), "26 points and 8 that a human has read")


class Talk(unittest.TestCase):
    LINES = talk.lines_of({"problem.cc": fill(solution_text("problem.cc"), lambda region: region.solution).encode()})

    def asked(self, name: str, *rows) -> list:
        return talk.questions({"name": name, "seed": 7, "stages": rows}, self.LINES, ENGLISH)

    def test_it_asks_about_the_students_own_lines(self):
        right = [row(STAGE[stage], "right") for stage in POINTS]
        asked = self.asked("Ada", *right)
        self.assertEqual((len(asked), asked), (talk.QUESTIONS, self.asked("Ada", *right)))
        self.assertNotEqual([one[0] for one in asked], [one[0] for one in self.asked("Bob", *right)])
        for question, lines, answer in asked:
            todo = next(todo for todo in self.LINES if f"of {todo}." in question)
            self.assertEqual(lines, self.LINES[todo])
            self.assertNotEqual(answer.split(), lines.split())
        wrong = row(STAGE["1.1"], "wrong", {"todo": "1.1b", "cause": {"id": "assembly.mirror_missing"}})
        asked = self.asked("Ada", wrong, right[1])
        self.assertEqual(asked[0][1:], (self.LINES["1.1b"], ENGLISH("assembly.mirror_missing")))
        self.assertTrue(all("of 1.2" in question for question, _, _ in asked[1:]))
        self.assertEqual(talk.lines_of({"problem.cc": untouched("problem.cc")[0].encode()}), {})


class States(unittest.TestCase):
    def test_a_half_done_stage_is_not_an_untouched_one(self):
        begun = row(STAGE["1.2"], "not-started", {"begun": True})
        self.assertEqual((pages.untouched(begun), pages.state_of(begun, speaker("en"))), (False, "half-done"))
        for state in ("not-started", "missing"):
            self.assertTrue(pages.untouched(row(STAGE["1.2"], state)))
        self.assertFalse(pages.untouched(row(STAGE["1.2"], "wrong")))


class Command(InAFolder):
    def test_a_class_gets_its_tables_and_a_changed_sheet_grades_nothing_again(self):
        sheet, out = self.folder / "class.csv", self.folder / "out"
        sheet.write_text("id,name,override,reason\n7,Ada,,\n8,Bob,,\n", encoding="utf-8")
        for name in ("hw_7", "nobody"):
            (self.folder / name).mkdir()
            (self.folder / name / "gauge_prior.cc").write_text(f"// {name}\n")
        words = ["grade", str(self.folder / "hw_7"), str(self.folder / "nobody"), "--out", str(out), "--class", str(sheet), "--stages", "1.1,1.2"]
        graded = record("x")
        for one, state in zip(graded["stages"], (True, False)):
            one["checks"] = [{"name": check, "passed": state} for check in read_rubric()[one["id"]]]
        graded = {key: value for key, value in graded.items() if key in ("status", "stages", "score", "points", "faults", "unread",
                                                                              "cpu_seconds", "peak_mib", "seconds")}

        def run(*more, **patches) -> tuple:
            patches = {"choose": lambda _: Unguarded, "ready_toolchain": lambda box: SimpleNamespace(digest="d", box=Unguarded), **patches}
            with mock.patch.multiple(grade, **patches), redirect_stdout(Terminal()) as told, redirect_stderr(Terminal()) as errors:
                return main([*words, *more]), told.getvalue(), errors.getvalue()
        code, _, errors = run(grade=lambda *_: dict(graded))
        self.assertEqual(code, 1, "not all that was handed in has a mark")
        self.assertIn("nobody: belongs to nobody in the class", errors)
        sheet.write_text("id,name,override,reason\n7,Ada,1.2=9,an oral\n8,Bob,,\n", encoding="utf-8")
        code, _, errors = run("--keep", "best", "--due", "2001-01-01T00:00", "--late", "0", grade=None)
        self.assertEqual(code, 1, errors)
        with open(out / "students.csv", encoding="utf-8-sig", newline="") as file:
            self.assertEqual([(row["name"], row["total"], row["submission"]) for row in csv.DictReader(file)],
                             [("Ada", "19", "hw_7"), ("Bob", "", "")])
        self.assertTrue((out / "canvas.csv").exists() and (out / "moodle.csv").exists())
        self.assertRegex(words_of(out / "hw_7" / "feedback.html"), r"(?s)stage 1.2, changed by hand: an oral\s+9\s+total\s+19")
        rubric = {**read_rubric(), "1.1": {check: 3 for check in read_rubric()["1.1"]}}
        words[1:3] = []
        code, _, errors = run(grade=None, ready_toolchain=None, read_rubric=lambda: rubric)  # nothing is named, built or judged
        with open(out / "grades.csv", encoding="utf-8", newline="") as file:
            self.assertEqual({row["name"]: row["score"] for row in csv.DictReader(file)}["hw_7"], "24", errors)
        hidden, page = self.folder / "hidden", self.folder / "talk.html"
        words[1:] = [str(self.folder / "hw_7"), "--out", str(out), "--stages", "1.1,1.2", "--earlier", str(out), "--anonymous", str(hidden), "--talk", str(page)]
        code, _, errors = run(grade=None)
        self.assertTrue(page.exists() and (hidden / "summary.html").exists(), errors)
        self.assertIn(f"{out}/hw_7", words_of(out / "summary.html"), "who is like those of an earlier year, here themselves")

    def test_stages_that_were_judged_at_another_time_are_kept_and_none_is_taken_for_nothing(self):
        out, file = self.folder / "out", self.folder / "gauge_prior.cc"
        file.write_text("// mine\n")
        asked, whole = [], record("x", 12, 14, states=("right", "right"))
        for one in whole["stages"]:
            one["checks"] = [{"name": check, "passed": True} for check in read_rubric()[one["id"]]]

        def judged(_submission, _toolchain, stages, *_):
            asked.append([stage["id"] for stage in stages])
            return {**{key: value for key, value in whole.items() if key not in ("name", "path", "key", "content", "handed_in")},
                    "stages": [one for one in whole["stages"] if one["id"] in asked[-1]]}

        def run(*words) -> tuple:
            with mock.patch.multiple(grade, choose=lambda _: Unguarded, ready_toolchain=lambda box: SimpleNamespace(digest="d", box=Unguarded), grade=judged), \
                    redirect_stdout(Terminal()), redirect_stderr(Terminal()) as errors:
                code = main(["grade", *words, "--out", str(out)])
            with open(out / "grades.csv", encoding="utf-8", newline="") as table:
                return code, next(csv.DictReader(table))["score"], errors.getvalue()
        self.assertEqual(run(str(file), "--stages", "1.1")[:2], (0, "10"))
        code, score, told = run("--class", str(self.sheet("id,name", "7,Ada")), "--stages", "1.1,1.2")
        self.assertEqual((code, score), (1, ""), "half of it is no mark")
        self.assertIn("stage 1.2 was not judged; name this submission again", told)
        for say in (ENGLISH, CHINESE):
            told = run("--class", str(self.path), "--stages", "1.1,1.2", "--language", say.language)[2]
            self.assertIn(say("grade.stages_lacking", stages="1.2"), told)
            self.assertEqual(words_of(out / file.name / "feedback.html").strip().split("\n")[-1], say("grade.partly_judged"))
            self.assertNotIn(say("grade.grader_failed"), (out / file.name / "results.json").read_text(encoding="utf-8"))
        self.assertEqual(run("--class", str(self.path))[1], "10", "a re-marking is of the stages that were judged")
        self.assertEqual([run(str(file), "--stages", names)[:2] for names in ("1.2", "1.1,1.2", "1.1")], [(0, "12"), (0, "22"), (0, "10")])
        self.assertEqual(asked, [["1.1"], ["1.2"]], "each was judged once")

    def test_wrong_words_are_refused_before_anything_is_graded(self):
        for words, told in ((["--late", "5"], "need --class FILE"), (["--keep", "first"], "--keep must be one of last, best, got 'first'"),
                            (["--column", "x"], "need --class FILE"), (["--class", "x.csv", "--due", "noon"], "x.csv: cannot be read"), (["--late", "101"], "--late must be")):
            with redirect_stderr(Terminal()) as errors:
                self.assertEqual(main(["grade", __file__, *words]), 2)
            self.assertIn(told, errors.getvalue())


class Likeness(unittest.TestCase):
    SAMPLES = [one for one in all_samples() if one.state == "right" and all(key.startswith("REGION") for key in one.code)]

    @staticmethod
    def of(one) -> tuple:
        file = one.stages[0]["file"]
        return file, source(file, one.code)

    @staticmethod
    def made(texts: dict) -> list:
        return [{"name": name, "fingerprint": fingerprint({file: text.encode()})} for name, (file, text) in texts.items()]

    def test_right_answers_of_different_people_are_not_alike(self):
        self.assertGreater(len(self.SAMPLES), 50)
        self.assertEqual(alike(self.made({one.name: self.of(one) for one in self.SAMPLES})), [])

    def test_a_copy_is_found_after_renaming_and_new_comments(self):
        texts = {one.name: self.of(one) for one in self.SAMPLES}
        copies = {}
        for name, (file, text) in texts.items():
            if len(fingerprint({file: text.encode()})[file]) < 60:
                continue
            own = {word for word in re.findall(r"\b(?:const )?(?:auto|int|double|MatXX|VecX)&? (\w+)(?= =|\()", text)}
            for number, word in enumerate(sorted(own)):
                text = re.sub(rf"(?<![\w.>:]){word}\b(?!\()", f"q{number}", text)
            copies[name] = (file, re.sub(r";\n", ";  // mine\n\n", text))
        self.assertGreater(len(copies), 30)
        lost = [name for name, copy in copies.items() if not alike(self.made({"a": texts[name], "b": copy}))]
        self.assertEqual(lost, [])
        name, copy = next(iter(copies.items()))
        now, then = self.made({"b": copy}), self.made({"2025/a": texts[name]})
        self.assertEqual([[pair[:2] for pair in alike(*years)] for years in ((now, then), ([], now + then))],
                         [[("b", "2025/a")], []], "two of earlier years are of no matter")
        with self.assertRaisesRegex(CourseError, "no record.json"):
            earlier("/usr/include")

    @unittest.skipUnless(READY, "no Clang: without ./course grade")
    def test_a_copy_of_the_solution_is_known_by_its_instructions(self):
        file, toolchain = "problem.cc", Toolchain(choose())
        solution = fill(solution_text(file), lambda region: region.solution)
        known, made = toolchain.solved(file), lambda text: functions_in(toolchain._made(0, file, text.encode()))
        self.assertEqual(len(known), 3)
        copy = "// mine\n#define LOOP for\n" + re.sub(r"\bfor \(", "LOOP /* */ (", re.sub(r"\b(Hmm_inv|tempH|index_i)\b", r"my_\1", solution))
        copy = copy.replace("Hmm = H.block", "(void)0;;\n\n  Hmm = H.block")
        self.assertNotEqual(copy.count("\n"), solution.count("\n"))  # an assertion tells its line
        own = made(copy)
        self.assertEqual({name for name, its in known.items() if own[name] == its}, {*known})
        others = [one for one in self.SAMPLES if self.of(one)[0] == file][:6]
        for one in others:
            own = made(source(file, one.code))
            self.assertNotEqual({name: own[name] for name in known}, known, one.name)

    def test_files_are_listed_whose_functions_most_do_not_have(self):
        def solved(**names) -> list:
            return as_solution([{"name": name, "solved": {"problem.cc": [own, 3]}} for name, own in names.items()])
        self.assertEqual(solved(a=["f", "g", "h"], b=["f"], c=[], d=None), [("a", "problem.cc", 3, 3), ("d", "problem.cc", None, 3)])
        self.assertEqual(solved(**{name: ["f", "g", "h"] for name in "abc"}), [], "what so many write is what one writes")

    def test_what_is_no_text_of_the_homework_has_no_likeness(self):
        self.assertEqual(fingerprint({"problem.cc": b"\xff\x00/*"}), {"problem.cc": []})
