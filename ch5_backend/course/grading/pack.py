"""./course pack: what students get, and what other platforms grade with."""

import os
import zipfile
from pathlib import Path

from ch5_backend.figures.atomic_write import atomic_write, write_whole

from ..base.cmake_build import ROOT
from ..base.errors import CourseError
from .student import listed_by_git, pack_student

LONG_AGO = (1980, 1, 1, 0, 0, 0)  # the same files give the same bytes

SETUP = """\
#!/usr/bin/env bash
# Gradescope runs this once, for the image: installs what is needed and builds what does not depend on a submission.
set -e
cd "${AUTOGRADER:-/autograder}/source"
./course grade --prepare
"""

RUN = """\
#!/usr/bin/env bash
# Gradescope runs this for each submission.
here=${AUTOGRADER:-/autograder}
out=$(mktemp -d)
cd "$here/source"
echo "$here/submission" >"$out/list"  # a submission, whatever it looks like inside
./course grade --list "$out/list" --out "$out" --jobs 1 --language LANGUAGE 2>"$out/words"
cat "$out/words"
if [ -e "$out/submission/results.json" ]; then
  cp "$out/submission/results.json" "$here/results/results.json"
else  # no mark is better than a wrong one
  echo '{"output": "The grader itself has failed; please tell your instructor.", "tests": []}' > "$here/results/results.json"
fi
rm -rf "$out"
"""

CLASSROOM = """\
# GitHub Classroom: .github/workflows/classroom.yml of the assignment's repository, which has the files of ch5_homework/.
# COURSE is the repository of the course, which students need not see; its key is the secret COURSE_KEY.
name: grade
on: [push, workflow_dispatch]
jobs:
  grade:
    runs-on: ubuntu-22.04
    env: {COURSE: owner/course}
    steps:
      - uses: actions/checkout@v4
        with: {path: submission}
      - uses: actions/checkout@v4
        with: {repository: "${{ env.COURSE }}", ssh-key: "${{ secrets.COURSE_KEY }}", path: course}
      - run: ./course/course grade submission --out grades --language LANGUAGE
      - run: cat grades/submission/autolab.json >> "$GITHUB_STEP_SUMMARY"
        if: always()
      - uses: actions/upload-artifact@v4
        if: always()
        with: {name: feedback, path: grades/submission}
"""


def refuse(what: str) -> None:
    """Raises CourseError for what cannot be packed."""
    if what not in ("student", "gradescope", "classroom"):
        raise CourseError(f"./course pack makes student, gradescope or classroom, not '{what}'")


def pack(what: str, out: str, language: str) -> int:
    """Writes the archive or the workflow, whole or not at all; 0. The graders that are packed speak `language`."""
    refuse(what)
    if what == "gradescope":
        path = Path(out or "gradescope.zip")
        write_zip(path, {**project_files(), "setup.sh": SETUP.encode(), "run_autograder": RUN.replace("LANGUAGE", language).encode()})
    elif what == "classroom":
        path = Path(out or "classroom.yml")
        write_whole(path, CLASSROOM.replace("LANGUAGE", language))
    else:
        path = Path(out or "chapter5.tar.gz")
        pack_student(path)
    print(f"{path}: {-(-path.stat().st_size >> 10)} KB")
    return 0


def project_files() -> dict:
    """{name: bytes} of what version control knows or would; without it, of all but what is built."""
    names = listed_by_git("--cached", "--others", "--exclude-standard")
    if names is None:
        made = {"build", "out", "node_modules", "__pycache__", ".cache", ".git"}
        names = [str(path.relative_to(ROOT)) for path in ROOT.rglob("*") if not made & set(path.relative_to(ROOT).parts)]
    return {name: (ROOT / name).read_bytes() for name in names if (ROOT / name).is_file()}


def write_zip(path: Path, files: dict) -> None:
    with atomic_write(path) as partial, zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            info = zipfile.ZipInfo(name, LONG_AGO)
            program = files[name].startswith(b"#!") or os.access(ROOT / name, os.X_OK)
            info.external_attr, info.compress_type = (0o100755 if program else 0o100644) << 16, zipfile.ZIP_DEFLATED
            archive.writestr(info, files[name])
