"""A program in the sandbox sees nothing of the machine, takes no more than it may, and leaves nothing behind."""

import os
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

from tests.project import ROOT
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.grading import sandbox
from ch5_backend.course.grading.sandbox import MIB, Limits, Sandbox

try:
    sandbox.preflight()
    WHY_NOT = ""
except CourseError as error:
    WHY_NOT = str(error)


def shell(script: str, **limits):
    return Sandbox(limits=Limits(**limits)).run(["sh", "-c", script])


def compiler(*command, **limits):
    """With a place to write, and the list of its processes: as a compiler runs, and not what is graded."""
    with tempfile.TemporaryDirectory() as folder:
        os.chmod(folder, 0o777)
        return Sandbox(writable={"/out": folder}, limits=Limits(**limits)).run(command)


CODE = """
import ctypes, mmap
for what in ("mmap.mmap(-1, 4096, prot=7)", "open('/tmp/x', 'w')", "open('/proc/self/mem', 'r+b')",
             "ctypes.CDLL(None, use_errno=True).mprotect(ctypes.c_void_p(id(what) & ~4095), 4096, 5)"):
    try:
        print(eval(what))
    except OSError as error:
        print(error.errno)
"""


@unittest.skipIf(WHY_NOT, WHY_NOT)
class Inside(unittest.TestCase):
    def test_words_and_exit_code_come_out(self):
        outcome = shell("echo $((6 * 7)); exit 3")
        self.assertEqual((outcome.exit_code, outcome.output, outcome.in_time), (3, "42\n", True))

    def test_only_the_system_and_what_is_bound_are_seen(self):
        with tempfile.TemporaryDirectory() as folder:
            os.chmod(folder, 0o755)
            (Path(folder) / "given").write_text("read me")
            box = Sandbox(read_only={"/in": folder})
            outcome = box.run(["sh", "-c", 'cat /in/given; ls /; ls "$0" /etc /home /root; echo x > /in/given', ROOT])
            self.assertEqual((Path(folder) / "given").read_text(), "read me")
        self.assertTrue(outcome.output.startswith("read mebin\ndev\nin\nlib"), outcome.output)
        self.assertEqual(outcome.output.count("No such file"), 4, outcome.output)
        self.assertIn("Read-only file system", outcome.output)

    def test_it_is_nobody_without_rights(self):
        outcome = compiler("sh", "-c", "id -u; grep -E 'CapEff|NoNewPrivs|Seccomp:' /proc/self/status")
        self.assertRegex(outcome.output, r"CapEff:\s+0{16}\nNoNewPrivs:\s+1\nSeccomp:\s+2")
        self.assertNotEqual(outcome.output.split()[0], "0")

    def test_no_network_and_no_new_namespace(self):
        outcome = shell("python3 -c 'import socket; socket.socket()'; unshare -U true")
        self.assertEqual(outcome.output.count("Operation not permitted"), 2, outcome.output)

    def test_other_processes_are_not_there(self):
        with subprocess.Popen(["sleep", "60"]) as other:
            outcome = compiler("sh", "-c", 'ls -d /proc/[0-9]* | wc -l; kill -9 "$0"', str(other.pid))
            self.assertIsNone(other.poll())
            other.kill()
        self.assertLess(int(outcome.output.split()[0]), 8)

    def test_the_first_process_inside_is_limited_too(self):  # the others may write into its memory
        self.assertRegex(compiler("cat", "/proc/1/limits", seconds=7).output, r"Max cpu time +7 ")

    def test_nothing_becomes_code_that_no_compiler_has_made(self):
        self.assertEqual(Sandbox().run(["python3", "-c", CODE]).output.split(), ["1", "30", "2", "-1"])

    def test_where_memory_runs_out_it_is_the_first_to_go(self):
        self.assertEqual(compiler("cat", "/proc/self/oom_score_adj").output, "1000\n")

    def test_the_courses_library_and_the_project_are_not_there_if_they_lie_below_usr(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("lib", "local/lib/python3.11/dist-packages"):
                (Path(folder) / name).mkdir(parents=True)
            library = Path(folder) / "lib" / "libch5_backend.so"
            module = Path(folder) / "local/lib/python3.11/dist-packages/ch5_backend.so"
            for path in (library, module):
                path.write_bytes(b"answers")
            project = Path(folder) / "src" / "app"
            with mock.patch.object(sandbox, "ROOT", project):
                self.assertEqual(set(sandbox.installed(folder)), {str(library), str(module), str(project)})
        with mock.patch.object(sandbox, "installed", return_value=("/usr/bin/true", "/usr/share")):
            outcome = shell("cat /usr/bin/true; ls /usr/share; head -c 9M /dev/zero > /usr/share/x")
        self.assertRegex(outcome.output, "^cat: .*Permission denied\nhead: .*No space left on device\n$")

    def test_what_the_parent_has_open_is_not_inherited(self):
        with tempfile.TemporaryFile() as secret:
            os.set_inheritable(secret.fileno(), True)
            with tempfile.TemporaryDirectory() as folder:
                command = Sandbox(writable={"/out": folder}).wrap(["ls", "/proc/self/fd"])
                found = subprocess.run(command, pass_fds=(secret.fileno(),), capture_output=True, text=True, check=False).stdout
        self.assertEqual(found.split(), ["0", "1", "2", "3"])  # 3 is the folder that ls reads

    def test_an_endless_loop_ends_by_its_processor_time(self):
        outcome = shell("while :; do :; done", seconds=1)
        self.assertFalse(outcome.in_time)
        self.assertLess(outcome.cpu_seconds, 3.0)

    def test_who_ends_in_words_when_its_processor_time_is_over_is_out_of_time(self):
        outcome = shell("trap 'echo error: no such file; exit 1' XCPU; while :; do :; done", seconds=1)
        self.assertEqual((outcome.exit_code, outcome.output, outcome.in_time), (1, "error: no such file\n", False))

    def test_a_sleeper_ends_by_the_wall_clock_even_if_it_ignores_signals(self):
        begin = time.monotonic()
        outcome = shell("trap '' TERM INT HUP XCPU; while :; do sleep 1; done", wall_seconds=1.0)
        self.assertFalse(outcome.in_time)
        self.assertLess(time.monotonic() - begin, 5.0)

    def test_a_fork_bomb_finds_its_limit(self):
        outcome = shell("f() { f | f & }; f; sleep 1; echo survived", processes=12, wall_seconds=10.0)
        self.assertIn("Cannot fork", outcome.output)

    def test_nothing_outlives_it(self):
        mark = f"4{os.getpid()}.5"  # seconds that nobody else sleeps
        shell(f"sleep {mark} & setsid sleep {mark} & (setsid sleep {mark} &) & exit 0")
        left = subprocess.run(["pgrep", "-f", f"sleep {mark}"], capture_output=True, text=True, check=False).stdout
        self.assertEqual(left, "")

    def test_memory_files_and_words_have_limits(self):
        self.assertIn("MemoryError", shell("python3 -c 'x = bytearray(3 << 30)'").output)
        flood = shell("yes", file_size=8 * MIB, output=1000)
        self.assertEqual((len(flood.output), flood.exit_code < 0), (1000, True))
        full = compiler("sh", "-c", "head -c 100M /dev/zero > /tmp/a; head -c 100M /dev/zero > /tmp/b; ls -s /tmp", file_size=16 * MIB)
        self.assertLess(sum(int(word) for word in full.output.split() if word.isdigit()), 70_000)
        elsewhere = shell("for place in / /dev /dev/shm /out /tmp; do head -c 1M /dev/zero > $place/x && echo written; done")
        self.assertNotIn("written", elsewhere.output)

    def test_a_hundred_runs_leave_no_process_and_no_descriptor(self):
        def count():
            return len(os.listdir("/proc/self/fd"))
        shell("true")
        before = count()
        for _ in range(100):
            self.assertEqual(shell("echo x").output, "x\n")
        self.assertEqual(count(), before)
        self.assertEqual(subprocess.run(["pgrep", "-P", str(os.getpid())], capture_output=True, check=False).stdout, b"")


class Preflight(unittest.TestCase):
    def test_without_bubblewrap_it_says_so_and_runs_nothing(self):
        with mock.patch.object(sandbox.shutil, "which", return_value=None):
            with self.assertRaisesRegex(CourseError, "bwrap is missing .*Nothing was run"):
                sandbox.preflight()

    @unittest.skipIf(WHY_NOT, WHY_NOT)
    def test_where_it_does_not_hold_it_says_so(self):
        with mock.patch.object(Sandbox, "wrap", lambda self, command: command):
            with self.assertRaisesRegex(CourseError, "cannot make one here"):
                sandbox.preflight()
