"""Only the homework's own files are taken from a submission, as bytes; whatever else it holds is not touched."""

import gzip
import io
import os
import tarfile
import time
import tracemalloc
import zipfile
from datetime import datetime
from pathlib import Path
from unittest import mock

from tests.folder import FolderTest
from tests.project import ROOT
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.base.language import speaker
from ch5_backend.course.grading.submission import LARGEST, LARGEST_ARCHIVE, collect, handed_in

CODE = b"// mine\n"
ENGLISH = speaker("en")


class Submissions(FolderTest):
    def zip(self, *members, name="anna.zip"):
        path = self.folder / name
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for member, content in members:
                archive.writestr(member, content)
        return collect(path)

    def tar(self, *members):
        path = self.folder / "anna.tar.gz"
        with tarfile.open(path, "w:gz") as archive:
            for member, content in members:
                info = member if isinstance(member, tarfile.TarInfo) else tarfile.TarInfo(member)
                info.size = len(content)
                archive.addfile(info, io.BytesIO(content))
        return collect(path)

    def test_a_file_a_folder_a_zip_and_a_tar_give_the_same(self):
        work = self.folder / "work" / "deep"
        work.mkdir(parents=True)
        (work / "problem.cc").write_bytes(CODE)
        found = [collect(work / "problem.cc"), collect(work.parent), self.zip(("hw/problem.cc", CODE)),
                 self.tar(("hw/problem.cc", CODE)), self.zip(("hw\\problem.cc", CODE))]
        self.assertEqual([one.files for one in found], [{"problem.cc": CODE}] * 5)
        self.assertEqual([one.faults for one in found], [[]] * 5)
        self.assertEqual(len({one.key() for one in found}), 1)

    def test_a_downloaded_copy_counts_by_the_name_it_begins_with(self):
        path = self.folder / "problem (2).cc"
        path.write_bytes(CODE)
        self.assertEqual(collect(path).files, {"problem.cc": CODE})
        path = path.rename(self.folder / "doejane_12345_678_problem-1.cc")  # from Canvas
        self.assertEqual(collect(path).files, {"problem.cc": CODE})
        path.rename(self.folder / "my_problem.cc")
        found = collect(self.folder / "my_problem.cc")
        self.assertEqual((found.files, len(found.faults)), ({}, 1))

    def test_a_name_counts_in_whatever_case_and_with_txt_behind(self):
        found = self.zip(("Gauge_Prior.CC", CODE), ("problem.cc.txt", b"copy"), ("deep/problem.cc", CODE))
        self.assertEqual(found.files, {"gauge_prior.cc": CODE, "problem.cc": CODE})  # the one spelled right
        for name in ("Problem.cc.txt", "PROBLEM.CC", "problem.cpp"):
            (self.folder / name).write_bytes(CODE)
            self.assertEqual(collect(self.folder / name).files, {"problem.cc": CODE})

    def test_a_name_that_resembles_one_is_told(self):
        found = self.zip(("problem_final.cc", CODE), ("gaugeprior.cpp", CODE), ("problem.h", CODE), ("a" * 60_000 + ".cc", CODE))
        self.assertEqual(found.files, {})
        self.assertEqual([ENGLISH.text(fault) for fault in found.faults],
                         ["gauge_prior.cc is missing, but there is gaugeprior.cpp; if that is meant, name it gauge_prior.cc",
                          "problem.cc is missing, but there is problem_final.cc; if that is meant, name it problem.cc"])
        for name in ("problem.cc ", "problem.cc.", "ｐｒｏｂｌｅｍ.cc", "problem.docx", "problem.cc.pdf", "2021_张三_problem.cc", "problem.hpp"):
            self.assertEqual(self.unread(self.zip((name, CODE), ("gauge_prior.cc", CODE))), ["resembling"], name)
        for name in ("._problem.cc", "problem.cc.before", "problem.cc.o", "problem.h"):
            self.assertEqual(self.zip((name, CODE), ("gauge_prior.cc", CODE)).faults, [], name)
        for copy in ("problem_old.cc", "problem (1).cc"):
            found = self.zip((copy, b"old"), ("problem.cc", CODE))
            self.assertEqual((found.files, found.unread), ({"problem.cc": CODE}, []))
            self.assertEqual([ENGLISH.text(fault) for fault in found.faults], [f"{copy} was not read: problem.cc is there, too, and counts"])
        (self.folder / "doejane_12345_678_gauge-prior.cpp").write_bytes(CODE)
        self.assertIn("there is gauge-prior.cpp", ENGLISH.text(collect(self.folder / "doejane_12345_678_gauge-prior.cpp").faults[0]))

    def test_no_other_names_are_taken(self):
        found = self.zip(("CMakeLists.txt", b"x"), ("stages.json", b"{}"), ("problem.cc\n", CODE), ("problem.h", b"x"),
                         ("__MACOSX/problem.cc", CODE), ("../../problem.cc.sh", b"x"))
        self.assertEqual(found.files, {})
        self.assertEqual(len(found.faults), 1)

    def test_nothing_is_written_outside_whatever_the_members_are_called(self):
        before = sorted(os.listdir(self.folder.parent))
        found = self.zip(("../../../../problem.cc", CODE), ("/tmp/gauge_prior.cc", CODE))
        self.assertEqual(set(found.files), {"problem.cc", "gauge_prior.cc"})
        self.assertEqual(sorted(os.listdir(self.folder.parent)), before)
        self.assertEqual(os.listdir(self.folder), ["anna.zip"])

    def test_of_two_with_one_name_the_one_nearer_to_the_top_counts(self):
        found = self.zip(("old/backup/problem.cc", b"old"), ("problem.cc", CODE), ("x/problem.cc", b"other"),
                         ("y/problem.cc", b"other"))
        self.assertEqual(found.files, {"problem.cc": CODE})
        self.assertEqual(["more than once" in ENGLISH.text(fault) for fault in found.faults], [True])

    def test_of_different_files_of_equal_rank_none_counts(self):
        for members in ((("x/problem.cc", CODE), ("y/problem.cc", b"other")), (("Problem.cc", CODE), ("PROBLEM.CC", b"other"))):
            found = self.zip(*members, ("gauge_prior.cc", CODE))
            self.assertEqual((found.files, self.unread(found)), ({"gauge_prior.cc": CODE}, ["several"]))
        self.assertEqual(self.zip(("x/problem.cc", CODE), ("y/problem.cc", CODE)).files, {"problem.cc": CODE})
        self.assertEqual(self.zip(("x/problem.cc", b"1"), ("y/problem.cc", b"2"), ("problem.cc", CODE)).unread, [])
        clone = self.zip(("c/solutions/problem.cc", b"course's"), ("c/ch5_homework/problem.cc", CODE), ("c/.git/problem.cc", b"x"))
        self.assertEqual((clone.files, clone.unread), ({"problem.cc": CODE}, []))
        self.assertEqual(self.tar(("problem.cc", b"old"), ("problem.cc", CODE)).files, {"problem.cc": CODE}, "as tar unpacks it")

    def test_a_bomb_is_not_unpacked(self):
        found = self.zip(("problem.cc", bytes(200 << 20)), ("gauge_prior.cc", CODE))
        self.assertEqual(found.files, {"gauge_prior.cc": CODE})
        self.assertIn("256 KB", ENGLISH.text(found.faults[0]))

    def test_a_size_that_lies_is_not_believed(self):
        path = self.folder / "liar.zip"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("problem.cc", bytes(4 * LARGEST))
        true_size, small = (4 * LARGEST).to_bytes(4, "little"), (8).to_bytes(4, "little")
        path.write_bytes(path.read_bytes().replace(true_size, small))
        found = collect(path)
        self.assertLessEqual(len(found.files.get("problem.cc", b"")), LARGEST)

    def test_a_time_that_no_calendar_has_and_a_folder_too_deep_are_as_if_handed_in_now(self):
        path = self.folder / "problem.cc"
        path.write_bytes(CODE)
        for year in (1e12, -1e12):
            with mock.patch.object(Path, "lstat", return_value=mock.Mock(st_mtime=year)):  # not every file system holds it
                self.assertLess(abs(datetime.fromisoformat(handed_in(path)).timestamp() - time.time()), 60)
        at = os.open(self.folder, os.O_RDONLY)
        for _ in range(50):
            os.mkdir("d" * 100, dir_fd=at)
            below = os.open("d" * 100, os.O_RDONLY, dir_fd=at)
            os.close(at)
            at = below
        os.close(at)
        self.assertLess(abs(datetime.fromisoformat(handed_in(self.folder)).timestamp() - time.time()), 60)
        self.assertEqual(len(collect(self.folder).faults), 1)

    def test_links_and_devices_are_not_followed(self):
        secret = self.folder / "secret"
        secret.write_bytes(b"secret")
        work = self.folder / "work"
        work.mkdir()
        (work / "problem.cc").symlink_to(secret)
        os.mkfifo(work / "gauge_prior.cc")
        self.assertEqual(collect(work).files, {})
        link = tarfile.TarInfo("problem.cc")
        link.type, link.linkname = tarfile.SYMTYPE, str(secret)
        self.assertEqual(self.tar((link, b"")).files, {})

    def test_a_link_or_a_pipe_is_no_submission(self):
        secret = self.folder / "secret.cc"
        secret.write_bytes(CODE)
        (self.folder / "problem.cc").symlink_to(secret)
        (self.folder / "work").symlink_to(ROOT / "solutions")
        (self.folder / "gone.zip").symlink_to("/nowhere")
        os.mkfifo(self.folder / "gauge_prior.cc")
        for name in ("problem.cc", "work", "gone.zip", "gauge_prior.cc"):
            found = collect(self.folder / name)
            self.assertEqual((found.files, len(found.faults)), ({}, 1), name)

    def test_a_tar_that_unpacks_without_end_costs_neither_time_nor_memory(self):
        for kind in (tarfile.REGTYPE, tarfile.GNUTYPE_LONGNAME, tarfile.XHDTYPE):
            info = tarfile.TarInfo("large.bin")
            info.size, info.type = 1 << 40, kind
            path = self.folder / "bomb.tar.gz"
            with gzip.open(path, "wb", 1) as file:
                file.write(info.tobuf(tarfile.GNU_FORMAT))
                for _ in range(100):
                    file.write(bytes(1 << 20))
            tracemalloc.start()
            found = collect(path)
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
            self.assertEqual((found.files, len(found.faults)), ({}, 1), kind)
            self.assertLess(peak, 3 * LARGEST_ARCHIVE)
            (self.folder / "short.tar").write_bytes(info.tobuf(tarfile.GNU_FORMAT))  # behind it there is nothing to unpack
            self.assertEqual(collect(self.folder / "short.tar").files, {}, kind)

    def test_a_broken_archive_is_a_fault_with_words(self):
        path = self.folder / "damaged.zip"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("problem.cc", CODE * 999)
        content = bytearray(path.read_bytes())
        content[45:60] = bytes(15)
        path.write_bytes(content)
        self.assertEqual((collect(path).files, len(collect(path).faults)), ({}, 1))
        for name, content in (("a.zip", b"PK\x03\x04" + b"x" * 50), ("b.tar.gz", b"\x1f\x8b\x08" + b"x" * 50),
                              ("c.txt", b"hello"), ("d.zip", b"")):
            path = self.folder / name
            path.write_bytes(content)
            found = collect(path)
            self.assertEqual(found.files, {}, name)
            self.assertEqual(len(found.faults), 1, name)

    def unread(self, found) -> list:
        return [fault["id"].removeprefix("submission.") for fault in found.unread]

    def test_what_may_hold_an_answer_and_was_not_understood_is_named(self):
        whole = {"a.rar": b"Rar!\x1a\x07\x01\x00" + bytes(20), "b.7z": b"7z\xbc\xaf\x27\x1c" + bytes(20), "c.docx": b"%PDF-1.7" + bytes(20)}
        for name, content in whole.items():
            (self.folder / name).write_bytes(content)
            self.assertEqual(self.unread(collect(self.folder / name)), ["other_kind"], name)
        inner = io.BytesIO()
        with zipfile.ZipFile(inner, "w") as archive:
            archive.writestr("problem.cc", CODE)
        self.assertEqual(self.unread(self.zip(("hw.zip", inner.getvalue()))), ["not_opened"])
        self.assertEqual(self.unread(self.zip(("word/document.xml", b"<x/>"), name="report.docx")), ["holds_nothing"])
        self.assertEqual(self.unread(self.zip(("gauge_prior_final(1).cc", CODE), ("problem.cc", CODE))), ["resembling"])
        self.assertEqual(self.unread(self.zip(("problem.cc", CODE), ("report.pdf", b"%PDF"), ("notes.txt", b"x"))), [])

    def test_one_encrypted_member_loses_no_other(self):
        self.zip(("gauge_prior.cc", CODE), ("problem.cc", CODE))
        path = self.folder / "anna.zip"
        content = bytearray(path.read_bytes())
        for magic, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
            content[content.find(magic) + place] |= 1  # the flag of the first member
        path.write_bytes(content)
        found = collect(path)
        self.assertEqual((found.files, self.unread(found)), ({"problem.cc": CODE}, ["file_unreadable"]))

    def test_an_archive_in_a_folder_is_opened_as_moodle_gives_it(self):
        self.zip(("hw/problem.cc", CODE))
        (self.folder / "notes.rar").write_bytes(b"Rar!\x1a\x07\x01\x00")
        found = collect(self.folder)
        self.assertEqual((found.files, self.unread(found)), ({"problem.cc": CODE}, ["other_kind"]))

    def test_the_files_of_one_student_are_read_together(self):
        for name, text in (("li_12_680_problem-1.cc", CODE), ("li_12_678_problem.cc", b"old"), ("li_12_679_gauge_prior.cc", CODE), ("li_12_681_page.pdf", b"%PDF")):
            (self.folder / name).write_bytes(text)
        names = ("li_12_680_problem-1.cc", "li_12_679_gauge_prior.cc", "li_12_678_problem.cc", "li_12_681_page.pdf")
        found = collect(*(self.folder / name for name in names))
        self.assertEqual((found.files, found.unread), ({"problem.cc": CODE, "gauge_prior.cc": CODE}, []))

    def test_a_zip_of_a_million_names_is_not_listed(self):
        path = self.folder / "names.zip"
        path.write_bytes(b"PK\x03\x04" + b"PK\1\2" * (20 * 10_000) + b"PK\x05\x06" + bytes(18))
        self.assertEqual(self.unread(collect(path)), ["unreadable"])

    def test_what_is_not_there_is_an_error(self):
        with self.assertRaisesRegex(CourseError, "nobody.zip: there is no such submission"):
            collect(self.folder / "nobody.zip")
