"""The command line of ./course: what each sub-command takes, and the exit code that it returns."""

import argparse
import difflib
import json
import math
import os
import re
import signal
import sys
from importlib import import_module
from pathlib import Path

from .base import jsonout, language, processes
from .base.errors import CourseError, warn

DESCRIPTIONS = {
    "run": "Without DATA: runs the whole chapter in under a minute and writes its tables, figures and a report that "
           "explains them: report.html in English, report.zh.html in Chinese. With DATA: solves each bundle "
           "adjustment, pose graph or window and writes the result in the format that it was read in or as a "
           "trajectory, its iterations as CSV, and a picture of before and after; follows each recording with both "
           "window policies, after ./course track where it is a folder of images (EuRoC's mav0), and writes trajectories and "
           "a report in both languages. With --mine: runs your homework's functions beside the solution's, on the chapter's problems or on DATA, and shows where they differ: mine.html.",
    "track": "The front end: follows corners through the images of a folder in EuRoC's layout (mav0/ with cam0 and imu0, perhaps cam1, "
             "or the folder that holds it; TUM-VI's is the same) and writes the recording DIR/NAME: tracks.csv, imu.csv, "
             "calibration.yaml and, where the truth is known, groundtruth.csv. ./course run FOLDER does this by itself. It "
             "needs OpenCV, which it installs: libopencv-video-dev and libpng-dev, 46 MB.",
    "fly": "Flies with your functions of stages 5 and 6 beside the solution's: through a simulated room, or the recording in "
           "DATA, a folder; given a BAL file, your block solver of stage 7 adjusts it. Writes mine.html.",
    "test": "Builds everything and runs the tests. What follows -- goes to CTest: ./course test -- --rerun-failed",
    "check": "Compiles your files in ch5_homework/, runs the tests of each stage, and explains what is not right. "
             "A stage is not-started, does-not-compile, crashes, times-out, wrong or right; exit code 0 if all that "
             "were asked for are right.",
    "grade": "Grades submissions that nobody trusts: each a homework file, a folder, a zip or a tar. Their code is compiled and "
             "run in a sandbox, and only its numbers are believed. Writes for each feedback.html, results.json "
             "(Gradescope), junit.xml and autolab.json; for the class grades.csv, summary.html and unnamed.csv, the wrong answers that several share and no cause names. Stopped, it goes on "
             "where it was; what has a record is not graded again.",
    "pack": "Packs the project without its solutions: student, the students' archive. Packs the grader for another platform: "
            "gradescope, the zip of an autograder; classroom, GitHub Classroom's workflow in the students' repositories; "
            "classroom-grading, the one in the course's own.",
    "hint": "Prints one of the three hints on a stage of the handout, such as ./course hint 1.2 1. Try again before you ask "
            "for the next.",
    "deep": "Turns your files in ch5_homework/ to the second depth: more blanks, and no lines with question marks to fill in. "
            "A file that you have begun stays as it is.",
    "reset": "Begins files of the homework anew. What stood in them is kept beside them, as problem.cc.before.",
    "status": "Shows the state of every stage at a glance.",
    "bench": "Measures our solvers and, where it is installed, Ceres on the same problems: same start, same loss, "
             "analytic Jacobians, one process for each measurement, taking turns, by the processor's time with one thread and the "
             "clock with two; in two settings, both told the same and each at its best; medians of five rounds, which take "
             "about twenty-five minutes. Prints a table, and writes CSV and plots into out/bench. NAME picks the problems whose "
             "name contains it, such as bal/ or vio_M.",
    "plots": "Draws all figures of the project, or those of the sets whose name contains a NAME, from the tables in DIR; "
             "runs what makes the tables where they are missing. Everything takes about ten minutes on two cores, --quick "
             "less than two. Stopped, it resumes, trial by trial; the same tables give the same bytes. Each figure "
             "is a PNG, and an SVG and a PDF with text kept as text, for a paper.",
    "slides": "Builds the decks in slides/, or those that are named, such as 2-solvers.en, to self-contained HTML and "
              "PDF in out/slides; tables that are missing are made first. What follows -- goes to the builder.",
    "docs": "Makes the pages of the API with Doxygen, formulas set by MathJax: one folder that needs no network, with the "
            "index of formulas in front.",
    "lab": "Compiles the course's C++ to WebAssembly with emscripten and writes out/lab.html: one page, which works offline, "
           "in which prior, noise, loss and damping are sliders, with ten tasks.",
    "site": "Puts the decks, the homework's pages, the report, the API and the lab into out/site, in both languages, for any "
            "static host; makes first what is missing or out of date. Speaker notes stay in out/slides.",
}
JSON_FIELDS = {
    "run": "out, report, seconds; with a FILE: problem, initial_cost, final_cost, iterations, seconds, termination, out …; "
           "with a recording: problem, out, report, policies: [{policy, ate_m, scale_error, yaw_error_deg, realtime_factor, "
           "p99_window_ms, frames, restarts, rpe_m, path_m, drift_percent, segments: [{segment, first_s, last_s, frames, ate_m, "
           "scale_error, yaw_error_deg}]}], errors null without a truth; with several DATA: results, all these; with --mine: as fly",
    "track": "out: [DIR, …]",
    "fly": "out, report, failures: {experiment: message or null}",
    "bench": "rows: [{problem, setting, threads, ours_ms, peer, peer_way, peer_ms, ratio, ours_cost, peer_cost, ours_peak_mb, "
             "peer_peak_mb, ours_bytes, peer_bytes}]; ratio is the median of the rounds' peer_ms / ours_ms, null where a side did not get there; peer_way is what served Ceres best; bytes are "
             "those that the solver adds to each observation of a BAL problem or a city",
    "check": "stages: [{id, state, hint}]",
    "grade": "out, records: [{name, status, score, points}]",
    "status": "stages: [{id, state, hint}]",
}
SPEAKING = ("run", "track", "fly", "check", "status", "grade", "pack", "hint", "deep", "reset")  # to students, hence in their language
COMMANDS = {  # its module, and the function of it that does it
    "run": (".experiments.run", lambda module, given: module.run(given)),
    "track": (".experiments.track", lambda module, given: module.track(given)),
    "fly": (".experiments.fly", lambda module, given: module.fly(given, only_flights=True)),
    "test": (".test", lambda module, given: module.test(given.names, given.quick, given.nightly, given.extra)),
    "check": (".homework.check", lambda module, given: module.run_check(given.asked, given.json, given.seed, given.language)),
    "status": (".homework.check", lambda module, given: module.run_status(given.json, given.language)),
    "hint": (".homework.hint", lambda module, given: module.show(given.stage, given.number, given.language)),
    "deep": (".homework.make_skeleton", lambda module, given: module.deepen(not given.off, given.language)),
    "reset": (".homework.make_skeleton", lambda module, given: module.reset(given.files, given.language)),
    "grade": (".grading.grade", lambda module, given: module.run_grade(given)),
    "pack": (".grading.pack", lambda module, given: module.pack(given.what, given.out, given.language)),
    "bench": (".experiments.bench", lambda module, given: module.bench(given)),
    "plots": (".experiments.plots", lambda module, given: module.plots(given)),
    "slides": (".documents.slides", lambda module, given: module.slides(given, given.extra)),
    "docs": (".documents.api", lambda module, given: module.docs(given.out)),
    "lab": (".documents.lab", lambda module, given: module.lab(given.out)),
    "site": (".documents.site", lambda module, given: module.site(given.out)),
}
REFUSALS = {  # its module, and what of it says no to words that the grammar takes
    "run": (".experiments.run", lambda module, given: module.kinds_of(given)),
    "fly": (".experiments.data", lambda module, given: list(map(module.kind_of, given.data))),
    "test": (".test", lambda module, given: module.refuse(given.names)),
    "track": (".experiments.track", lambda module, given: module.refuse(given)),
    "bench": (".experiments.bench", lambda module, given: module.chosen(given.names)),
    "plots": (".experiments.plots", lambda module, given: module.chosen(given.names)),
    "check": (".homework.check", lambda module, given: module.select(given.asked)),
    "grade": (".grading.submission", lambda module, given: module.refuse(given)),
    "pack": (".grading.pack", lambda module, given: module.refuse(given.what)),
    "slides": (".documents.slides", lambda module, given: module.refuse(given.names)),
}
FORWARDING = ("test", "slides")  # to CTest and the builder, what follows --; elsewhere it is data, whatever it begins with
PAGES = {"docs": "where the pages go; the folder is replaced; default: out/api", "lab": "where the page goes, default: out",
         "site": "where the folder site is made, default: out"}


def number(low, high):
    """A reader of a number in [low, high], whole if these are."""
    whole = isinstance(low, int)
    pattern = r"-?\d{1,18}" if whole else r"-?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?"
    words = f"a whole number from {low} to {high}" if whole else f"a number from {low:g} to {high:g}"

    def read(text: str):
        if not re.fullmatch(pattern, text, re.ASCII | re.IGNORECASE) or not low <= type(low)(text) <= high:
            raise must_be(words, text)
        return type(low)(text)
    return read


def one_of(*names):
    """A reader of one of these words."""
    def read(text: str) -> str:
        if text not in names:
            raise must_be(f"one of {', '.join(names)}", text)
        return text
    return read


def share(text: str) -> tuple:
    """"2/4" as (2, 4)."""
    numbers = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text, re.ASCII)
    index, count = map(int, numbers.groups()) if numbers else (0, 0)
    if not 1 <= index <= count:
        raise must_be("I/N with I from 1 to N", text)
    return index, count


def interval(text: str) -> str:
    """A:B, either of which may be missing."""
    first, colon, last = text.partition(":")
    try:
        is_one = colon and 0.0 <= float(first or 0.0) < float(last or math.inf)
    except ValueError:
        is_one = False
    if not is_one:
        raise must_be("A:B with 0 ≤ A < B, in seconds since the first IMU measurement", text)
    return text


def must_be(what: str, text: str) -> argparse.ArgumentTypeError:
    return argparse.ArgumentTypeError(f"must be {what}, got '{text}'")


class Folded(argparse.HelpFormatter):
    """Chinese letters are two columns wide, and a line may end behind each of them."""

    def _split_lines(self, text: str, width: int) -> list:
        return language.fold(" ".join(text.split()), width).splitlines()

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return "\n".join(indent + line for line in self._split_lines(text, width))


class Parser(argparse.ArgumentParser):
    """An error becomes a CourseError, so that --json holds for it too."""

    def error(self, message: str):
        message = re.sub(r"^argument (\S+): ", r"\1 ", message)
        raise CourseError(f"{message}; see {self.prog} --help")


def add_run_options(parser: Parser) -> None:
    parser.add_argument("data", nargs="*", metavar="DATA", help="a bundle adjustment in BAL's text "
                        "format, a pose graph in g2o's, a window (VIOWIN), or a recording's folder, EuRoC's mav0 too")
    parser.add_argument("--out", metavar="DIR", help="where the results go, default: out; each FILE.txt gets a "
                        "folder DIR/FILE")
    parser.add_argument("--mine", action="store_true", help="with your files in ch5_homework/")
    # Ranges and names are those of the programs, which may take minutes to build; a test holds them together.
    parser.add_argument("--iterations", type=number(0, 1000000), metavar="N", help="at most N iterations")
    parser.add_argument("--threads", type=number(1, 256), metavar="N", help="how many threads the solver may use")
    parser.add_argument("--huber", type=number(1e-6, 1e6), metavar="D", help="Huber loss that begins at D pixels, or in a pose graph at D standard "
                        "deviations")
    parser.add_argument("--solver", type=one_of("automatic", "dense", "sparse", "pcg", "implicit-pcg", "power-series"),
                        metavar="NAME", help="of the cameras' or poses' system: automatic, dense, sparse, pcg, "
                        "implicit-pcg or power-series; default: automatic, by the size and shape of the problem")
    parser.add_argument("--init", type=one_of("file", "odometry", "spanning-tree", "chordal"), metavar="START", help="where a pose graph's optimization begins: file, odometry, "
                        "spanning-tree or chordal; default: the one of least cost")
    parser.add_argument("--project-information", action="store_true", default=None, help="in a pose graph, replace each "
                        "information matrix that is not positive semi-definite by the nearest one that is")
    parser.add_argument("--policy", type=one_of("vins", "okvis"), metavar="NAME", help="of a recording: vins or okvis only; default: both")
    parser.add_argument("--batch", action="store_true", default=None, help="also solves the recording at once, to compare with")
    parser.add_argument("--seconds", type=interval, metavar="A:B", help="only this part of a recording, from its first IMU measurement on")
    parser.add_argument("--window", type=number(4, 1000), metavar="N", help="VINS: frames beside the newest, default 10; OKVIS: keyframes, default 5")
    parser.add_argument("--max-features", type=number(8, 100000), metavar="N", help="at most N tracks of an image, those followed longest")
    parser.add_argument("--first-estimates", type=one_of("none", "prior", "full"), metavar="WHICH", help="observability constraints, which stand for first "
                        "estimates: none, prior or full; default: none")
    parser.add_argument("--estimate-extrinsic", action="store_true", default=None, help="refines the poses of the cameras on the body")
    parser.add_argument("--estimate-time-offset", action="store_true", default=None, help="refines the delay of the cameras' clock all along; without it, it is found once")
    parser.add_argument("--mono", action="store_true", default=None, help="leaves out camera 1 of a recording with two")


def add_plots_options(parser: Parser) -> None:
    parser.add_argument("names", nargs="*", metavar="NAME", help="part of a set's name; default: all")
    parser.add_argument("--list", action="store_true", help="only list the sets: how long their tables and figures "
                        "take, and what is there")
    parser.add_argument("--rerun", action="store_true", help="make the tables anew")
    parser.add_argument("--quick", action="store_true", help="with fewer trials, in DIR/quick")
    parser.add_argument("--shard", type=share, metavar="I/N", help="only run the I-th of N shares of what "
                        "makes the tables, and draw nothing")
    parser.add_argument("--out", metavar="DIR", help="where tables and figures are, default: out")


def add_grade_options(parser: Parser) -> None:
    parser.add_argument("submissions", nargs="*", metavar="SUBMISSION", help="a .cc file, a folder, a zip or a tar")
    parser.add_argument("--out", metavar="DIR", help="where the grades go, default: out/grades")
    parser.add_argument("--jobs", type=number(1, 256), metavar="N", help="so many submissions at a time; "
                        "default: one for each processor")
    parser.add_argument("--stages", type=lambda text: text.split(","), default=[], metavar="LIST",
                        help="only these, such as 1.1,3; default: all")
    parser.add_argument("--seed", type=number(0, 10**18 - 1), metavar="S", help="of the random problems; "
                        "default: one at random, which the records name")
    parser.add_argument("--shard", type=share, metavar="I/N", help="only the I-th of N shares; all may have the same "
                        "DIR, in which a last run without this option makes the class's tables")
    parser.add_argument("--list", metavar="FILE", help="names the submissions, one a line")
    parser.add_argument("--class", dest="class_file", metavar="FILE", help="who is in the class, and what a human has "
                        "decided: a table, or an export of Canvas, Moodle or Gradescope; writes students.csv and the platform's "
                        "gradebook too; without submissions what is graded is marked again; see ch5_homework/GRADING.md")
    parser.add_argument("--column", metavar="NAME", help="the assignment's in the gradebook, default: Chapter 5")
    parser.add_argument("--due", metavar="TIMES", help="such as 2026-12-01T23:59, or by stage: 2026-12-01T23:59; 4=2026-12-08T23:59; "
                        "a day begun later costs")
    parser.add_argument("--late", type=number(0, 100), metavar="PERCENT", help="of the judged points for each "
                        "day begun, default: 10")
    parser.add_argument("--keep", type=one_of("last", "best"), metavar="WHICH", help="of a student's submissions: last or best; default: last")
    parser.add_argument("--rename", action="store_true", help="run the mistakes that were added to ch5_homework/mistakes, and tell them in "
                        "all that was graded; nothing else is run again, and no SUBMISSION is needed")
    parser.add_argument("--prepare", action="store_true", help="only build what grading needs, and try the sandbox")
    parser.add_argument("--whole", action="store_true", help="judge stages as a whole, and never blank by blank: where students "
                        "see each result and hand in again")
    parser.add_argument("--trust", action="store_true", help="without the sandbox: for your own code only")


def add_slides_options(parser: Parser) -> None:
    parser.add_argument("names", nargs="*", metavar="DECK", help="such as 2-solvers.en or 2-solvers; default: all")
    parser.add_argument("--html", action="store_true", help="no PDF, which needs Chromium")
    parser.add_argument("--check", action="store_true", help="build nothing; say which numbers and figures of the "
                        "built decks are out of date, and fail if any is")


def make_parser(command: str) -> Parser:
    """One sub-command's grammar. Options are never abbreviated: a typing error must not run something else."""
    parser = Parser(prog=f"./course {command}", description=DESCRIPTIONS[command], allow_abbrev=False,
                    formatter_class=Folded)
    if command == "run":
        add_run_options(parser)
    elif command == "track":
        parser.add_argument("data", nargs="*", metavar="FOLDER", help="in EuRoC's layout: mav0, or the folder that holds it")
        parser.add_argument("--out", metavar="DIR", help="where the results go, default: out; each FOLDER gets DIR/NAME")
        parser.add_argument("--mono", action="store_true", help="leaves out camera 1 of a recording with two")
    elif command == "fly":
        parser.add_argument("data", nargs="*", metavar="DATA", help="a recording's folder, or a BAL file; default: simulated")
        parser.add_argument("--out", metavar="DIR", help="where the results go, default: out")
    elif command == "test":
        parser.add_argument("names", nargs="*", metavar="NAME", help="only tests whose name matches this expression")
        parser.add_argument("--quick", action="store_true", help="leave out the tests labeled slow")
        parser.add_argument("--nightly", action="store_true", help="only the tests that are slow and rarely fail, labeled nightly")
    elif command == "bench":
        parser.add_argument("names", nargs="*", metavar="NAME", help="part of a problem's name; default: all")
        parser.add_argument("--quick", action="store_true", help="three rounds and one thread at most, as far as 85 "
                            "seconds reach")
        parser.add_argument("--out", metavar="DIR", help="where the folder bench is made, default: out")
    elif command == "grade":
        add_grade_options(parser)
    elif command == "pack":
        parser.add_argument("what", metavar="WHAT", nargs="?", default="", help="student, gradescope, classroom or classroom-grading")
        parser.add_argument("--out", metavar="FILE", help="default: chapter5.tar.gz, gradescope.zip, classroom.yml or grade.yml")
    elif command == "plots":
        add_plots_options(parser)
    elif command == "slides":
        add_slides_options(parser)
    elif command in PAGES:
        parser.add_argument("--out", metavar="DIR", help=PAGES[command])
    elif command == "check":
        parser.add_argument("asked", nargs="*", metavar="STAGE", help="such as 1.1, 1.1a or problem.cc; default: all")
        parser.add_argument("--seed", type=number(0, 10**18 - 1), metavar="S", help="use different random numbers "
                            "and problem sizes: with the seed of a grade, its cases")
    elif command == "hint":
        parser.add_argument("stage", metavar="STAGE", nargs="?", default="", help="such as 1.2, or one of its TODOs, such as 1.2b")
        parser.add_argument("number", metavar="N", nargs="?", default="1", help="1 to 3, each says more; default: 1")
    elif command == "deep":
        parser.add_argument("--off", action="store_true", help="back to the first depth")
    elif command == "reset":
        parser.add_argument("files", nargs="*", metavar="FILE", help="such as problem.cc")
    if command in SPEAKING:
        parser.add_argument("--language", type=one_of(*language.LANGUAGES), default=language.spoken(), metavar="WORD",
                            help="en or zh; default: the terminal's")
    if command in JSON_FIELDS:
        parser.add_argument("--json", action="store_true", help="print one JSON object on standard output and all "
                            f"else on standard error; fields: {JSON_FIELDS[command]}; after a failure: error")
    return translated(parser, command) if language.spoken() == "zh" else parser


def translated(parser: Parser, command: str) -> Parser:
    """The same with its help in Chinese; a field of JSON keeps its name."""
    chinese = json.loads((Path(__file__).parent / "help.zh.json").read_text(encoding="utf-8"))
    parser.description = chinese[command]
    parser._positionals.title, parser._optionals.title = "参数", "选项"
    for action in parser._actions:
        if action.dest == "json":
            for english in [words for words in chinese if words.startswith(("print one JSON", "; ", "], "))]:
                action.help = action.help.replace(english, chinese[english])
        else:
            action.help = chinese[action.help]
    return parser


def unknown(command: str) -> dict:
    """What is said of a command that there is not, with the one that was probably meant."""
    near = difflib.get_close_matches(command, [*DESCRIPTIONS, "help"], n=1)
    if near:
        return language.sentence("command.did_you_mean", command=command, meant=near[0])
    return language.sentence("command.unknown", command=command, commands=", ".join([*DESCRIPTIONS, "help"]))


def dispatch(command: str, given: argparse.Namespace) -> int:
    """A command's module is imported only here, so that ./course is quick to say no."""
    module, do = COMMANDS[command]
    with processes.undisturbed():  # Python's import prints what is raised in its midst
        loaded = import_module(module, __package__)
    return do(loaded, given)


def refuse(command: str, given: argparse.Namespace) -> None:
    """Raises CourseError for words that the command would refuse later, as far as its module needs nothing installed."""
    module, say_no = REFUSALS.get(command, (".base.errors", lambda module, given: None))
    try:
        loaded = import_module(module, __package__)
    except ImportError:
        return
    say_no(loaded, given)


def main(argv: list, only_read: bool = False) -> int:
    """Returns the exit code; every error becomes one message and, with --json, one object.

    With `only_read` nothing is done but to refuse wrong words.
    """
    command, words, extra = argv[0] if argv else "", argv[1:], []
    if "--" in words:
        split = words.index("--")
        words, extra = words[:split], words[split + 1:]
    as_json, say = "--json" in words, language.speaker(language.spoken())
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="backslashreplace")  # a letter that the terminal cannot show is no failure
    try:
        if command not in DESCRIPTIONS:
            raise CourseError(unknown(command))
        arguments = make_parser(command).parse_intermixed_args(words)
        say = language.speaker(getattr(arguments, "language", language.spoken()))
        arguments.extra = extra
        for name in () if command in FORWARDING else vars(arguments).keys() & {"data", "names", "files", "submissions", "asked"}:
            setattr(arguments, name, getattr(arguments, name) + extra)
        if only_read:
            refuse(command, arguments)
            return 0
        processes.listen()
        code = dispatch(command, arguments)
        sys.stdout.flush()
        processes.end_all()
        return code
    except BaseException as error:  # library code may turn a stop into an error of its own
        processes.end_all()
        if processes.stopped_by():
            return fail("stopped", 128 + processes.stopped_by(), as_json)
        if isinstance(error, CourseError):
            message = error.message if isinstance(error.message, dict) else {"quoted": error.message}
            return fail(say.text(message), error.exit_code, as_json)
        if isinstance(error, BrokenPipeError) and not error.filename:  # who read us has seen enough, as head does
            silence()
            return 128 + signal.SIGPIPE
        if isinstance(error, OSError):
            return fail(f"{error.filename or 'standard output'}: {error.strerror}", 2, as_json)
        raise


def fail(message: str, exit_code: int, as_json: bool) -> int:
    warn(message)
    try:
        if as_json:
            jsonout.emit({"error": message})
        sys.stdout.flush()
    except OSError:  # standard output itself is full or closed: nothing more can be said there
        silence()
    return exit_code


def silence() -> None:
    """What is still to be written to standard output goes nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
