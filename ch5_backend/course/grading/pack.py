"""./course pack: what students get, and what other platforms grade with."""

import os
import zipfile
from pathlib import Path

from ch5_backend.figures.atomic_write import atomic_write, write_whole

from ..base.cmake_build import ROOT
from ..base.errors import CourseError
from .rubric import read_rubric
from .student import listed_by_git, pack_student, write_tar

PACKED = {"student": "chapter5.tar.gz", "gradescope": "gradescope.zip", "classroom": "classroom.yml",  # its usual name
          "classroom-grading": "grade.yml", "container": "grader.tar.gz"}
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
./course grade --list "$out/list" --out "$out" --jobs 1 --whole --language LANGUAGE 2>"$out/words"
cat "$out/words"
if [ -e "$out/submission/results.json" ]; then
  cp "$out/submission/results.json" "$here/results/results.json"
else  # no mark is better than a wrong one
  echo '{"output": "The grader itself has failed; please tell your instructor.", "tests": []}' > "$here/results/results.json"
fi
rm -rf "$out"
"""

# For Docker's default rights: without namespaces the sandbox has its second way, which needs the user root here.
CONTAINER = """\
FROM debian:12
COPY . /course
RUN /course/course grade --prepare
WORKDIR /class
ENTRYPOINT ["/course/course", "grade", "--language", "LANGUAGE"]
"""

# The students' repository has no key, and nothing but the students' archive: what its jobs may read, students may read.
CLASSROOM = """\
# GitHub Classroom: .github/workflows/classroom.yml of the assignment's repository, which holds the students' archive
# (./course pack student). It has no key and no solution: it runs the public checks, for practice. Marks are given by the
# course's own repository, with the workflow of ./course pack classroom-grading.
name: GitHub Classroom Workflow
on: [push, workflow_dispatch]
permissions: {checks: write, actions: read, contents: read}
jobs:
  run-autograding-tests:
    runs-on: ubuntu-22.04
    if: github.actor != 'github-classroom[bot]'
    steps:
      - uses: actions/checkout@v4
      - run: ./course check --language LANGUAGE || true  # builds once; each step below has its own verdict
TESTS      - uses: classroom-resources/autograding-grading-reporter@v1
        env:
RESULTS        with: {runners: "RUNNERS"}
"""

STAGE_TEST = """\
      - id: stage-ID
        uses: classroom-resources/autograding-command-grader@v1
        with: {test-name: "Stage STAGE", command: ./course check STAGE, timeout: 10, max-score: POINTS}
"""

GRADING = """\
# .github/workflows/grade.yml of the course's own repository, which students cannot read. It fetches what was handed in, grades
# it in the sandbox, and keeps the marks here; nothing of it runs in a student's repository.
# Secret CLASSROOM_TOKEN: a fine-grained token that may read the organization's repositories (contents) and Classroom.
name: grade a Classroom assignment
on:
  workflow_dispatch:
    inputs: {assignment: {description: "its number, from gh classroom assignments", required: true}}
permissions: {contents: read}
jobs:
  grade:
    runs-on: ubuntu-22.04
    env: {ASSIGNMENT: "${{ inputs.assignment }}"}
    steps:
      - uses: actions/checkout@v4
      - name: fetch, with the token in this step alone
        env: {GH_TOKEN: "${{ secrets.CLASSROOM_TOKEN }}"}
        run: |
          gh extension install github/gh-classroom
          gh auth setup-git
          gh classroom clone student-repos --assignment-id "$ASSIGNMENT" --directory "$RUNNER_TEMP/handed_in"
          gh classroom assignment-grades --assignment-id "$ASSIGNMENT" --file-name "$RUNNER_TEMP/classroom.csv"
      - run: |  # a student's own workflow, hooks and settings are data here: only the homework's files are read
          find "$RUNNER_TEMP/handed_in" -mindepth 2 -maxdepth 2 -type d > "$RUNNER_TEMP/list"
          ./course grade --list "$RUNNER_TEMP/list" --out grades --language LANGUAGE
      - uses: actions/upload-artifact@v4
        if: always()
        with: {name: grades, path: grades}
"""


def refuse(what: str) -> None:
    """Raises CourseError for what cannot be packed."""
    if what not in PACKED:
        *others, last = PACKED
        raise CourseError(f"./course pack makes {', '.join(others)} or {last}, not '{what}'")


def pack(what: str, out: str, language: str) -> int:
    """Writes the archive or the workflow, whole or not at all; 0. The graders that are packed speak `language`."""
    refuse(what)
    path = Path(out or PACKED[what])
    if what == "gradescope":
        write_zip(path, {**project_files(), "setup.sh": SETUP.encode(), "run_autograder": RUN.replace("LANGUAGE", language).encode()})
    elif what == "container":
        with atomic_write(path) as partial, open(partial, "wb") as file:
            write_tar(file, {**project_files(), "Dockerfile": CONTAINER.replace("LANGUAGE", language).encode()})
    elif what == "student":
        pack_student(path)
    else:
        write_whole(path, (classroom() if what == "classroom" else GRADING).replace("LANGUAGE", language))
    print(f"{path}: {-(-path.stat().st_size >> 10)} KB")
    return 0


def classroom() -> str:
    """A step for each stage that has points, by the rubric; the reporter adds their points for Classroom."""
    points = {stage: sum(checks.values()) for stage, checks in read_rubric().items()}
    stages = {stage: (stage.replace(".", "-"), n) for stage, n in points.items() if n}
    tests = "".join(STAGE_TEST.replace("STAGE", stage).replace("ID", own).replace("POINTS", f"{n:g}") for stage, (own, n) in stages.items())
    results = "".join(f'          STAGE-{own}_RESULTS: "${{{{ steps.stage-{own}.outputs.result }}}}"\n' for own, _ in stages.values())
    return CLASSROOM.replace("TESTS", tests).replace("RUNNERS", ",".join(f"stage-{own}" for own, _ in stages.values())).replace("RESULTS        with", results + "        with")


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
