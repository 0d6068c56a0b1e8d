"""Compiles a student's file so that its finished functions can stand beside the solutions: own_functions.py REPORT COMPILER…

A function in which a blank is still empty becomes weak: the linker takes the solution's. A file that does not compile becomes
an object without functions. REPORT, a JSON file, says which: {"errors", what the compiler printed, or ""; "unfinished",
{function: its empty TODOs}}.
"""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

THROW = re.compile(r'^\s*throw HomeworkMissing\("(\S+) (\w+)', re.MULTILINE)  # its TODO and its function


def unfinished(text: str) -> dict:
    """{function: [TODO, …]} of the blanks that still throw."""
    functions = {}
    for todo, function in THROW.findall(text):
        functions.setdefault(function, []).append(todo)
    return functions


def symbols(path: Path, functions) -> list:
    """The symbols of an object file by which these functions are called."""
    columns = [subprocess.run(["nm", "--defined-only", "--extern-only", *options, path], check=True, text=True,
                              stdout=subprocess.PIPE).stdout.splitlines() for options in ([], ["--demangle"])]
    wanted = re.compile(rf"\S+ \w (?:\w+::)*(?:{'|'.join(functions)})\(")
    return [mangled.split()[2] for mangled, readable in zip(*columns) if wanted.match(readable)]


def weaken(path: Path, functions) -> None:
    if functions and (names := symbols(path, functions)):
        subprocess.run(["objcopy", *(f"--weaken-symbol={name}" for name in names), path], check=True)


def main(report: str, *command: str) -> int:
    at = command.index("-c") + 1
    source, made = Path(command[at]), Path(command[command.index("-o") + 1])
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    functions = {}
    if done.returncode:
        subprocess.run([*command[:at], "-x", "c++", os.devnull, *command[at + 1:]], check=True)
    else:
        functions = unfinished(source.read_text(encoding="utf-8", errors="replace"))
        weaken(made, functions)
    told = {"errors": done.stdout if done.returncode else "", "unfinished": functions}
    Path(report).write_text(json.dumps(told), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
