"""What comes from npm, installed into build/slides when the lock file changes: Marp, MathJax, axe."""

import fcntl
import shutil
import sys
from pathlib import Path

from .browser import BuildError, run

HERE = Path(__file__).resolve().parent
WORK = HERE.parent / "build" / "slides"


def installed():
    """The folder node_modules, after an installation if need be; a second process waits for the first one's."""
    npm = shutil.which("npm")
    if not npm:
        raise BuildError("Marp, MathJax and axe are installed with npm, which is missing; Debian: apt-get install npm")
    lock = (HERE / "package-lock.json").read_text(encoding="utf-8")
    stamp, modules = WORK / "installed.lock", WORK / "node_modules"
    WORK.mkdir(parents=True, exist_ok=True)
    with open(WORK / ".npm.lock", "w", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        if not (modules.exists() and stamp.exists() and stamp.read_text(encoding="utf-8") == lock):
            for name in ("package.json", "package-lock.json"):
                shutil.copy(HERE / name, WORK / name)
            print("installing Marp, MathJax and axe with npm into build/slides …", file=sys.stderr)
            run([npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund"], "npm could not install them", cwd=WORK)
            stamp.write_text(lock, encoding="utf-8")
    return modules
