"""Whose time has run out: a program's own, which is its fault, or the machine's, which is no mark."""

import os
import signal
import subprocess
import threading
import time
import unittest
from contextlib import suppress
from pathlib import Path
from unittest import mock

from tests.folder import FolderTest
from ch5_backend.course.grading import job
from ch5_backend.course.grading.sandbox import Limits, Outcome, Unguarded
from ch5_backend.course.grading.toolchain import Clock, Infrastructure, Toolchain
from ch5_backend.course.grading.watch import Watch, memory_of, processes_of, status_of
from ch5_backend.course.homework.diagnosis import Verdict, cause_of

SECONDS = 3.0
VFORK = "import ctypes, platform, time\nctypes.CDLL(None).syscall({'x86_64': 56}.get(platform.machine(), 220), 0x4011, 0, 0, 0, 0)\ntime.sleep(60)"
LOOP, SLEEP, THREAD = "while True: pass", "import time; time.sleep(60)", "import threading, time; threading.Thread(target=time.sleep, args=[60]).start()"


class Watched(FolderTest):
    def own(self, code: str, stopped: bool = False) -> float:
        """The share of its own time of a program that is looked at for some seconds, once it runs."""
        script = self.folder / "program.py"
        script.write_text(f"print('runs', flush=True)\n{code}")
        with subprocess.Popen(["sh", "-c", 'python3 "$0"; true', script], stdout=subprocess.PIPE, start_new_session=True) as process:
            process.stdout.readline()
            time.sleep(0.5)
            if stopped:
                os.killpg(process.pid, signal.SIGSTOP)
            with Watch(str(script)) as watch:
                time.sleep(SECONDS)
            os.killpg(process.pid, signal.SIGKILL)
        return watch.own() / watch.end

    def test_a_loop_and_a_sleeper_spend_their_own_time_and_what_is_stopped_does_not(self):
        for code in (SLEEP, THREAD, VFORK):
            self.assertGreater(self.own(code), 0.8, code)
        for code in (SLEEP, LOOP):
            self.assertLess(self.own(code, stopped=True), 0.6, code)  # a first look counts all that was spent before

    def test_what_has_ended_since_has_no_memory(self):
        with subprocess.Popen(["sleep", "60"]) as process:
            inside = {process.pid: status_of(process.pid)}
            self.assertGreater(memory_of(inside, 0), 0)
            process.kill()
        self.assertEqual(memory_of(inside, 0), 0)

    def test_the_walls_clock_blames_only_who_had_the_time(self):
        def outcome(stop: bool) -> Outcome:
            script = self.folder / "sleeper.sh"
            script.write_text("sleep 60; true")  # quick to start on a busy machine
            box = Unguarded({"/sleeper.sh": script}, limits=Limits(wall_seconds=SECONDS))
            def freeze():
                for pid in processes_of(str(script).encode()):
                    with suppress(ProcessLookupError):
                        os.kill(pid, signal.SIGSTOP)
            if stop:
                threading.Timer(0.5, freeze).start()
            return box.run(["sh", "/sleeper.sh"])
        self.assertEqual([(one.in_time, one.stalled) for one in (outcome(False), outcome(True))], [(False, False), (False, True)])


class Verdicts(unittest.TestCase):
    """Of checks, made up: three that took a second each, of which the second was not answered in time."""
    TESTS = tuple({"name": name, "time": "1s", "failures": failures} for name, failures in
                  (("a", []), ("b", [{"failure": "TIMEOUT after 1 s in x"}]), ("c", [])))

    def waited(self, owns) -> bool:
        watch = Watch("nothing")
        watch.times, watch.owns, watch.end = [0.0, 1.0, 2.0, 3.0], [0.0, *owns], 3.0
        return job.kept_waiting(Verdict("times-out", tests=self.TESTS), watch)

    def test_what_counts_is_the_time_of_the_check_that_was_not_answered(self):
        self.assertFalse(self.waited((0.1, 1.1, 1.2)))
        self.assertTrue(self.waited((1.0, 1.1, 2.1)))

    def test_it_is_tried_again_with_more_time_and_then_no_mark(self):
        limits, owns = [], [0.1, 0.9]

        def judge(_executable, _stage, limit, options, *_words, **_more):
            limits.append((limit, options[1]))
            return Verdict("times-out", {}, tests=({"name": "a", "time": "0.01s", "failures": [{"failure": "TIMEOUT"}]},))
        toolchain = mock.Mock(box=Unguarded)
        with mock.patch.object(job, "judge", judge), mock.patch.object(job.Watch, "own", lambda _self, *_: owns[len(limits) - 1] / 100.0):
            verdict = job.run_stage(toolchain, Path("worker"), {"id": "3"}, 1, Clock(100.0))
            self.assertEqual((verdict.state, [option for _, option in limits]), ("times-out", ["--time-limit=10", "--time-limit=40"]))
            owns[1], limits[:] = 0.1, []
            with self.assertRaisesRegex(Infrastructure, "a check of stage 3 did not get half of the 40 s"):
                job.run_stage(toolchain, Path("worker"), {"id": "3"}, 1, Clock(100.0))

    def test_a_limit_reads_as_what_reaches_it(self):
        cause = {"id": "judge.crash", "signal": {"quoted": signal.strsignal(signal.SIGXCPU)}, "where": ""}
        verdict = job.out_of_limits(Verdict("crashes", {"cause": cause, "place": "problem.cc:7"}), "")
        self.assertEqual((verdict.state, cause_of(verdict.diagnosis), verdict.diagnosis["place"]), ("times-out", "judge.does_not_end", "problem.cc:7"))
        killed = Verdict("crashes", {"cause": {**cause, "signal": {"quoted": "Killed"}}})
        causes = [(found.state, cause_of(found.diagnosis)) for found in (job.out_of_limits(killed, limit) for limit in ("", "seconds", "memory"))]
        self.assertEqual(causes, [("crashes", "judge.crash"), ("times-out", "judge.does_not_end"), ("crashes", "judge.takes_too_much")])


class Compilers(FolderTest):
    def compile(self, clock: Clock, *outcomes):
        runs = iter(outcomes)
        toolchain = mock.Mock(compilers=[["clang"], ["gcc"]], archives=self.folder, object=Path("o"), include=Path("/include"),
                              _run=lambda *words: (self.limits.append(words[-1]), next(runs))[1])
        toolchain._verdict = lambda *words: Toolchain._verdict(toolchain, *words)
        self.limits = []
        return Toolchain.compile(toolchain, "problem.cc", b"x", self.folder, clock)

    def test_all_compilations_of_a_submission_have_one_budget(self):
        clock = Clock()
        bomb = Outcome(-24, "", False, 29.0, 100.0)
        for _ in range(3):
            built = self.compile(clock, bomb)
        self.assertEqual((built.verdict.state, self.limits[0].seconds, clock.compiler), ("does-not-compile", 2, 60.0 - 3 * 29.0))
        built = self.compile(clock)
        self.assertEqual((cause_of(built.verdict.diagnosis), self.limits), ("compiler.took_too_long_in_all", []))

    def test_a_compiler_that_was_kept_waiting_is_no_verdict(self):
        with self.assertRaisesRegex(Infrastructure, "The same command judges this submission again"):
            self.compile(Clock(), Outcome(-9, "", False, 2.0, 100.0, stalled=True))
        with self.assertRaisesRegex(Infrastructure, "in 120 s"):
            self.compile(Clock(wall=-1.0))
