"""Every program, called wrongly: exit 2, one line that names option and value, and no file touched."""

import os

from tests.folder import FolderTest
from tests.project import BUILD, run

BIN = BUILD / "bin"

SOLVERS = ("ch5_bal", "ch5_pose_graph", "ch5_window")
OF_FILES = (*SOLVERS, "ch5_recording")
STUDIES = ("ch5_chapter", "ch5_nees", "ch5_endurance")
NUMBERS = {"--iterations": SOLVERS, "--threads": SOLVERS, "--huber": ("ch5_bal", "ch5_pose_graph"),
           "--scale": ("ch5_pose_graph",), "--landmark-steps": ("ch5_window",),
           "--runs": ("ch5_nees",), "--seconds": ("ch5_nees",), "--frames": ("ch5_endurance",)}
NO_NUMBERS = ("-1", "1e999", "nan", "many", "", "5x", "99999999999999", "+5", " 5", "1_0", "0x10", "--out")


class Programs(FolderTest):
    def setUp(self):
        super().setUp()
        (self.folder / "out").mkdir()
        (self.folder / "out" / "old.csv").write_text("of an earlier run\n")

    def write(self, name, text):
        (self.folder / name).write_text(text, encoding="utf-8")
        return name

    def refuses(self, program, *words, naming=(), **environment):
        """Stands in the folder, where "out" is the default of --out, too."""
        before = {path: path.stat().st_mtime_ns for path in self.folder.rglob("*")}
        done = run(BIN / program, *words, cwd=self.folder, env={**os.environ, **environment})
        what = (program, words, done)
        self.assertEqual((done.returncode, done.stdout), (2, ""), what)
        self.assertEqual(done.stderr.count("\n"), 1, what)
        self.assertTrue(done.stderr.startswith(f"{program}: "), what)
        for word in naming:
            self.assertIn(word, done.stderr, what)
        self.assertEqual({path: path.stat().st_mtime_ns for path in self.folder.rglob("*")}, before, what)

    def test_help_names_every_option(self):
        for program in (*OF_FILES, *STUDIES):
            done = run(BIN / program, "--help")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            for option in ("--out", *(option for option, programs in NUMBERS.items() if program in programs)):
                self.assertIn(option, done.stdout, program)

    def test_options_that_a_program_does_not_have(self):
        for program in (*OF_FILES, *STUDIES):
            for option in ("--frobnicate", "-v", "--ou", "--out=here"):
                self.refuses(program, option, naming=[f"unknown option '{option}'; see --help"])
            for option, programs in NUMBERS.items():
                if program not in programs and (option, program) != ("--seconds", "ch5_recording"):  # which takes A:B
                    self.refuses(program, option, "5", naming=[f"unknown option '{option}'"])
        self.refuses("ch5_recording", "--solver", "dense", naming=["unknown option '--solver'"])

    def test_numbers_that_are_none(self):
        for option, programs in NUMBERS.items():
            for program in programs:
                self.refuses(program, option, naming=[f"{option} needs a value"])
                for word in NO_NUMBERS:
                    self.refuses(program, option, word, naming=[option, f"got '{word}'; see --help"])
        self.refuses("ch5_nees", "--runs", "2.5", naming=["whole number from 1 to 10000, got '2.5'"])
        self.refuses("ch5_endurance", "--frames", "99", naming=["whole number from 100 to 1000000, got '99'"])
        self.refuses("ch5_pose_graph", "--init", "magic", naming=["--init must be one of file, odometry, spanning-tree, "
                                                                  "chordal, incremental, got 'magic'"])
        self.refuses("ch5_bal", "--init", "file", naming=["unknown option '--init'"])
        self.refuses("ch5_bal", "--solver", "magic", naming=["--solver must be one of automatic, dense, sparse, pcg, "])

    def test_out_needs_a_folder(self):
        for program in (*OF_FILES, *STUDIES):
            self.refuses(program, "--out", naming=["--out needs a value"])
            self.refuses(program, "--out", "", naming=["--out needs a value"])
            self.refuses(program, "--out", "--threads", naming=["--out needs a value, got '--threads'"])

    def test_out_that_cannot_be_a_folder(self):
        occupied = self.write("occupied", "keep me")
        for program in STUDIES:
            self.refuses(program, "--out", occupied, naming=[f"cannot write {occupied}/csv"])

    def test_words_too_many_or_too_few(self):
        for program in STUDIES:
            self.refuses(program, "more", naming=["unknown argument 'more'"])
        for program in OF_FILES:
            self.refuses(program, "--out", "out", naming=["which FILE?"])
            self.refuses(program, "a", naming=["--out is missing"])
            self.refuses(program, "a", "b", "--out", "out", naming=["'a' and 'b'"])

    def test_what_cannot_be_read(self):
        os.mkfifo(self.folder / "pipe")  # into which nobody writes
        for program in OF_FILES:
            for name in ("missing", "pipe", self.write("empty", ""), self.write("line", "once upon a time\n"),
                         self.write("binary", "\x7fELF\x01\x02\n")):
                self.refuses(program, name, "--out", "out", naming=[name])
            self.refuses(program, ".", "--out", "out")

    def test_an_unknown_width_of_registers(self):
        for program in (*OF_FILES, *STUDIES):
            words = ("missing", "--out", "out") if program in OF_FILES else ()
            for word in ("sse2", "AVX2", ""):
                self.refuses(program, *words, CH5_SIMD=word,
                             naming=[f"{program}: CH5_SIMD: '{word}' is none of portable, avx2 and avx512\n"])
