"""./course is stopped, or runs twice at once: nothing goes on behind its back, and nothing is mixed up."""

import fcntl
import json
import os
import signal
import subprocess
import time
from pathlib import Path

from tests.folder import FolderTest
from tests.project import ROOT, TINY_BAL

STUCK = 'echo $$ >> "$PIDS"; sleep 300 & echo $! >> "$PIDS"; wait'  # a tool that has started another one


def is_alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


class Stopping(FolderTest):
    def setUp(self):
        super().setUp()
        self.pids, self.out = self.folder / "pids", self.folder / "out"
        self.data = self.folder / "tiny.txt"
        self.data.write_text(TINY_BAL, encoding="utf-8")
        for name in ("cmake", "ccache"):
            self.tool(f"tools/{name}", "exit 0")
        # Programs inherit that a signal is ignored, but not that it is handled.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)

    def tool(self, name: str, script: str) -> None:
        path = self.folder / name
        path.parent.mkdir(exist_ok=True, parents=True)
        path.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        path.chmod(0o755)

    def start(self, *words):
        environment = {**os.environ, "PATH": f"{self.folder / 'tools'}:{os.environ['PATH']}", "PIDS": str(self.pids),
                       "CH5_BUILD_DIR": str(self.folder / "build")}
        process = subprocess.Popen([ROOT / "course", *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=environment)
        self.addCleanup(process.kill)
        return process

    def started_by(self, process) -> list:
        """The process ids of the tool that is stuck and of the one below, once they are there."""
        for _ in range(1000):
            lines = self.pids.read_text(encoding="utf-8").split() if self.pids.exists() else []
            if len(lines) >= 2:
                return [int(line) for line in lines]
            self.assertIsNone(process.poll(), "it must not end by itself")
            time.sleep(0.01)
        self.fail("the tool was not started")

    def test_a_signal_ends_the_build_and_all_that_it_has_started(self):
        self.tool("tools/ninja", STUCK)
        for number, code in ((signal.SIGTERM, 143), (signal.SIGINT, 130), (signal.SIGHUP, 129)):
            with self.subTest(signal=number):
                self.pids.unlink(missing_ok=True)
                process = self.start("run", self.data, "--out", self.out, "--json")
                pids = self.started_by(process)
                process.send_signal(number)
                out, errors = process.communicate(timeout=20)
                self.assertEqual((process.returncode, errors), (code, "course: stopped\n"))
                self.assertEqual(json.loads(out), {"error": "stopped"})
                self.assertEqual([pid for pid in pids if is_alive(pid)], [])

    def test_a_signal_ends_a_program_and_all_that_it_has_started(self):
        self.tool("tools/ninja", "exit 0")
        self.tool("build/bin/ch5_bal", STUCK)
        process = self.start("run", self.data, "--out", self.out)
        pids = self.started_by(process)
        process.terminate()
        self.assertEqual(process.communicate(timeout=20)[1], "course: stopped\n")
        self.assertEqual(process.returncode, 143)
        self.assertEqual([pid for pid in pids if is_alive(pid)], [])

    def test_ctrl_c_shows_no_traceback_however_early(self):
        self.tool("tools/ninja", STUCK)
        for milliseconds in range(0, 200, 8):
            process = self.start("run", self.data, "--out", self.out)
            time.sleep(1e-3 * milliseconds)
            process.send_signal(signal.SIGINT)
            out, errors = process.communicate(timeout=20)
            # Before the first line of ./course, the system itself ends it; for a shell that is 130 too.
            self.assertIn(process.returncode, (130, -signal.SIGINT), (milliseconds, errors))
            self.assertIn((out, errors), (("", ""), ("", "course: stopped\n")), milliseconds)
        left = self.pids.read_text(encoding="utf-8").split() if self.pids.exists() else []
        self.assertEqual([pid for pid in left if is_alive(int(pid))], [])

    def test_the_second_run_into_a_folder_waits_and_says_so(self):
        self.tool("tools/ninja", "exit 0")
        self.tool("build/bin/ch5_bal", "exit 7")
        place = self.out / "tiny"
        place.mkdir(parents=True)
        folder = os.open(place, os.O_RDONLY)
        self.addCleanup(os.close, folder)
        fcntl.flock(folder, fcntl.LOCK_EX)
        process = self.start("run", self.data, "--out", self.out)
        self.assertEqual(process.stderr.readline(), f"waiting for another ./course that writes into {place} …\n")
        self.assertIsNone(process.poll())
        fcntl.flock(folder, fcntl.LOCK_UN)
        errors = process.communicate(timeout=20)[1]
        self.assertEqual(process.returncode, 7, errors)
