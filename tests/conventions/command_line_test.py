"""./course as its users see it: help, refusals, JSON, and silence where nobody looks."""

import fcntl
import itertools
import json
import os
import re
import signal
import subprocess
from importlib import import_module
from pathlib import Path
from unittest import mock

from ch5_backend.course.__main__ import ACTIONS, dispatch
from ch5_backend.course.base.commands import COMMANDS, make_parser
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.base.language import width
from tests.folder import FolderTest
from tests.project import BUILD, ROOT, TINY_BAL, run
from tests.terminal import on_terminal


def course(*words, **options):
    return run(ROOT / "course", *words, **options)


class CommandLine(FolderTest):
    def path(self, name: str, content=b"") -> Path:
        path = self.folder / name
        path.write_bytes(content)
        return path

    def refuses(self, *words, naming=(), **options):
        """Exit 2, one clear message on standard error with the words in `naming`, nothing on standard output."""
        done = course(*words, **options)
        self.assertEqual(done.returncode, 2, done)
        self.assertEqual(done.stdout, "")
        self.assertTrue(done.stderr.startswith("course: "), done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        for word in naming:
            self.assertIn(str(word), done.stderr)

    def test_help_names_every_command(self):
        self.assertEqual(list(ACTIONS), list(COMMANDS))
        for words in ([], ["help"], ["--help"], ["-h"], ["help", "--help"], ["help", "help"]):
            done = course(*words)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            for command in COMMANDS:
                self.assertIn(f"./course {command}", done.stdout)

    def test_what_is_said_fits_the_terminal_and_cuts_no_word(self):
        for language in ("C.UTF-8", "zh_CN.UTF-8"):
            env = {name: value for name, value in os.environ.items() if name != "COLUMNS"} | {"LC_ALL": language}
            for words in (["help"], ["status"], ["hint", "1.2", "2"], ["evidence"]):
                said = re.findall(r"[\w./-]+", course(*words, env=env).stdout, re.ASCII)
                self.assertGreater(len(said), 20)
                for columns in (60, 80, 120):
                    _, shown = on_terminal([ROOT / "course", *words], columns, env=env | {"NO_COLOR": "1"})
                    self.assertLessEqual(max(map(width, shown.splitlines())), columns, words)
                    self.assertEqual(re.findall(r"[\w./-]+", shown, re.ASCII), said, words)
            for command, columns in itertools.product(COMMANDS, (60, 80, 120)):
                with mock.patch.dict(os.environ, env | {"COLUMNS": str(columns)}):
                    self.assertLessEqual(max(map(width, make_parser(command).format_help().splitlines())), columns, command)

    def test_every_command_has_help_in_the_terminal_s_language(self):
        chinese = {"LC_ALL": "zh_CN.UTF-8"}
        for command in COMMANDS:
            with mock.patch.dict(os.environ, {"LC_ALL": "C.UTF-8"}):
                self.assertIn(f"usage: ./course {command}", make_parser(command).format_help())
            with mock.patch.dict(os.environ, chinese):
                english = re.sub(r"usage: .*\n|字段：[^；]*|[A-Z]{3,}|\./course[^。；]*", "", make_parser(command).format_help())
            self.assertNotRegex(english, r"\b(the|of|and|default|such as)\b", command)
        for words, named in ((["check", "--help"], ["check"]), (["help", "check"], ["check"]), (["watch", "--help"], ["check"]), (["paper", "--help"], ["paper"]), (["help"], COMMANDS)):
            done = course(*words, env=os.environ | chinese)
            self.assertEqual((done.returncode, done.stderr), (0, ""), words)
            for command in named:
                self.assertIn(f"./course {command}", done.stdout)

    def test_a_typing_error_is_answered_with_what_was_meant(self):
        self.refuses("chek", naming=["did you mean ./course check?"])
        self.refuses("statsu", naming=["./course status?"])

    def test_unknown_words_are_refused(self):
        self.refuses("frobnicate", naming=["frobnicate"])
        self.refuses("", naming=["unknown command"])
        self.refuses("check", "9.9", naming=["9.9"])
        self.refuses("status", "1.1", naming=["1.1"])
        self.refuses("check", "--seed", "x", env={**os.environ, "LC_ALL": "zh_CN.UTF-8"}, naming=["--seed 应为 0 到 9"])
        self.refuses("check", "--seed", "x", "--language", "zh", naming=["--seed 应为 0 到 9"])
        self.refuses("check", "--seed=zh", env={**os.environ, "LC_ALL": "C.UTF-8"}, naming=["--seed must be"])
        self.refuses("fly", "--language=zh", ROOT / "README.md", naming=["不是已知的数据格式"])
        self.refuses("hint", naming=["needs a stage", "6A"])
        self.refuses("hint", "9.9", "1", naming=["9.9", "1.2, 2"])
        self.refuses("hint", "1.2", "4", naming=["1.2", "1, 2, 3", "'4'"])
        self.refuses("hint", "1.2", "1", "--language", "fr", naming=["fr"])
        self.refuses("slides", "--frobnicate", naming=["--frobnicate", "./course slides --help"])
        for command in COMMANDS:
            with self.assertRaisesRegex(CourseError, f"--frobnicate.*/course {command} --help"):
                make_parser(command).parse_args(["--frobnicate"])

    def test_a_test_that_cannot_be_is_refused_before_a_build(self):
        self.refuses("test", "Grading." + "qz" * 3, naming=["no test is called"])  # a word that no file has, this one included

    def test_options_are_not_guessed_from_their_beginning(self):
        self.refuses("run", "--iter", "5", naming=["--iter"])

    def test_a_wrong_value_is_refused_before_a_build_as_the_program_would(self):
        solver, recording = ("ch5_bal", self.path("tiny.txt", TINY_BAL.encode())), ("ch5_recording", self.folder)
        graph = ("ch5_pose_graph", self.path("graph.g2o", b"FIX 0\n"))
        options = {name for name, one in COMMANDS["run"]["arguments"].items() if {"range", "one_of", "form"} & one.keys()}
        for (program, data), option, values in (
                (solver, "--iterations", ["-1", "1000001", "9" * 5000, "1e3", "+5"]), (solver, "--threads", ["", "0", "257", "٣"]),
                (solver, "--huber", ["0", "1e7", "nan", "1_0"]), (solver, "--solver", ["magic"]),
                (graph, "--init", ["magic"]), (graph, "--loss", ["magic"]), (graph, "--scale", ["0", "1e7"]), (graph, "--incremental", ["0", "1e3"]),
                (recording, "--policy", ["both"]), (recording, "--first-estimates", ["all"]), (recording, "--window", ["3", "1001"]),
                (recording, "--max-features", ["7", "100001"]), (recording, "--pixel-sigma", ["0.001", "101", "nan"]), (recording, "--seconds", ["5", "5:5", "-1:", "a:"])):
            options.remove(option)
            for value in values:
                own = run(BUILD / "bin" / program, data, "--out", self.folder / "out", option, value)
                refusal = own.stderr.removeprefix(f"{program}: ").replace("; see --help", "; see ./course run --help")
                self.assertTrue(refusal.startswith(f"{option} must be "), own)
                self.refuses("run", data, f"{option}={value}", naming=[f"course: {refusal}"])
        self.assertEqual(options, set())

    def test_the_ends_of_a_range_are_in_it(self):
        for words in ("--iterations 0 --threads 256 --huber 1e6 --window 4 --seconds 5:", "--iterations 1000000 --huber .5e-5 --seconds :2.5",
                      "--huber 5. --window 1000 --seconds :"):
            make_parser("run").parse_args(words.split())

    def test_solver_options_need_data_that_they_apply_to(self):
        self.refuses("run", "--iterations", "5", naming=["--iterations", "DATA"])
        self.refuses("run", self.path("window.txt", b"VIOWIN 1\n"), "--huber", "1", naming=["--huber does not apply"])
        self.refuses("run", self.path("imu.csv").parent, "--iterations", "5", naming=["--iterations does not apply"])

    def test_data_that_cannot_be_read_is_named(self):
        out = self.folder / "out"
        binary = bytes(range(256)) * 16
        cases = [self.path("empty.txt"), self.path("blank.txt", b"\n \n"), self.path("binary.txt", binary),
                 self.path("prose.txt", b"once upon a time\n"), self.path("packed.bz2", b"BZh91AY&SY"),
                 self.folder / "missing.txt", self.folder, Path("/dev/null"),
                 self.path("w.txt", b"VIOWIN 9\n")]
        for path in cases:
            self.refuses("run", path, "--out", out, naming=[path])
        self.assertFalse(out.exists(), "bad input must leave no trace")

    def test_a_failure_leaves_no_empty_folder(self):
        """As where there is no compiler."""
        out = self.folder / "new" / "out"
        for command, module, step in (("run", "course.experiments.run", "build_or_fail"),
                                      ("bench", "course.experiments.bench", "build_or_fail"),
                                      ("plots", "course.experiments.plots", "build_or_fail"),
                                      ("fly", "course.experiments.fly", "compile_files"),
                                      ("lab", "course.documents.lab", "build_wasm")):
            failing = mock.patch.object(import_module(f"ch5_backend.{module}"), step, side_effect=CourseError("no compiler"))
            begun = mock.patch("ch5_backend.course.experiments.fly.require_own")
            with begun, failing, self.assertRaisesRegex(CourseError, "no compiler"):
                dispatch(command, make_parser(command).parse_args(["--out", str(out)]))
            self.assertFalse(out.parent.exists(), command)

    def test_fly_follows_the_images_of_a_folder_first(self):
        fly, out = import_module("ch5_backend.course.experiments.fly"), self.folder / "out"
        (self.folder / "mav0" / "cam0").mkdir(parents=True)
        (out / "mine").mkdir(parents=True)
        with mock.patch.multiple(fly, require_own=mock.DEFAULT, compile_files=dict, build_or_fail=mock.DEFAULT), \
                mock.patch.object(fly, "run_programs") as programs, mock.patch.object(fly, "run_all", return_value={}) as flown:
            dispatch("fly", make_parser("fly").parse_args([str(self.folder), "--out", str(out)]))
        self.assertEqual(programs.call_args_list[0][0][0][0][1:], [str(self.folder), "--out", out / "mine/recording"])
        self.assertEqual(flown.call_args[0][2], str(out / "mine/recording"))

    def test_a_pipe_that_nobody_writes_into_is_refused(self):
        pipe = self.folder / "pipe.txt"
        os.mkfifo(pipe)
        self.refuses("run", pipe, naming=[pipe, "not a regular file"])

    def test_a_folder_above_or_below_a_recording_is_told_which_one(self):
        cam0 = self.folder / "room" / "mav0" / "cam0"
        cam0.mkdir(parents=True)
        for path, near in ((cam0, cam0.parent), (self.folder, self.folder / "room")):
            self.refuses("run", path, naming=[path, f"no recording; {near.resolve()} is one"])
        imu = self.path("imu.csv", b"#timestamp [ns],w_x\n")
        self.refuses("run", imu, naming=[imu, f"it is of the recording {imu.parent.resolve()}, give that"])

    def test_a_bag_is_named_as_what_it_is(self):
        for head in (b"SQLite format 3\0", b"\x89MCAP0\r\n"):
            bag = self.path("room.bag", head)
            self.refuses("run", bag, naming=[bag, "bags of ROS 2 are not read"])

    def test_results_that_would_overwrite_an_input_are_refused(self):
        folder = self.folder / "out" / "street"
        folder.mkdir(parents=True)
        inside = folder / "street.txt"
        inside.write_text(TINY_BAL)
        other = self.path("street.txt", TINY_BAL.encode())
        link = self.folder / "link"
        link.symlink_to(folder.parent)
        for words in ([inside], [link / "street" / "street.txt"]):
            self.refuses("run", *words, "--out", folder.parent, naming=[folder, words[0], "overwrite", "--out"])
        points = folder / "points.csv"
        points.write_text(TINY_BAL)
        self.refuses("run", points, other, "--out", folder.parent, naming=[other, folder, points])
        self.assertEqual((inside.read_text(), points.read_text()), (TINY_BAL, TINY_BAL))
        self.assertEqual(sorted(folder.parent.iterdir()), [folder])

    def test_one_bad_file_stops_all_before_anything_is_written(self):
        good, bad = self.path("good.txt", TINY_BAL.encode()), self.path("bad.txt")
        out = self.folder / "out"
        self.refuses("run", good, bad, "--out", out, naming=[bad])
        self.assertFalse(out.exists())

    def test_two_files_of_one_name_are_refused(self):
        (self.folder / "other").mkdir()
        one, two = self.path("a.txt", TINY_BAL.encode()), self.path("other/a.txt", TINY_BAL.encode())
        self.refuses("run", one, two, naming=[one, two, "--out"])

    def test_an_unwritable_out_is_refused(self):
        bal = self.path("tiny.txt", TINY_BAL.encode())
        (self.folder / "mav0" / "cam0").mkdir(parents=True)
        occupied = self.path("occupied", b"keep me")
        for out in (occupied, occupied / "below", "/proc/nowhere", "/dev/full"):
            self.refuses("run", bal, "--out", out, naming=[out])
        for words in (["run"], ["track", self.folder], ["pack", "student"]):
            self.refuses(*words, "--out", occupied / "below", naming=[occupied / "below"])
        self.assertEqual(occupied.read_bytes(), b"keep me")

    def test_a_device_is_not_replaced_by_a_file(self):
        pipe = self.folder / "pipe"
        os.mkfifo(pipe)
        self.refuses("pack", "classroom", "--out", pipe, naming=[pipe, "not a regular file"])
        self.assertTrue(pipe.is_fifo())

    def test_json_is_one_object_whatever_happens(self):
        for words in (["run", "/nowhere/a.txt"], ["run", "--threads", "0"], ["run", "--frobnicate"],
                      ["run", self.path("empty.txt")], ["check", "9.9"], ["status", "1.1"]):
            done = course(*words, "--json")
            self.assertEqual(done.returncode, 2, done)
            self.assertEqual(list(json.loads(done.stdout)), ["error"])
            self.assertEqual(done.stdout.count("\n"), 1)
            self.assertNotEqual(done.stderr, "")

    def test_json_holds_every_letter_whatever_the_locale(self):
        ascii_only = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
        for extra in ({}, {"PYTHONIOENCODING": "ascii"}, {"PYTHONIOENCODING": "latin-1:strict"}):
            done = subprocess.run([ROOT / "course", "run", "/nowhere/straße Łódź.txt".encode(), "--json"], timeout=120,
                                  capture_output=True, env={**os.environ, **ascii_only, **extra})
            self.assertEqual(done.returncode, 2, done)
            encoding = extra.get("PYTHONIOENCODING", "utf-8").partition(":")[0]
            error = json.loads(done.stdout.decode(encoding))["error"]
            self.assertEqual(error, "/nowhere/straße Łódź.txt: there is no such file")
            self.assertNotIn(b"Traceback", done.stderr)

    def test_a_full_disk_under_standard_output_is_an_error(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("this system has no /dev/full")
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = subprocess.run([ROOT / "course", "status", "1.1", "--json"], stdout=full, stderr=subprocess.PIPE,
                                  text=True)
        self.assertEqual(done.returncode, 2)
        self.assertNotIn("Traceback", done.stderr)

    def test_a_reader_who_leaves_is_no_error(self):
        read, write = os.pipe()
        os.close(read)
        done = subprocess.run([ROOT / "course", "hint", "6", "1"], stdout=write, stderr=subprocess.PIPE, text=True)
        os.close(write)
        self.assertEqual((done.returncode, done.stderr), (128 + signal.SIGPIPE, ""))

    def test_it_works_from_any_folder_and_through_symbolic_links(self):
        folder = self.folder
        (folder / "bin").mkdir()
        (folder / "absolute").symlink_to(ROOT / "course")
        (folder / "bin" / "relative").symlink_to("../absolute")
        for words in (["help"], ["run", "--help"]):
            wanted = course(*words).stdout
            for command in (folder / "absolute", folder / "bin" / "relative", "relative"):
                done = run(command, *words, cwd=folder, env={**os.environ, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"})
                self.assertEqual((done.returncode, done.stdout, done.stderr), (0, wanted, ""), command)
        self.refuses("run", "missing.txt", naming=["missing.txt"], cwd=folder)

    def test_ctrl_c_ends_with_130(self):
        self.needs_release_build()
        bal = self.path("tiny.txt", TINY_BAL.encode())
        with open(BUILD / ".lock", "w", encoding="utf-8") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # now ./course must wait for us, at a place that we know
            process = subprocess.Popen([ROOT / "course", "run", bal, "--out", self.folder], text=True,
                                       stderr=subprocess.PIPE)
            self.assertIn("waiting", process.stderr.readline())
            process.send_signal(signal.SIGINT)
            rest = process.communicate(timeout=60)[1]
        self.assertEqual((process.returncode, rest), (130, "course: stopped\n"))

    def needs_release_build(self):
        if BUILD.resolve() != ROOT / "build" / "release":
            self.skipTest("./course builds in build/release, and these tests run in another folder")
