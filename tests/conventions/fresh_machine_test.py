"""./course on machines that lack something, played with a PATH that holds only what such a machine has."""

import os
import re
import shlex
import shutil

from tests.folder import FolderTest
from tests.project import ROOT, run

PLAIN_TOOLS = ("sh", "dirname", "sed", "cat", "mktemp", "grep", "sort", "head", "rm", "ls", "env", "touch", "chmod")
MISSING = "g++ cmake ninja-build ccache"  # what `run` needs and this PATH lacks
COMMANDS = ("g++", "cmake", "ninja", "ccache")
WORK, FAILURE = ("run", "--out", "/dev/null/out"), "cannot write into /dev/null/out"  # what fails only once the work begins


def quoted(path) -> str:
    return shlex.quote(str(path))


class FreshMachine(FolderTest):
    def setUp(self):
        super().setUp()
        self.bin, self.log = self.folder / "bin", self.folder / "calls"
        self.bin.mkdir()
        for tool in PLAIN_TOOLS:
            (self.bin / tool).symlink_to(shutil.which(tool))
        for needed in ("/usr/include/eigen3/Eigen/Core", "/usr/include/gtest/gtest.h",
                       "/usr/lib/python3/dist-packages/matplotlib"):
            if not os.path.exists(needed):
                self.skipTest(f"{needed} is not where Debian has it")

    def tool(self, name: str, script: str) -> None:
        path = self.bin / name
        path.write_text(f"#!/bin/sh\n{script}\n")
        path.chmod(0o755)

    def apt(self, script: str) -> None:
        self.tool("apt-get", f'echo "apt-get $*" >> {quoted(self.log)}\n{script}')

    def user(self, number: int) -> None:
        self.tool("id", f"echo {number}")

    def course(self, *words, **variables):
        environment = {"PATH": str(self.bin), "TMPDIR": self.folder, "CH5_BUILD_DIR": self.folder / "build", **variables}
        return run(ROOT / "course", *words, env=environment)

    def calls(self) -> str:
        return self.log.read_text() if self.log.exists() else ""

    def refuses(self, *words):
        done = self.course(*WORK)
        self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertNotIn(FAILURE, done.stderr, "it must stop before the work begins")

    def installing(self) -> str:
        """A script that installs: the commands are there afterwards."""
        made = " ".join(quoted(self.bin / command) for command in COMMANDS)
        return f'case "$*" in *" install "*) touch {made} && chmod +x {made} ;; esac'

    def test_without_apt_it_names_the_packages(self):
        self.refuses("no apt-get", MISSING)

    def test_the_compiler_that_cxx_names_is_installed(self):
        for compiler, package in (("clang++-14", "clang-14"), ("clang++", "clang"), ("g++-11", "g++-11"),
                                  ("/opt/g++-13 -m64", "g++-13")):
            self.assertIn(f"Debian calls {package} cmake", self.course(*WORK, CXX=compiler).stderr)

    def test_without_root_and_sudo_it_says_what_to_run_as_root(self):
        self.user(1000)
        self.apt("exit 1")
        self.refuses(f"run as root: apt-get install {MISSING}")
        self.assertEqual(self.calls(), "")

    def test_a_failing_apt_is_quoted(self):
        self.user(0)
        self.apt('echo "E: Unable to locate package g++"; exit 100')
        self.refuses("could not install", "E: Unable to locate package g++", "course-apt.")

    def test_an_apt_that_installs_nothing_is_noticed(self):
        self.user(0)
        self.apt("exit 0")
        self.refuses("still missing after the installation", MISSING)

    def test_ccache_alone_stops_nothing(self):
        self.user(1000)
        for command in ("g++", "cmake", "ninja"):
            self.tool(command, "exit 1")
        done = self.course(*WORK)
        self.assertIn("please install what Debian calls ccache", done.stderr)
        self.assertIn("going on without ccache", done.stderr)
        self.assertIn(FAILURE, done.stderr)
        (self.folder / "build").mkdir()
        (self.folder / "build/CMakeCache.txt").touch()
        self.assertNotIn("ccache", self.course(*WORK).stderr, "said once, where it would have helped")

    def test_root_installs_and_goes_on(self):
        self.user(0)
        self.apt(self.installing())
        done = self.course(*WORK)
        self.assertIn(f"installing {MISSING} with apt-get (./course run needs it)", done.stderr)
        self.assertIn(FAILURE, done.stderr)
        self.assertIn(f"install --no-install-recommends {MISSING}", self.calls())

    def test_stale_package_lists_are_updated(self):
        self.user(0)
        self.apt(f'grep -q update {quoted(self.log)} || exit 100\n{self.installing()}')
        self.assertIn(FAILURE, self.course(*WORK).stderr)

    def test_a_user_installs_with_sudo(self):
        self.user(1000)
        self.tool("sudo", f'echo "sudo $*" >> {quoted(self.log)}\n[ "$1" = -n ] && shift\nexec "$@"')
        self.tool("true", "exit 0")
        self.apt(self.installing())
        self.assertIn(FAILURE, self.course(*WORK).stderr)
        self.assertIn("sudo env DEBIAN_FRONTEND=noninteractive apt-get", self.calls())

    def test_whatever_a_command_needs_is_there_before_tests_are_configured(self):
        needs = re.findall(r"^(need_for_\w+)\(\) {\n(.*?)^}", (ROOT / "course").read_text(encoding="utf-8"), re.M | re.S)
        extras = (ROOT / "course").read_text(encoding="utf-8").partition("list_missing_extras() {")[2].partition("\n}")[0]
        called = re.findall(r"need_for_\w+", extras)
        called += [name for caller, body in needs if caller in called for name in re.findall(r"need_for_\w+", body)]
        self.assertEqual({name for name, _ in needs} - set(called), {"need_for_lab"}, "its tests run by night, which installs it")

    def test_a_pattern_of_several_tests_is_not_taken_for_one_suite(self):
        self.user(1000)
        for tool in COMMANDS:
            self.tool(tool, "exit 1")
        for word, asks in (("^Estimator", False), ("Estimator|^Grading", True), ("^Estimator|^Grading", True), ("Estimator", True)):
            self.assertEqual("some tests need it" in self.course("test", word).stderr, asks, word)

    def test_fonts_that_have_been_installed_since_are_looked_for(self):
        (self.bin / "find").symlink_to(shutil.which("find"))
        fonts = self.folder / "fontlist-v330.json"
        for time, remembered in (((0, 0), False), (None, True)):
            fonts.touch()
            os.utime(fonts, time)
            self.course("hint", "1.1", HOME=self.folder, MPLCONFIGDIR=self.folder)
            self.assertEqual(fonts.exists(), remembered)

    def test_help_and_wrong_words_install_nothing(self):
        self.user(0)
        self.apt(self.installing())
        for words in (["help"], ["run", "--help"]):
            self.assertEqual(self.course(*words).returncode, 0)
        for words in (["frobnicate"], ["run", "--frobnicate"], ["lab", "frobnicate"], ["run", "--threads"], ["track"],
                      ["track", "/nowhere"], ["grade"], ["bench", "--", "nosuch"], ["plots", "nosuch"], ["check", "9.9"],
                      ["run", "/nowhere"], ["run", "--window", "9"], ["fly", "/nowhere"], ["grade", "/nowhere"], ["pack", "nosuch"],
                      ["slides", "nosuch"], ["test", "no" + "test"]):
            done = self.course(*words)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertNotIn("installing", done.stderr)
        self.assertEqual(self.calls(), "")
