"""The command line of ./course: what each sub-command takes, and the exit code that it returns."""

import argparse
import math
import os
import sys

from . import jsonout
from .errors import CourseError

DESCRIPTIONS = {
    "run": "Without DATA: runs the whole chapter in under a minute and writes its tables, figures and a report that "
           "explains them. With DATA: solves each bundle adjustment, pose graph or window and writes the result in the "
           "format that it was read in or as a trajectory, its iterations as CSV, and a picture of before and after; "
           "follows each recording with both window policies and writes trajectories and a report.",
    "test": "Builds everything and runs the tests. What follows -- goes to CTest: ./course test -- --rerun-failed",
    "check": "Compiles your files in ch5_homework/, runs the tests of each stage, and explains what is not right. "
             "A stage is not-started, does-not-compile, crashes, times-out, wrong or right; exit code 0 if all that "
             "were asked for are right.",
    "status": "Shows the state of every stage at a glance.",
    "bench": "Measures our solvers and, where it is installed, Ceres on the same problems: same start, same loss, "
             "analytic Jacobians, one process for each measurement, taking turns; medians of five rounds, which take "
             "about five minutes. Prints a table, and writes CSV and plots into out/bench. NAME picks the problems whose "
             "name contains it, such as bal/ or vio_M.",
    "slides": "Builds the decks in slides/ to self-contained HTML. What follows -- goes to the builder.",
}
JSON_FIELDS = {
    "run": "out, report, seconds; with a FILE problem, initial_cost, final_cost, iterations, seconds, termination, "
           "out and more; with a recording problem, out, report and policies, a list of {policy, ate_m, scale_error, "
           "yaw_error_deg, realtime_factor, p99_window_ms, frames, restarts}, null where there is no truth to compare "
           "with; with several DATA results, a list of these",
    "bench": "rows, a list of {problem, threads, ours_ms, peer, peer_ms, ratio, ours_cost, peer_cost, ours_peak_mb, "
             "peer_peak_mb}; ratio is peer_ms / ours_ms, null where a side did not get there",
    "check": "stages, a list of {id, state, hint}",
    "status": "stages, a list of {id, state, hint}",
}
SOLVERS = ("automatic", "dense", "sparse", "pcg", "implicit-pcg", "power-series")


def positive_int(text: str) -> int:
    value = int(text)
    if value < 1:
        raise ValueError
    return value


def positive_number(text: str) -> float:
    value = float(text)
    if not (value > 0 and math.isfinite(value)):
        raise ValueError
    return value


positive_int.__name__ = "whole number from 1, given"  # argparse says "invalid NAME value: 'text'"
positive_number.__name__ = "number above 0, given"


class Parser(argparse.ArgumentParser):
    """An error becomes a CourseError, so that --json holds for it too."""

    def error(self, message: str):
        raise CourseError(f"{message}; see {self.prog} --help")


def make_parser(command: str) -> Parser:
    """One sub-command's grammar. Options are never abbreviated: a typing error must not run something else."""
    parser = Parser(prog=f"./course {command}", description=DESCRIPTIONS[command], allow_abbrev=False)
    if command == "run":
        parser.add_argument("data", nargs="*", metavar="DATA", help="a bundle adjustment in BAL's text "
                            "format, a pose graph in g2o's, a window (VIOWIN), or a recording's folder")
        parser.add_argument("--out", metavar="DIR", help="where the results go, default: out; each FILE.txt gets a "
                            "folder DIR/FILE")
        parser.add_argument("--iterations", type=positive_int, metavar="N", help="at most N iterations")
        parser.add_argument("--threads", type=positive_int, metavar="N", help="how many threads the solver may use")
        parser.add_argument("--huber", type=positive_number, metavar="D", help="Huber loss that begins at D pixels, or "
                            "in a pose graph at D standard deviations")
        parser.add_argument("--solver", choices=SOLVERS, help="of the cameras' or poses' system; default: automatic, "
                            "by the size and shape of the problem")
        parser.add_argument("--precision", choices=("double", "single"), help="of the numbers that tie poses to "
                            "landmarks; single takes less memory")
    elif command == "test":
        parser.add_argument("names", nargs="*", metavar="NAME", help="only tests whose name matches this expression")
        parser.add_argument("--quick", action="store_true", help="leave out the tests labelled slow")
    elif command == "bench":
        parser.add_argument("names", nargs="*", metavar="NAME", help="part of a problem's name; default: all")
        parser.add_argument("--quick", action="store_true", help="three rounds and one thread at most, as far as 85 "
                            "seconds reach")
        parser.add_argument("--out", metavar="DIR", help="where the folder bench is made, default: out")
    elif command == "check":
        parser.add_argument("stages", nargs="*", metavar="STAGE", help="such as 1.1; default: all")
    if command in JSON_FIELDS:
        parser.add_argument("--json", action="store_true", help="print one JSON object on standard output and all "
                            f"else on standard error; fields: {JSON_FIELDS[command]}; after a failure: error")
    return parser


def dispatch(command: str, words: list, extra: list) -> int:
    """Parses and runs; a command's module is imported only here, so that ./course is quick to say no."""
    arguments = make_parser(command).parse_intermixed_args(words)
    if command == "run":
        from .run import run
        arguments.data += extra
        return run(arguments)
    if command == "test":
        from .test import test
        return test(arguments.names, arguments.quick, extra)
    if command == "bench":
        from .bench import bench
        arguments.names += extra
        return bench(arguments)
    if command == "slides":
        from .slides import slides
        return slides(extra)
    from . import check
    if command == "check":
        return check.run_check(arguments.stages + extra, arguments.json)
    return check.run_status(arguments.json)


def main(argv: list) -> int:
    """Returns the exit code; every error becomes one message and, with --json, one object."""
    command, words, extra = argv[0] if argv else "", argv[1:], []
    if "--" in words:
        split = words.index("--")
        words, extra = words[:split], words[split + 1:]
    as_json = "--json" in words
    try:
        if command not in DESCRIPTIONS:
            raise CourseError(f"unknown command '{command}'; there are {', '.join(DESCRIPTIONS)} and help")
        code = dispatch(command, words, extra)
        sys.stdout.flush()
        return code
    except CourseError as error:
        return fail(str(error), error.exit_code, as_json)
    except KeyboardInterrupt:
        return fail("stopped", 130, as_json)
    except OSError as error:
        return fail(f"{error.filename or 'standard output'}: {error.strerror}", 2, as_json)


def fail(message: str, exit_code: int, as_json: bool) -> int:
    print(f"course: {message}", file=sys.stderr)
    try:
        if as_json:
            jsonout.emit({"error": message})
        sys.stdout.flush()
    except OSError:  # standard output itself is full or closed: nothing more can be said there
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return exit_code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
