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


def refuse(what: str) -> None:
    """Raises CourseError for what cannot be packed."""
    if what not in PACKED:
        *others, last = PACKED
        raise CourseError(f"./course pack makes {', '.join(others)} or {last}, not '{what}'")


def pack(what: str, out: str, language: str) -> int:
    """Writes the archive or the workflow, whole or not at all; 0. The graders that are packed speak `language`."""
    refuse(what)
    path, spoken = Path(out or PACKED[what]), {"LANGUAGE": language}
    if what == "gradescope":
        write_zip(path, {**project_files(), "setup.sh": template("setup.sh", {}).encode(), "run_autograder": template("run_autograder", spoken).encode()})
    elif what == "container":
        with atomic_write(path) as partial, open(partial, "wb") as file:
            write_tar(file, {**project_files(), "Dockerfile": template("Dockerfile", spoken).encode()})
    elif what == "student":
        pack_student(path)
    else:
        write_whole(path, template(PACKED[what], spoken | (classroom() if what == "classroom" else {})))
    print(f"{path}: {-(-path.stat().st_size >> 10)} KB")
    return 0


def template(name: str, values: dict) -> str:
    """A file of packed/ with these in place of their names."""
    text = Path(__file__).with_name("packed").joinpath(name).read_text(encoding="utf-8")
    for key, value in values.items():
        text = text.replace(key, value)
    return text


def classroom() -> dict:
    """A step for each stage that has points, by the rubric; the reporter adds their points for Classroom."""
    points = {stage: sum(checks.values()) for stage, checks in read_rubric().items()}
    stages = {stage: (stage.replace(".", "-"), n) for stage, n in points.items() if n}
    return {"      # TESTS\n": "".join(template("classroom_stage.yml", {"STAGE": stage, "ID": own, "POINTS": f"{n:g}"}) for stage, (own, n) in stages.items()),
            "RUNNERS": ",".join(f"stage-{own}" for own, _ in stages.values()),
            "          # RESULTS\n": "".join(f'          STAGE-{own}_RESULTS: "${{{{ steps.stage-{own}.outputs.result }}}}"\n' for own, _ in stages.values())}


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
