"""Every command as a newcomer calls it: python3 -m tests.newcomer [--folder DIR] [--whole] [CONDITION…]

The project is unpacked without .git and without ../shared into a folder whose name has a blank and Chinese letters, and
belongs to a user who has neither an account nor sudo (where this runs as root; else to who runs it). It is built once; then
all commands run in each condition, one by one and at last in all at once. That last time ./course test runs whole; in the
others it runs what a condition can touch. Prints a table of exit codes; 0 if each is the expected one.

  --folder DIR   where to unpack and build; is kept, so that a second run builds only what has changed
  --whole        the whole ./course test in each condition
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from tests.homework.hand_in import hand_in
from tests.project import ROOT, tracked_files
from tests.terminal import on_terminal

PLACE = "新手 的 clone/第五章"
NEWCOMER = 23456  # no table of users knows this number
SYSTEM = ("/usr/local/bin", "/usr/bin", "/bin")
PLAIN = {"PATH": ":".join(SYSTEM), "HOME": "{home}", "LANG": "C.UTF-8", "TERM": "xterm", "CH5_HOMEWORK_DIR": "{homework}"}
COMMANDS = {  # the homework that is judged is the solution
    "run": ["run"],
    "plots": ["plots", "chapter"],
    "check": ["check"],
    "fly": ["fly"],
    "grade": ["grade", "{homework}/gauge_prior.cc", "--stages", "3", "--out", "{grades}"],
    "slides": ["slides", "--html"],
    "slides --check": ["slides", "--check"],
    "test": ["test", "^Conventions[.](command_line|consumer)", "^Plots[.]", "^Grading[.](follow_through|sandbox|submissions)", "^Docs[.]documents",
             "^Report[.]figure_look", "^(WindowDump|RealGraph|Flights|G2o|Bal)", "^Homework[.](Samples[.]|hints|languages)"],
}


@dataclass(frozen=True)
class Condition:
    """What differs from PLAIN."""
    variables: dict = field(default_factory=dict)  # None: unset
    closed: bool = False                           # standard input
    columns: int = 0                               # of the terminal; 0: there is none
    commands: dict = field(default_factory=lambda: COMMANDS)
    exit_code: int = 0
    words: str = ""                                # that each command must say


NO_DATA, ELSEWHERE, NO_CCACHE = {"CH5_DATA_DIR": "/nowhere/data"}, {"TMPDIR": "{temporary}"}, {"PATH": "{without ccache}"}
CONDITIONS = {
    "no data beside it": Condition(),
    "CH5_DATA_DIR names nothing": Condition(NO_DATA),
    "LANG unset": Condition({"LANG": None}),
    "LANG=C": Condition({"LANG": "C", "LC_ALL": "C"}),
    "LANG=zh_CN": Condition({"LANG": "zh_CN.UTF-8", "LC_ALL": "zh_CN.UTF-8"}),
    "HOME unset": Condition({"HOME": None}),
    "HOME read-only": Condition({"HOME": "/usr"}),
    "TMPDIR elsewhere": Condition(ELSEWHERE),
    "input closed": Condition(closed=True),
    "60 columns": Condition(columns=60),
    "built without ccache": Condition({**NO_CCACHE, "CH5_BUILD_DIR": "{built without ccache}"}, commands={"check": ["check", "3"]}),
    "without a compiler": Condition({"PATH": "{without compiler}"}, exit_code=2, words="to install it, run as root: apt-get install g++"),
    "all at once": Condition({**NO_DATA, **ELSEWHERE, **NO_CCACHE, "LANG": "zh_CN.UTF-8", "HOME": None}, True, 60,
                             {**COMMANDS, "test": ["test"]}),
}


class Newcomer:
    """The unpacked project, and the user to whom it belongs."""

    def __init__(self, top: Path):
        self.top, self.root, self.logs = top, top / PLACE, top / "logs"
        self.places = {name: top / folder for name, folder in (
            ("home", "home"), ("homework", "作业 本"), ("temporary", "临时 文件"), ("grades", "成绩 单"), ("built without ccache", "build 2"),
            ("without ccache", "bin"), ("without compiler", "bin2"))}
        self.user = [] if os.geteuid() else ["setpriv", f"--reuid={NEWCOMER}", f"--regid={NEWCOMER}", "--clear-groups"]

    def unpack(self) -> None:
        for folder in (self.root, self.logs, *self.places.values()):
            folder.mkdir(parents=True, exist_ok=True)
        listed, paths = self.top / "unpacked", list(map(str, tracked_files()))
        for path in set(listed.read_text(encoding="utf-8").splitlines() if listed.exists() else []) - set(paths):
            (self.root / path).unlink(missing_ok=True)  # it was there the last time
        listed.write_text("\n".join(paths), encoding="utf-8")
        for path in paths:
            target = self.root / path
            if not target.is_file() or target.read_bytes() != (ROOT / path).read_bytes():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / path, target)
        hand_in(self.places["homework"])
        for name, missing in (("without ccache", r"ccache"), ("without compiler", r"ccache|([a-z]+\+\+|gcc|cc|clang)(-.*)?")):
            for folder in map(Path, SYSTEM):
                for tool in folder.iterdir() if folder.is_dir() else ():
                    link = self.places[name] / tool.name
                    if not re.fullmatch(missing, tool.name) and not link.is_symlink():
                        link.symlink_to(tool)

    def build(self) -> int:
        """With the compiler cache of who runs this; then all is the newcomer's."""
        done = subprocess.run([self.root / "course", "test", "--", "-N"], env={**os.environ, "CH5_HOMEWORK_DIR": str(self.places["homework"])},
                              stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        if self.user:
            self.top.chmod(0o755)
            subprocess.run(["chown", "-hR", f"{NEWCOMER}:{NEWCOMER}", *self.top.iterdir()], check=True)
        return done.returncode

    def filled(self, word: str) -> str:
        return re.sub(r"\{([\w ]+)\}", lambda found: str(self.places[found[1]]), word)

    def call(self, words: list, condition: Condition, log: Path) -> int:
        """The exit code of ./course, whose words go into the log."""
        command = [*self.user, str(self.root / "course"), *map(self.filled, words)]
        if condition.closed:
            command = ["sh", "-c", 'exec "$@" <&-', "sh", *command]
        environment = {name: self.filled(word) for name, word in {**PLAIN, **condition.variables}.items() if word is not None}
        with open(log, "wb") as said:
            options = {"cwd": self.root, "env": environment}
            if condition.columns:
                return in_a_terminal(command, condition.columns, said, **options)
            return subprocess.run(command, stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT, **options).returncode


def in_a_terminal(command: list, columns: int, said, **options) -> int:
    """Runs it in a terminal of so many columns; 99 if a living line did not fit, which would leave its rest behind."""
    code, text = on_terminal(command, columns, **options)
    said.write(text.encode())
    too_wide = [line for line in text.split("\r\033[K") if "\n" not in line and len(line) >= columns]
    return code or 99 * bool(too_wide)


def walk(newcomer: Newcomer, conditions: dict, whole: bool) -> tuple:
    """{condition: {command: exit code}}, and whether each is as it should be."""
    codes, good = {}, True
    for name, condition in conditions.items():
        codes[name] = {}
        for command, words in condition.commands.items():
            log = newcomer.logs / f"{name}, {command}.log".replace("/", "-")
            begin = time.monotonic()
            code = codes[name][command] = newcomer.call(["test"] if whole and command == "test" else words, condition, log)
            right = code == condition.exit_code and condition.words in log.read_text(encoding="utf-8", errors="replace")
            good &= right
            print(f"{name}: ./course {command}: exit {code} after {time.monotonic() - begin:.0f} s"
                  f"{'' if right else f', which is wrong; see {log}'}", flush=True)
    return codes, good


def table(codes: dict) -> str:
    width = max(map(len, codes))
    lines = [" " * width + "".join(f"  {command}" for command in COMMANDS)]
    for name, of in codes.items():
        lines.append(name.ljust(width) + "".join(f"  {of.get(command, '-'):>{len(command)}}" for command in COMMANDS))
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python3 -m tests.newcomer", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--whole", action="store_true")
    parser.add_argument("conditions", nargs="*", metavar="CONDITION", choices=[[], *CONDITIONS], help="; ".join(CONDITIONS))
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        newcomer = Newcomer((given.folder or Path(temporary)).resolve())
        newcomer.unpack()
        if newcomer.build():
            return 1
        codes, good = walk(newcomer, {name: CONDITIONS[name] for name in given.conditions or CONDITIONS}, given.whole)
    print(table(codes))
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
