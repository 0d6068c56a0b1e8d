"""A program in the sandbox sees nothing of the machine, takes no more than it may, and leaves nothing behind, with either engine."""

import os
import shutil
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path
from unittest import mock

from tests.project import ROOT, run
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.base.scratch import scratch
from ch5_backend.course.grading import confine, engines
from ch5_backend.course.grading.engines import Namespaces, OwnUser, processes_of_user
from ch5_backend.course.grading.sandbox import MIB, Limits


def why_not(engine) -> str:
    try:
        engine.preflight()
        return ""
    except CourseError as error:
        return str(error)


NO_NAMESPACES, NO_OWN_USER = why_not(Namespaces), why_not(OwnUser)


CODE = """
import ctypes, mmap
for what in ("mmap.mmap(-1, 4096, prot=7)", "open('/tmp/x', 'w')", "open('/proc/self/mem', 'r+b')",
             "ctypes.CDLL(None, use_errno=True).mprotect(ctypes.c_void_p(id(what) & ~4095), 4096, 5)"):
    try:
        print(eval(what))
    except OSError as error:
        print(error.errno)
"""

# Each should fail; what does not is printed. Words: a file of the grader that all may write, and the grader's process.
ESCAPES = """
import ctypes, fcntl, mmap, os, signal, socket, sys
libc, file, grader, own = ctypes.CDLL(None, use_errno=True), sys.argv[1], sys.argv[2], os.getcwd()
libc.mmap.restype = ctypes.c_void_p
def call(number, *words):
    return libc.syscall(number, *map(ctypes.c_long, words)) >= 0
for what in ("open(file).read()", "open(file, 'w')", "os.close(os.open(file, os.O_RDONLY | os.O_TRUNC)) is None", "os.truncate(file, 1) is None",
             "os.listdir(os.path.dirname(file))", "os.link(file, own + '/linked') is None", "os.rename(file, own + '/moved') is None", "os.unlink(file) is None",
             "os.chmod(file, 0) is None", "open('/etc/passwd').read()", "os.listdir('/etc')", "os.listdir('/home')",
             *(f"open('/proc/{grader}/{one}').read(1) or 1" for one in ("environ", "mem", "cmdline", "maps")), "os.listdir(f'/proc/{grader}/fd')",
             "os.readlink(f'/proc/{grader}/cwd')", "os.kill(int(grader), 0) is None", "os.kill(int(grader), signal.SIGCONT) is None",
             "call(101, 16, int(grader), 0, 0)", "call(310, int(grader), 0, 0, 0, 0, 0)", "call(434, int(grader), 0)",
             *(f"open('{place}/escaped', 'w')" for place in (os.path.dirname(file), "/dev/shm", "/var/tmp", "/usr", "/dev", "/run/lock", "/")),
             "os.open('/dev/tty', os.O_RDWR)", "fcntl.ioctl(0, 0x5412, b'x')", "socket.socket(socket.AF_UNIX)", "socket.socket()", "socket.socketpair()",
             "call(29, 0x1234, 4096, 0o1666)", "call(319, ctypes.addressof(ctypes.create_string_buffer(b'x')), 0)", "mmap.mmap(-1, 4096)",
             "call(308, 0, 0)", "call(272, 0x10000000)", "call(165, 0, 0, 0, 0, 0)", "call(250, 0, 0, 0)", "call(321, 0, 0, 0)", "call(298, 0, 0, 0, 0, 0)",
             "call(425, 8, 0)", "call(323, 0)", "call(253)", "call(437, -100, 0, 0, 0)", "os.setuid(0) is None", "os.setgroups([0]) is None",
             "mmap.mmap(os.open('/usr/bin/true', os.O_RDONLY), 4096, flags=mmap.MAP_PRIVATE, prot=7)", "fcntl.fcntl(0, 10, signal.SIGSTOP) == 0",
             "call(222, 1, 0, ctypes.addressof(ctypes.create_string_buffer(8)))", "call(13, 17, ctypes.addressof(ctypes.create_string_buffer(64)), 0, 8)",
             "os.chroot('/usr') is None", "os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1)) is None", "os.nice(-1)"):
    try:
        if eval(what):
            print(what)
    except OSError:
        pass
"""
LINKS = """
import os, socket, sys
for what in ("os.symlink('/etc/shadow', 'made.ll')", "os.mkfifo('made.ii')", "os.mknod('node')", "os.mkdir('folder')", "os.link('/usr/bin/true', 'hard')",
             "os.mknod('pipe', 0o010644)", "os.mknod('device', 0o020666, os.makedev(1, 3))"):
    try:
        eval(what)
    except OSError:
        pass
print(sorted(os.listdir('.')))
"""
MANY = "import os, time\nfor k in range(7):\n    if os.fork() == 0: break\n"


class Inside:
    """Of both engines."""

    def shell(self, script: str, **limits):
        return self.engine(limits=Limits(**limits)).run(["sh", "-c", script])

    def compiler(self, *command, **limits):
        """With a place to write, and the list of its processes where it can be had: as a compiler runs, and not what is graded."""
        with tempfile.TemporaryDirectory() as folder:
            os.chmod(folder, 0o777)
            return self.engine(writable={"/out": folder}, limits=Limits(**limits)).run(command)

    def test_words_and_exit_code_come_out(self):
        outcome = self.shell("echo $((6 * 7)); exit 3")
        self.assertEqual((outcome.exit_code, outcome.output, outcome.in_time), (3, "42\n", True))

    def python(self, script: str, *words, writable: bool = False, **limits):
        with tempfile.TemporaryDirectory() as folder:
            os.chmod(folder, 0o777)
            return self.engine(writable={"/out": folder} if writable else {}, limits=Limits(**limits)).run(["python3", "-c", script, *words])

    def test_none_of_the_ways_out_is_open(self):
        for writable in (False, True):
            with tempfile.TemporaryDirectory() as folder, tempfile.NamedTemporaryFile(dir=folder) as file:
                file.write(b"secret")
                file.flush()
                os.chmod(folder, 0o777)
                os.chmod(file.name, 0o666)
                self.assertEqual(self.python(ESCAPES, file.name, str(os.getpid()), writable=writable).output, "")
                self.assertEqual(Path(file.name).read_bytes(), b"secret")

    def test_no_network_and_no_new_namespace(self):
        outcome = self.shell("python3 -c 'import socket; socket.socket()'; unshare -U true")
        self.assertEqual(outcome.output.count("Operation not permitted"), 2, outcome.output)

    def test_many_processes_have_the_limits_of_one(self):
        memory = self.python(MANY + "x = bytearray(60 << 20)\ntime.sleep(20)", memory=256 * MIB)
        self.assertEqual((memory.exit_code, memory.output), (-9, "\nerror: out of memory: all processes together took more than 256 MB\n"))
        begin = time.monotonic()
        loops = self.python(MANY + "while True: pass", seconds=2, wall_seconds=60)
        self.assertEqual((loops.in_time, loops.exit_code, loops.stalled), (False, -9, False))
        self.assertLess(loops.cpu_seconds, 5.0)
        self.assertLess(time.monotonic() - begin, 30.0)

    def test_what_shares_its_memory_has_it_once(self):
        wait = "try:\n    while os.wait(): pass\nexcept ChildProcessError: pass\n"  # whose first process ends has ended
        script = "x = bytearray(100 << 20)\n" + MANY + "time.sleep(1)\nprint('.', flush=True)\n" + wait
        self.assertEqual(self.python(script, memory=256 * MIB).output, ".\n" * 8)

    def test_a_flood_of_files_ends_it(self):
        for script in ("for k in range(10**6): open(str(k), 'w').close()", "for k in range(100): open(str(k), 'w').write('x' * 10**7)"):
            outcome = self.python(f"import os\nos.chdir(os.environ.get('TMPDIR', '/out'))\n{script}", writable=True, scratch=100 * MIB)
            self.assertEqual((outcome.exit_code, outcome.output), (-9, "\nerror: File size limit exceeded: all files together are more than they may be\n"))

    def test_an_endless_loop_ends_by_its_processor_time(self):
        outcome = self.shell("while :; do :; done", seconds=1)
        self.assertFalse(outcome.in_time)
        self.assertLess(outcome.cpu_seconds, 3.0)

    def test_who_ends_in_words_when_its_processor_time_is_over_is_out_of_time(self):
        outcome = self.shell("trap 'echo error: no such file; exit 1' XCPU; while :; do :; done", seconds=1)
        self.assertEqual((outcome.exit_code, outcome.output, outcome.in_time), (1, "error: no such file\n", False))

    def test_a_sleeper_ends_by_the_wall_clock_even_if_it_ignores_signals(self):
        begin = time.monotonic()
        outcome = self.shell("trap '' TERM INT HUP XCPU; while :; do sleep 1; done", wall_seconds=1.0)
        self.assertFalse(outcome.in_time)
        self.assertLess(time.monotonic() - begin, 5.0)

    def test_a_fork_bomb_finds_its_limit(self):
        outcome = self.shell("f() { f | f & }; f; sleep 1; echo survived", processes=12, wall_seconds=10.0)
        self.assertIn("Cannot fork", outcome.output)

    def test_nothing_outlives_it(self):
        mark = f"4{os.getpid()}.5"  # seconds that nobody else sleeps
        self.shell(f"sleep {mark} & setsid sleep {mark} & (setsid sleep {mark} &) & exit 0")
        left = run("pgrep", "-f", f"sleep {mark}").stdout
        self.assertEqual(left, "")

    def test_memory_files_and_words_have_limits(self):
        self.assertIn("MemoryError", self.shell("python3 -c 'x = bytearray(3 << 30)'").output)
        flood = self.shell("yes", file_size=8 * MIB, output=1000)
        self.assertEqual((len(flood.output), flood.exit_code < 0), (1000, True))
        full = self.compiler("sh", "-c", "cd ${TMPDIR:-/tmp}; yes > a; yes > b; ls -s", file_size=16 * MIB)
        self.assertLess(sum(int(word) for word in full.output.split() if word.isdigit()), 70_000)

    def test_a_hundred_runs_leave_no_process_and_no_descriptor(self):
        def count():
            return len(os.listdir("/proc/self/fd"))
        self.shell("true")
        before = count()
        for _ in range(100):
            self.assertEqual(self.shell("echo x").output, "x\n")
        self.assertEqual(count(), before)
        self.assertEqual(subprocess.run(["pgrep", "-P", str(os.getpid())], capture_output=True, check=False).stdout, b"")


@unittest.skipIf(NO_NAMESPACES, NO_NAMESPACES)
class WithNamespaces(Inside, unittest.TestCase):
    engine = Namespaces

    def test_only_the_system_and_what_is_bound_are_seen(self):
        with tempfile.TemporaryDirectory() as folder:
            os.chmod(folder, 0o755)
            (Path(folder) / "given").write_text("read me")
            box = Namespaces(read_only={"/in": folder})
            outcome = box.run(["sh", "-c", 'cat /in/given; ls /; ls "$0" /etc /home /root; echo x > /in/given', ROOT])
            self.assertEqual((Path(folder) / "given").read_text(), "read me")
        self.assertTrue(outcome.output.startswith("read mebin\ndev\nin\nlib"), outcome.output)
        self.assertEqual(outcome.output.count("No such file"), 4, outcome.output)
        self.assertIn("Read-only file system", outcome.output)

    def test_it_is_nobody_without_rights(self):
        outcome = self.compiler("sh", "-c", "id -u; grep -E 'CapEff|NoNewPrivs|Seccomp:' /proc/self/status")
        self.assertRegex(outcome.output, r"CapEff:\s+0{16}\nNoNewPrivs:\s+1\nSeccomp:\s+2")
        self.assertNotEqual(outcome.output.split()[0], "0")

    def test_other_processes_are_not_there(self):
        with subprocess.Popen(["sleep", "60"]) as other:
            outcome = self.compiler("sh", "-c", 'ls -d /proc/[0-9]* | wc -l; kill -9 "$0"', str(other.pid))
            self.assertIsNone(other.poll())
            other.kill()
        self.assertLess(int(outcome.output.split()[0]), 8)

    def test_the_first_process_inside_is_limited_too(self):  # the others may write into its memory
        self.assertRegex(self.compiler("cat", "/proc/1/limits", seconds=7).output, r"Max cpu time +7 ")

    def test_nothing_becomes_code_that_no_compiler_has_made(self):
        self.assertEqual(Namespaces().run(["python3", "-c", CODE]).output.split(), ["1", "30", "2", "-1"])

    def test_where_memory_runs_out_it_is_the_first_to_go(self):
        self.assertEqual(self.compiler("cat", "/proc/self/oom_score_adj").output, "1000\n")

    def test_the_courses_library_and_the_project_are_not_there_if_they_lie_below_usr(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("lib", "local/lib/python3.11/dist-packages"):
                (Path(folder) / name).mkdir(parents=True)
            library = Path(folder) / "lib" / "libch5_backend.so"
            module = Path(folder) / "local/lib/python3.11/dist-packages/ch5_backend.so"
            for path in (library, module):
                path.write_bytes(b"answers")
            project = Path(folder) / "src" / "app"
            with mock.patch.object(engines, "ROOT", project):
                self.assertEqual(set(engines.installed(folder)), {str(library), str(module), str(project)})
        with mock.patch.object(engines, "installed", return_value=("/usr/bin/true", "/usr/share")):
            outcome = self.shell("cat /usr/bin/true; ls /usr/share; head -c 9M /dev/zero > /usr/share/x")
        self.assertRegex(outcome.output, "^cat: .*Permission denied\nhead: .*No space left on device\n$")

    def test_what_the_parent_has_open_is_not_inherited(self):
        with tempfile.TemporaryFile() as secret:
            os.set_inheritable(secret.fileno(), True)
            with tempfile.TemporaryDirectory() as folder:
                command = Namespaces(writable={"/out": folder}).wrap(["ls", "/proc/self/fd"])
                found = run(*command, pass_fds=(secret.fileno(),)).stdout
        self.assertEqual(found.split(), ["0", "1", "2", "3"])  # 3 is the folder that ls reads


@unittest.skipIf(NO_OWN_USER, NO_OWN_USER)
class WithOwnUser(Inside, unittest.TestCase):
    engine = OwnUser

    def test_only_the_system_and_what_is_bound_can_be_read(self):
        with tempfile.TemporaryDirectory() as folder:
            os.chmod(folder, 0o777)
            (Path(folder) / "given").write_text("read me")
            outcome = OwnUser(read_only={"/in": folder}).run(["sh", "-c", 'cat "$0"; ls -d "$1"; ls "$1"; ls /etc; echo x > "$0"', "/in/given", ROOT])
            self.assertEqual(((Path(folder) / "given").read_text(), outcome.output.splitlines()[0]), ("read me", f"read me{ROOT}"))
        self.assertEqual(outcome.output.count("Permission denied"), 3, outcome.output)

    def test_all_that_it_may_leave_in_its_folder_is_files(self):
        self.assertEqual(self.python(LINKS, writable=True).output, "['node']\n")

    def test_an_early_landlock_is_as_strong(self):
        for version in ("1", "2"):
            wrap = OwnUser.wrap
            early = lambda box, command, version=version, wrap=wrap: [*wrap(box, command)[:5], f"landlock={version}", *wrap(box, command)[5:]]
            with mock.patch.object(OwnUser, "wrap", early):
                self.test_none_of_the_ways_out_is_open()
                self.test_all_that_it_may_leave_in_its_folder_is_files()

    def test_what_the_system_says_of_it(self):
        found = {}

        def look():
            time.sleep(1.0)
            for pid in processes_of_user(user):
                if Path(f"/proc/{pid}/comm").read_text() == "sleep\n":
                    found.update({name: Path(f"/proc/{pid}/{name}").read_text() for name in ("status", "limits", "oom_score_adj")})
                    found.update(fds=os.listdir(f"/proc/{pid}/fd"), environ=Path(f"/proc/{pid}/environ").read_text())
        user = OwnUser.user()
        thread = threading.Thread(target=look)
        thread.start()
        self.shell("sleep 3", seconds=7)
        thread.join()
        self.assertRegex(found["status"], rf"Uid:(\t{user}){{4}}\nGid:(\t{user}){{4}}\n(.*\n)*Groups:\t \n")
        self.assertRegex(found["status"], r"CapPrm:\s+0{16}\nCapEff:\s+0{16}\n(.*\n)*NoNewPrivs:\s+1\nSeccomp:\s+2\n")
        self.assertRegex(found["limits"], "Max cpu time +7 +8 (.*\n)*Max core file size +0 +0 (.*\n)*Max processes +16 +16 +.*\nMax open files +64 +64 ")
        self.assertEqual((found["oom_score_adj"], sorted(found["fds"])), ("1000\n", ["0", "1", "2"]))
        self.assertEqual(sorted(word.partition("=")[0] for word in found["environ"].split("\0") if word), ["HOME", "LC_ALL", "PATH", "PWD", "TMPDIR"])

    def test_two_at_once_do_not_reach_each_other(self):
        outcomes, folder = {}, Path(tempfile.mkdtemp(dir=scratch()))
        self.addCleanup(shutil.rmtree, folder)

        def victim():
            os.chown(folder, -1, OwnUser.group())
            os.chmod(folder, 0o770)
            outcomes["user"] = OwnUser.user()
            outcomes["victim"] = OwnUser(writable={"/out": folder}).run(["sh", "-c", "echo mine > $TMPDIR/file; sleep 3; cat $TMPDIR/file"])
        thread = threading.Thread(target=victim)
        thread.start()
        time.sleep(1.5)
        attack = self.shell(f"cat {folder}/file; echo x > {folder}/file; kill -9 -1; pkill -9 -u {outcomes['user']}; for pid in $(seq 1 40000); do kill -9 $pid; done 2>/dev/null")
        thread.join()
        self.assertEqual((outcomes["victim"].exit_code, outcomes["victim"].output), (0, "mine\n"))
        self.assertNotIn("mine", attack.output)
        self.assertNotEqual(outcomes["user"], OwnUser.user())

    def test_what_is_left_where_the_launcher_was_killed_is_ended(self):
        bomb = "import os, signal\nfor k in range(1, 32): k in (9, 17, 19) or signal.signal(k, signal.SIG_IGN)\nwhile True:\n    try: os.fork()\n    except OSError: pass"
        box = OwnUser(limits=Limits(processes=30))
        with subprocess.Popen(box.wrap(["python3", "-c", bomb + "\n"])) as process:
            deadline = time.monotonic() + 30.0
            while len(processes_of_user(OwnUser.user())) < 20 and time.monotonic() < deadline:
                time.sleep(0.1)
            process.kill()
        self.assertGreater(len(processes_of_user(OwnUser.user())), 3)
        self.assertEqual(self.shell("echo begins").output, "begins\n")  # and ends what was there
        self.assertEqual(processes_of_user(OwnUser.user()), [])


class Choice(unittest.TestCase):
    def test_where_neither_works_it_says_why_and_runs_nothing(self):
        with mock.patch.object(engines.shutil, "which", return_value=None), mock.patch.object(engines.os, "geteuid", return_value=1000):
            with self.assertRaisesRegex(CourseError, "bwrap is missing .*; landlock: only root .*Nothing was run"):
                engines.choose()

    @unittest.skipIf(NO_OWN_USER, NO_OWN_USER)
    def test_the_second_is_taken_where_the_first_does_not_work(self):
        with mock.patch.object(engines.shutil, "which", return_value=None):
            self.assertIs(engines.choose(), OwnUser)
            with mock.patch.object(confine, "landlock_version", return_value=0), self.assertRaisesRegex(CourseError, "no Landlock"):
                engines.choose()

    def test_where_it_does_not_hold_it_says_so(self):
        for engine, why_not, words in ((Namespaces, NO_NAMESPACES, "cannot make one here"), (OwnUser, NO_OWN_USER, "does not hold here")):
            with mock.patch.object(engine, "wrap", lambda self, command: command):
                if not why_not:
                    with self.assertRaisesRegex(CourseError, words):
                        engines.choose(engine.name)
