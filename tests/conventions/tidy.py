"""clang-tidy, with .clang-tidy's rules: with the environment variable CH5_TIDY_ALL over all sources, otherwise over changed ones.

Most of its time goes into Eigen and the standard library, so sources are handed over in groups that include them once.
What passed is not looked at again: build/…/tidy/ remembers sources by their content and that of all they include.
"""

import hashlib
import os
import re
import shutil
import subprocess
import unittest
from pathlib import Path

from tests.conventions.functions import declarations, function_name
from tests.conventions.project import BUILD, ROOT, tracked_files

PARTS = 6         # tests of about the same length, to be run side by side
GROUP = 16        # sources that clang-tidy sees at once, a matter of memory: 1.3 GB
EIGEN = next((path for path in ("/usr/include/eigen3", "/usr/local/include/eigen3", "/opt/homebrew/include/eigen3")
              if os.path.isdir(path)), "/usr/include/eigen3")
FLAGS = ["-std=c++17", "-DEIGEN_MAX_ALIGN_BYTES=32", '-DCH5_DATA_DIR=""', f"-I{ROOT}", "-isystem", EIGEN,
         "-Wno-everything"]
# Need what may not be installed, or include other .cc files.
ELSEWHERE = re.compile(r"^ch5_homework/|^tests/conventions/|^tests/bench/.*ceres|cholmod|^tests/fuzz/|^ch5_homework/judge/linked_")


def read(path) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def closure(path: str, known: dict) -> set:
    """The file and all files of the project that it includes, directly or not; `known` remembers."""
    if path not in known:
        known[path] = {path}
        included = [name for name in re.findall(r'^#include "([^"]+)"', read(path), re.MULTILINE)
                    if (ROOT / name).is_file()]
        known[path] = {path}.union(*(closure(name, known) for name in included))
    return known[path]


def fingerprint(paths: set, version: str) -> str:
    texts = [version, read(".clang-tidy"), " ".join(FLAGS), *(name + read(name) for name in sorted(paths))]
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()


def local_names(path: str) -> set:
    """What a source declares at namespace level, and what may therefore stand in one source of a group only."""
    names = {Path(path).name}
    for part in declarations(read(path)):
        if part.in_class or part.kind == "namespace":
            continue
        if part.kind == "function":
            names.add(function_name(part.head))
        elif part.kind == "type":
            names |= set(re.findall(r"\b(?:class|struct|enum)\s+(?:class\s+)?(\w+)", part.head))
        else:
            alias = re.match(r"\s*using\s+(\w+)\s*=", part.head)
            names |= {alias[1]} if alias else set(re.findall(r"(\w+)\s*$", re.split(r"[={\[(]", part.head)[0]))
    return names | set(re.findall(r"^ *# *define (\w+)", read(path), re.MULTILINE))


def groups(paths: list) -> list:
    """The sources in groups without common names."""
    found = []
    for path in paths:
        names = local_names(path)
        for members, taken in found:
            if len(members) < GROUP and not names & taken:
                members.append(path)
                taken |= names
                break
        else:
            found.append(([path], names))
    return [members for members, _ in found]


def git(*words) -> list:
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True)
    return done.stdout.splitlines() if done.returncode == 0 else []


def changed(sources: list, known: dict) -> list:
    """Sources that differ from the main branch, and for a changed header the first source that includes it."""
    base = next((line for branch in ("origin/main", "main") for line in git("merge-base", "HEAD", branch)), "HEAD")
    names = set(git("diff", "--name-only", base) + git("ls-files", "--others", "--exclude-standard"))
    chosen = names & set(sources)
    for header in sorted(name for name in names if name.endswith(".h")):
        users = [path for path in sources if header in closure(path, known)]
        if users and not chosen & set(users):
            chosen.add(users[0])
    return sorted(chosen)


def tidy(paths: list) -> str:
    """What clang-tidy has to say about these sources, each message once; nothing if all is well."""
    folder = BUILD / "tidy"
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / (hashlib.sha256(" ".join(paths).encode()).hexdigest()[:12] + ".cc")
    source.write_text("".join(f'#include "{path}"\n' for path in paths), encoding="utf-8")
    done = subprocess.run(["clang-tidy", "--quiet", f"--config-file={ROOT / '.clang-tidy'}", str(source), "--", *FLAGS],
                          cwd=ROOT, capture_output=True, text=True)
    if done.returncode == 0:
        return ""
    if len(paths) > 1 and "[clang-diagnostic-error]" in done.stdout:  # they do not go together after all
        half = len(paths) // 2
        return tidy(paths[:half]) + tidy(paths[half:])
    return done.stdout.replace(f"{ROOT}{os.sep}", "") or done.stderr


class Tidy(unittest.TestCase):
    def part(self, number: int):
        if not shutil.which("clang-tidy"):
            self.skipTest("clang-tidy is not installed")
        known = {}
        sources = [str(path) for path in tracked_files(".cc") if not ELSEWHERE.search(str(path))]
        if not os.environ.get("CH5_TIDY_ALL"):
            sources = changed(sources, known)
        version = subprocess.run(["clang-tidy", "--version"], capture_output=True, text=True).stdout
        marks = {path: BUILD / "tidy" / fingerprint(closure(path, known), version)
                 for path in sources[number * len(sources) // PARTS:(number + 1) * len(sources) // PARTS]}
        waiting = [path for path, mark in marks.items() if not mark.exists()]
        faults = ""
        for group in groups(waiting):
            if words := tidy(group):
                faults += words
                continue
            for path in group:
                marks[path].touch()
        self.assertEqual(faults, "", "\n" + faults)

    def test_part_1(self):
        self.part(0)

    def test_part_2(self):
        self.part(1)

    def test_part_3(self):
        self.part(2)

    def test_part_4(self):
        self.part(3)

    def test_part_5(self):
        self.part(4)

    def test_part_6(self):
        self.part(5)


class Grouping(unittest.TestCase):
    def test_sources_with_a_name_in_common_do_not_meet(self):
        all_sources = [str(path) for path in tracked_files(".cc") if not ELSEWHERE.search(str(path))]
        found = groups(all_sources)
        self.assertEqual(sorted(sum(found, [])), sorted(all_sources))
        for members in found:
            self.assertLessEqual(sum(1 for path in members if "int main(" in read(path)), 1, members)

    def test_a_fault_is_found(self):
        if not shutil.which("clang-tidy"):
            self.skipTest("clang-tidy is not installed")
        bad = BUILD / "tidy" / "tests" / "bad.cc"  # below a folder whose name the header filter knows
        bad.parent.mkdir(parents=True, exist_ok=True)
        bad.write_text("struct A { virtual int F(); };\nstruct B : A { int F(); };\nint* null_pointer = 0;\n"
                       "int camel() { return 1; }\n", encoding="utf-8")
        words = tidy([str(bad)])
        for check in ("modernize-use-override", "modernize-use-nullptr", "readability-identifier-naming"):
            self.assertIn(check, words)
