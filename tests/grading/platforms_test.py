"""What Canvas, Moodle and Gradescope give is read, and given back as their imports want it; whose a file is, by any name.

The tables in platforms/ are made up, in the formats of Moodle's mod/assign/gradingtable.php with feedback/offline, its
grade/export/txt, Canvas's gradebook_exporter.rb with content_zipper.rb, and Gradescope's roster and export of submissions.
"""

import csv
import unicodedata
from pathlib import Path

from tests.folder import FolderTest
from tests.grading.class_test import POINTS, record
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.base.language import speaker
from ch5_backend.course.grading import classbook, gradebooks, outputs
from ch5_backend.course.grading.handed_in import class_in, gradescope, listed, named
from ch5_backend.course.grading.owners import owners_of

TABLES = Path(__file__).with_name("platforms")


class Platform(FolderTest):
    def book(self, name: str, **more) -> classbook.Class:
        book = classbook.read_class(TABLES / name, POINTS)
        for key, value in more.items():
            setattr(book, key, value)
        return book

    def back(self, book, records: list, file: str) -> list:
        """The rows of a written table, read anew in the encoding and with the separator that it came in."""
        marks, self.lost = classbook.settle(book, records, POINTS)
        rows, delimiter, encoding = gradebooks.tables(book, marks, POINTS, speaker("en"))[file]
        path = self.folder / file
        outputs.write_table(path, rows, delimiter, encoding)
        self.assertEqual((delimiter, encoding == "utf-8-sig"), (book.table.delimiter, book.table.encoding == "utf-8-sig"))
        with open(path, newline="", encoding="utf-8-sig") as read:
            return list(csv.reader(read, delimiter=delimiter))

    def rows(self, name: str, delimiter=",") -> list:
        with open(TABLES / name, newline="", encoding="utf-8-sig") as file:
            return list(csv.reader(file, delimiter=delimiter))

    def test_moodles_worksheet_comes_back_with_grades_and_nothing_else_changed(self):
        folders = ("Anna Li_657693_assignsubmission_file_", "Toni-Marie Noël_657694_assignsubmission_file_", "张三_657696_assignsubmission_file")
        records = [record("homework.zip", folder=folders[0]), record(folders[1]), record(folders[2], first=0, status="not-read", states=("unread", "wrong"))]
        book = self.book("moodle_worksheet.csv", due=classbook.read_due("2026-12-01T23:59", POINTS))
        came, back = self.rows("moodle_worksheet.csv"), self.back(book, records, "moodle.csv")
        grade = came[0].index("Grade")
        self.assertEqual([row[grade] for row in back[1:]], ["12", "10.8", "", ""])  # 657693 is another student's ID number
        self.assertEqual([row[:grade] + row[grade + 1:] for row in back], [row[:grade] + row[grade + 1:] for row in came])
        self.assertEqual(self.lost, [])

    def test_other_forms_of_moodles_worksheet(self):
        for name, files in (("moodle_anonymous.csv", ["Participant_657693_assignsubmission_file_"]),
                            ("moodle_worksheet_zh.csv", ["张三_657693_assignsubmission_file_problem.cc"])):
            back = self.back(self.book(name), [record(file) for file in files], "moodle.csv")
            grade = next(k for k, column in enumerate(back[0]) if column in ("Grade", "成绩"))
            self.assertEqual((back[0], [row[grade] for row in back[1:]]), (self.rows(name)[0], ["12", ""]))
        self.assertEqual(self.book("moodle_worksheet_zh.csv").students[0].sent, classbook.read_time("", "2026-12-01T23:59"))
        self.assertEqual(gradebooks.refused_there(self.book("moodle_worksheet.csv"), 120), "100.00")
        self.assertEqual(gradebooks.refused_there(self.book("moodle_worksheet.csv"), 100), "")

    def test_moodles_gradebook_gets_its_column(self):
        records = [record("Anna Li_1_assignsubmission_file_"), record("hw_bobby.bunce7@example.edu.zip"), record("张三_3_assignsubmission_file_")]
        back = self.back(self.book("moodle_gradebook.csv", column="Homework 5"), records, "moodle.csv")
        self.assertEqual(back[0], ["First name", "Last name", "ID number", "Institution", "Department", "Email address",
                                   "Assignment: Homework 5 (Real)", "Feedback comments"])
        self.assertEqual([(row[0], row[2], row[5], row[6]) for row in back[1:]],
                         [("Anna", "2021012345", "anna.li@example.edu", "12"), ("Bobby", "", "bobby.bunce7@example.edu", "12"), ("张", "", "zhangsan@example.edu", "12")])

    def test_canvas_gets_the_students_columns_and_one_of_grades(self):
        records = [record("lovelaceada_12345_680_problem.cc"), record("oneilseán_LATE_12347_681_12345.zip", 6), record("maxm_777_12347_12345.zip")]
        for name, delimiter in (("canvas.csv", ","), ("canvas_semicolon.csv", ";")):
            back = self.back(self.book(name, column="Homework 5"), records, "canvas.csv")
            self.assertEqual(back, [["Student", "ID", "SIS User ID", "SIS Login ID", "Section", "Homework 5 (87568490)"],
                                    ["    Points Possible", "", "", "", "", "100"],
                                    *([*row[:5], grade] for row, grade in zip(self.rows(name, delimiter)[3:], ("12", "6", "", "")))])
            self.assertEqual([name for name, _ in self.lost], ["maxm_777_12347_12345.zip"], "its numbers are another's at another place")
        back = self.back(self.book("canvas.csv"), [], "canvas.csv")
        self.assertEqual([row[5] for row in back[:2]], ["Chapter 5", "26"], "a new column, with its points")

    def test_gradescopes_export_says_whose_and_when(self):
        found = gradescope(TABLES)
        records = [record(name, **found[name]) for name in found]
        marks, lost = classbook.settle(self.book("gradescope_roster.csv", due=classbook.read_due("2026-12-02T00:00+00:00", POINTS)), records, POINTS)
        self.assertEqual([(mark.student.id, mark.total, mark.time_from) for mark in marks],
                         [("2021000001", 12, "platform"), ("2021000002", 10.8, "platform"), ("grace@example.edu", 10.8, "platform")])
        self.assertEqual(lost, [])

    def test_a_worksheet_without_grades_is_refused(self):
        path = self.folder / "w.csv"
        path.write_text("Identifier,Full name,Status\nParticipant 12,Ada,-\n")
        with self.assertRaisesRegex(CourseError, "w.csv:1: of a grading worksheet, but without the column Grade, got 'Identifier, Full name, Status'"):
            classbook.read_class(path, POINTS)


class Owners(FolderTest):
    STUDENTS = (("2021012345", "张三"), ("2021012346", "李四"), ("2021012347", "张三丰"), ("s7", "José Ñíguez"), ("00123", "דנה כהן"),
                ("k9", "Zhang Wei"), ("k10", "Zhang Wei"), ("m1", "Ana-María Müller"), ("555", "Zoë, Anna"), ("b2", "Bo 2"))

    def owners(self, name: str, folder="submissions") -> list:
        path = self.folder / "class.csv"
        path.write_text("id,name\n" + "".join(f'{id},"{name}"\n' for id, name in self.STUDENTS), encoding="utf-8")
        return [one.id for one in owners_of(classbook.read_class(path, POINTS).students, record(name, folder=folder))]

    def test_ids_and_names_of_every_script(self):
        composed, apart = "José Ñíguez.zip", unicodedata.normalize("NFD", "José Ñíguez.zip")
        for name, id in (("2021012345张三.zip", "2021012345"), ("张三2021012345.zip", "2021012345"), ("第五章作业2021012345.zip", "2021012345"),
                         ("２０２１０１２３４６李四.zip", "2021012346"), ("李四_作业5.zip", "2021012346"), ("2021012347_张三丰", "2021012347"),
                         ("张三丰 final.rar", "2021012347"), (composed, "s7"), (apart, "s7"), ("ÑÍGUEZ_JOSÉ_hw.zip", "s7"),
                         ("\u202bדנה כהן\u202c.zip", "00123"), ("hw-00123.zip", "00123"), ("hw-٠٠١٢٣.zip", "00123"),
                         ("müller ana-maría.zip", "m1"), ("2021012345Zhang.zip", "2021012345"), ("hw2021012346.zip", "2021012346"), ("Bo 2 hw.zip", "b2"), ("Anna Zoë hw5.zip", "555"), ("K9.zip", "k9")):
            self.assertEqual(self.owners(name), [id], name)
        self.assertEqual(self.owners("homework.zip", "2021012345-张三"), ["2021012345"])

    def test_what_is_not_certain_is_nobodys_or_several(self):
        for name in ("2021012345678.zip", "12021012345.zip", "张三作业.zip", "李四光.zip", "s77.zip", "xk9.zip", "123.zip"):
            self.assertEqual(self.owners(name), [], name)
        for name, ids in (("Zhang Wei.zip", ["k9", "k10"]), ("2021012345李四.zip", ["2021012345", "2021012346"]),
                          ("2021012345_2021012346.zip", ["2021012345", "2021012346"])):
            self.assertEqual(self.owners(name), ids, name)
        self.assertEqual(self.owners("k10 Zhang Wei.zip"), ["k10"], "a namesake does not quarrel with an id")

    def test_zeros_that_a_spreadsheet_has_eaten_are_told(self):
        path = self.folder / "class.csv"
        path.write_text("id,name\n123,Ada\n")
        marks, lost = classbook.settle(classbook.read_class(path, POINTS), [record("hw_00123.zip")], POINTS)
        self.assertEqual((marks[0].total, lost[0][1]["id"]), (None, "grade.zeros_eaten"))


class Lists(FolderTest):
    def made(self, *names) -> list:
        for name in names:
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / name).write_bytes(b"//")
        return [self.folder / name for name in names]

    def test_the_files_of_one_student_are_one_submission_newest_first(self):
        files = self.made("li_12_678_problem.cc", "li_12_680_problem-1.cc", "li_12_679_gauge_prior.cc", "bo_13_690_problem.cc",
                          "Anna Li_5_assignsubmission_file_problem.cc", "Anna Li_5_assignsubmission_file_open_tasks.cc")
        found = {name: [path.name for path in paths] for name, paths in named(files).items()}
        self.assertEqual(found, {"li_12": ["li_12_680_problem-1.cc", "li_12_679_gauge_prior.cc", "li_12_678_problem.cc"],
                                 "bo_13": ["bo_13_690_problem.cc"], "Anna Li_5": [path.name for path in files[4:]]})

    def test_a_folder_of_submissions_stands_for_them_and_a_submission_for_itself(self):
        self.made("class/ada/problem.cc", "class/bob/hw/problem.cc", "class/submission_metadata.yml", "zips/a.zip", "zips/b.rar",
                  "moodle/A_1_assignsubmission_file_/x.docx", "moodle/B_2_assignsubmission_file_/problem.cc",
                  "one/problem.cc", "one/old/problem.cc", "one/older/problem.cc", "parts/a/problem.cc", "parts/b/gauge_prior.cc", "hw/hw.zip")
        names = lambda folder: [path.name for path in class_in(self.folder / folder)]
        self.assertEqual([names(one) for one in ("class", "zips", "moodle")],
                         [["ada", "bob"], ["a.zip", "b.rar"], ["A_1_assignsubmission_file_", "B_2_assignsubmission_file_"]])
        self.assertEqual([names(one) for one in ("one", "parts", "hw")], [[], [], []])
        inside = listed([self.folder / "class", self.folder / "zips"], None)
        self.assertEqual([path.name for path in inside], ["class", "zips"], "of several that are named each is one")
        table = self.folder / "list.txt"
        table.write_text(f"{self.folder / 'class'}\n\n{self.folder / 'class' / 'submission_metadata.yml'}\n")
        self.assertEqual(listed([], table), [self.folder / "class"])
        table.write_text("one\n/nowhere/x.zip\n")
        with self.assertRaisesRegex(CourseError, "list.txt:1: there is no such submission, got 'one'"):
            listed([], table)
