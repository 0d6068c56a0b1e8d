"""./course run: the whole chapter, or one solver run per data file."""

import re
import shlex
import sys
import time
from pathlib import Path

from ch5_backend.figures.words import PAGES

from ..base import jsonout
from ..base.cmake_build import BIN, ROOT, build_or_fail
from ..base.commands import COMMANDS
from ..base.errors import CourseError, warn
from ..base.language import sentence
from ..base.output_dir import locked_dir, made_dir, result_places
from .data import kind_of
from .programs import TRACKER, figures, run_programs, tell, tracking

WHY_NOT = {"recording": "each estimator's policy chooses its settings", "window": "the file names its own loss"}
OPENER = "open" if sys.platform == "darwin" else "xdg-open"
FOR = {name: one["for"] for name, one in COMMANDS["run"]["arguments"].items() if "for" in one}  # {option: of which data}
PROGRAMS = {"images": [TRACKER, "ch5_recording"]}  # of other kinds ch5_KIND
POLICY_FIELDS = ("policy", "ate_m", "scale_error", "yaw_error_deg", "realtime_factor", "p99_window_ms", "frames", "restarts", "rpe_m",
                 "path_m", "drift_percent", "nees_motion", "nees_windows")


def run(arguments) -> int:
    """Returns the exit code; raises CourseError for bad input before anything is built or written."""
    kinds, out = kinds_of(arguments), Path(arguments.out or "out")
    if arguments.mine:
        from .fly import fly  # NumPy, which a fresh machine lacks
        return fly(arguments, only_flights=False)
    if not arguments.data:
        return run_chapter(out, arguments)
    places = result_places(arguments.data, out)
    with made_dir(out):
        build_or_fail(sorted({program for kind in kinds.values() for program in PROGRAMS.get(kind, [f"ch5_{kind}"])}))
        results = [one for path, place in places.items() for one in (both if arguments.table else solve)(path, kinds[path], place, arguments)]
        if arguments.table:
            write_table(results, out, arguments)
    if arguments.json:
        jsonout.emit(results[0] if len(results) == 1 else {"results": results})
    return next((r["exit_code"] for r in results if "exit_code" in r), 0)


def kinds_of(arguments) -> dict:
    """{path: kind of its data}. Raises CourseError for what is no data, and for options that do not apply."""
    kinds = {path: kind_of(path) for path in arguments.data}
    for option in given_options(arguments):
        if arguments.mine:
            raise CourseError(f"{option} does not apply to --mine: each experiment chooses its settings")
        if not kinds:
            raise CourseError(f"{option} needs DATA: the chapter's own studies choose their settings")
        for path, kind in kinds.items():
            kind = solved_as(kind)
            if FOR[option] != "solver" and kind not in FOR[option].split():
                raise CourseError(f"{option} does not apply to {path}: it is for {FOR[option].replace(' ', ' and ').replace('_', ' ')}s")
            if option == "--first-estimates" and arguments.table:
                raise CourseError("--table follows each recording without and with first estimates: leave --first-estimates out")
            if (FOR[option], kind) == ("solver", "recording") or (kind, option) == ("window", "--huber"):
                raise CourseError(f"{option} does not apply to {path}: {WHY_NOT[kind]}")
    return kinds


def solved_as(kind: str) -> str:
    """Images are tracked first, and solved as a recording."""
    return "recording" if kind == "images" else kind


def run_chapter(out: Path, arguments) -> int:
    """Every study of the chapter on the course's own scenes, then the report."""
    start, report = time.monotonic(), out / PAGES[arguments.language]
    with locked_dir(out):
        build_or_fail(["ch5_chapter"])
        run_programs([[BIN / "ch5_chapter", "--out", out], figures("report", out)], arguments.json)
    from ch5_backend.figures import captions, words  # what reads tables takes half a second
    tell([captions.first_finding(out, words.Words(arguments.language)),
          sentence("run.report", path=str(report), command=f"{OPENER} {shlex.quote(str(report))}")], arguments)
    if arguments.json:
        jsonout.emit({"out": str(out), "report": str(report), "seconds": round(time.monotonic() - start, 3)})
    return 0


def both(path: str, kind: str, out: Path, arguments) -> list:
    """A recording followed without first estimates, and in the folder `full` with them."""
    results = solve(path, kind, out, arguments, ["--first-estimates", "none"])
    if "error" not in results[0]:
        tracked = str(out / "recording") if kind == "images" else path
        results += solve(tracked, "recording", out / "full", arguments, ["--first-estimates", "full"])
    return [{**result, "problem": Path(path).stem, "first_estimates": mode} for result, mode in zip(results, ("none", "full"))]


def write_table(results: list, out: Path, arguments) -> None:
    """DIR/csv/recordings.csv, and the page of it. What failed has a row without numbers."""
    from ch5_backend.figures.tables import write  # NumPy takes a moment
    head = ("recording", "policy", "first_estimates", *POLICY_FIELDS[1:])
    rows = [[result["problem"], row.get("policy"), result["first_estimates"], *map(row.get, POLICY_FIELDS[1:])]
            for result in results for row in result.get("policies", [{}])]
    with locked_dir(out):
        (out / "csv").mkdir(exist_ok=True)
        write(out / "csv" / "recordings.csv", head, rows)
        run_programs([figures("recordings", out)], arguments.json)
    tell([sentence("run.results", path=str(out / PAGES[arguments.language]))], arguments)


def solve(path: str, kind: str, out: Path, arguments, more=()) -> list:
    """[what --json tells]. Solves one file or recording with the program ch5_KIND and draws it with figures/KIND.py.

    A failure is part of the answer, so that the files after it are still solved.
    """
    options = [word for option in given_options(arguments).items() for word in option if word is not True and word != "--table"]
    tracked, file = out / "recording", f"./{path}" if path.startswith("-") else path  # a name is not an option
    try:
        with locked_dir(out):
            track = [tracking(file, tracked, arguments)] if kind == "images" else []
            kind = solved_as(kind)
            run_programs([*track, [BIN / f"ch5_{kind}", tracked if track else file, "--out", out, *options, *more], figures(kind, out)], arguments.json)
            result = read_result(kind, out, arguments.language)
    except CourseError as error:
        warn(error)
        return [{"problem": Path(path).stem, "error": str(error), "exit_code": error.exit_code}]
    tell([sentence("run.results", path=str(out))], arguments)
    return [result]


def version() -> str:
    """The library's."""
    return ".".join(re.findall(r"define CH5_VERSION_\w+ (\d+)", (ROOT / "ch5_backend" / "version.h").read_text(encoding="utf-8")))


def read_result(kind: str, out: Path, spoken: str) -> dict:
    """What --json tells of one of the data."""
    if kind == "recording":
        rows = jsonout.read_rows(out / "csv" / "odometry_policies.csv")
        segments = jsonout.read_rows(out / "csv" / "odometry_segments.csv")
        of = lambda name: [{field: value for field, value in segment.items() if field != "policy"}
                           for segment in segments if segment["policy"] == name]
        results = jsonout.read_rows(out / "csv" / "odometry_results.csv")
        found = lambda name: {row["quantity"]: {"value": row["value"], "sigma": row["sigma"]} for row in results if row["policy"] == name}
        policies = [{**{field: row[field] for field in POLICY_FIELDS}, "results": found(row["policy"]), "segments": of(row["policy"])}
                    for row in rows]
        return {"problem": out.name, "version": version(), "policies": policies,
                "warnings": jsonout.read_rows(out / "csv" / "odometry_warnings.csv"), "out": str(out), "report": str(out / PAGES[spoken])}
    return {**jsonout.read_summary(out / "summary.csv"), "out": str(out)}


def given_options(arguments) -> dict:
    """{option: value, which is True for a flag}."""
    values = {option: getattr(arguments, option[2:].replace("-", "_")) for option in FOR}
    return {option: value for option, value in values.items() if value is not None and value is not False}
