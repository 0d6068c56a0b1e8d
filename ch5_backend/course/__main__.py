"""The command line of ./course: which function runs each sub-command, and the exit code that it returns."""

import argparse
import difflib
import os
import signal
import sys
from importlib import import_module

from .base import jsonout, language, processes
from .base.commands import COMMANDS, make_parser
from .base.errors import CourseError, warn
from .base.progress import Progress

ACTIONS = {  # its module, and the function of it that does it
    "run": (".experiments.run", lambda module, given: module.run(given)),
    "track": (".experiments.track", lambda module, given: module.track(given)),
    "fly": (".experiments.fly", lambda module, given: module.fly(given, only_flights=True)),
    "test": (".test", lambda module, given: module.test(given.names, given.quick, given.nightly, given.extra)),
    "check": (".homework.check", lambda module, given: module.watch(given.asked, given.seed, given.language)
              if given.watch and not given.json else module.run_check(given.asked, given.json, given.seed, given.language)),
    "status": (".homework.check", lambda module, given: module.run_status(given.json, given.language)),
    "hint": (".homework.hint", lambda module, given: module.show(given.stage, given.number, given.language)),
    "predict": (".homework.check", lambda module, given: module.predict(module.select([given.stage] if given.stage else []), module.folder(),
                                                                        given.language)),
    "refute": (".experiments.refute", lambda module, given: module.refute(given.number, given.out, given.language)),
    "paper": (".documents.paper", lambda module, given: module.paper(given.seed, given.sheet, given.out, given.language)),
    "deep": (".homework.make_skeleton", lambda module, given: module.deepen(given.off, given.bare, given.language)),
    "reset": (".homework.make_skeleton", lambda module, given: module.reset(given.files, given.language)),
    "grade": (".grading.grade", lambda module, given: module.run_grade(given)),
    "pack": (".grading.pack", lambda module, given: module.pack(given.what, given.out, given.language)),
    "bench": (".experiments.bench", lambda module, given: module.bench(given)),
    "ladder": (".experiments.ladder", lambda module, given: module.ladder(given)),
    "plots": (".experiments.plots", lambda module, given: module.plots(given)),
    "evidence": (".documents.evidence", lambda module, given: module.evidence(given)),
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
    "evidence": (".documents.evidence", lambda module, given: module.refuse(given.name)),
    "slides": (".documents.slides", lambda module, given: module.refuse(given.names)),
}
FORWARDING = ("test", "slides")  # to CTest and the builder, what follows --; elsewhere it is data, whatever it begins with


def unknown(command: str) -> dict:
    """The message for an unknown command, with the one that was probably meant."""
    near = difflib.get_close_matches(command, [*COMMANDS, "help"], n=1)
    if near:
        return language.sentence("command.did_you_mean", command=command, meant=near[0])
    return language.sentence("command.unknown", command=command, commands=", ".join([*COMMANDS, "help"]))


def dispatch(command: str, given: argparse.Namespace) -> int:
    """Imports a command's module only here, so that ./course refuses wrong words quickly."""
    module, do = ACTIONS[command]
    with processes.undisturbed():  # Python's import prints exceptions raised during it
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


def asked_language(words: list) -> str:
    """Of words that may be wrong or ask for help; without one, the terminal's."""
    apart = [part for word in words for part in (word.split("=", 1) if word.startswith("--language=") else [word])]
    asked = [value for option, value in zip(apart, apart[1:]) if option == "--language"]
    return next((word for word in asked if word in language.LANGUAGES), language.spoken())


def main(argv: list, only_read: bool = False) -> int:
    """Returns the exit code; every error becomes one message and, with --json, one object.

    With `only_read` nothing is done but to refuse wrong words.
    """
    command, words, extra = argv[0] if argv else "", argv[1:], []
    if "--" in words:
        split = words.index("--")
        words, extra = words[:split], words[split + 1:]
    as_json, say = "--json" in words, language.speaker(asked_language(words))
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="backslashreplace")  # a letter that the terminal cannot show is no failure
    try:
        if command not in COMMANDS:
            raise CourseError(unknown(command))
        arguments = make_parser(command, say.language).parse_intermixed_args(words)
        say = Progress.say = language.speaker(getattr(arguments, "language", say.language))
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
        return exit_code_of(error, say, as_json)


def exit_code_of(error: BaseException, say: language.Speaker, as_json: bool) -> int:
    """Ends what runs and tells what went wrong; raises an error that is a fault of ours."""
    processes.end_all()
    if processes.stopped_by():
        return fail(say.translate("stopped"), 128 + processes.stopped_by(), as_json)
    if isinstance(error, CourseError):
        message = error.message if isinstance(error.message, dict) else {"quoted": error.message}
        return fail(say.text(message), error.exit_code, as_json)
    if isinstance(error, BrokenPipeError) and not error.filename:  # who read us has seen enough, as head does
        silence()
        return 128 + signal.SIGPIPE
    if isinstance(error, OSError):
        return fail(f"{error.filename or 'standard output'}: {say.translate(error.strerror)}", 2, as_json)
    raise error


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
