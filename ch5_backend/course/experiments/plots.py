"""./course plots: every figure of the project out of its tables, and where they are missing, the tables first.

A trial's file appears whole or not at all, at OUT/jobs/SET/STUDY-KEY/K.csv. KEY is drawn from all that its rows depend
on: the contents of the program, and of every file among its words, the words, and CH5_SIMD. So no finished trial is
repeated, and after a change of any of them the results lie elsewhere: old ones are never taken for new.
"""

import hashlib
import itertools
import os
import shutil
import subprocess
import sys
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from ch5_backend.figures.atomic_write import atomic_write, write_whole

from ..base import processes
from ..base.cmake_build import BIN, CORES, build_or_fail, data_folder
from ..base.errors import CourseError, warn
from ..base.output_dir import locked_dir, made_dir
from ..base.progress import Progress
from .figure_sets import SETS
from .programs import check_exit


@dataclass(frozen=True)
class Job:
    """One run of a program; with `result`, the words --out FILE are added."""
    command: tuple
    seconds: float  # about how long
    name: str
    result: Path = None

    def done(self) -> bool:
        return bool(self.result) and self.result.exists()

    def run(self) -> None:
        """Raises CourseError if the program fails; its words are printed above."""
        if self.result:
            self.result.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(self.result) if self.result else nullcontext() as partial:
            words = ("--out", str(partial)) if partial else ()
            with processes.running([*self.command, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True, errors="replace",
                                   env={**os.environ, "MPLBACKEND": "Agg", "PYTHONUTF8": "1"}) as process:
                said = process.communicate()[0]
            if process.returncode > 0:
                print(said.strip(), file=sys.stderr)
            check_exit(self.command, process.returncode, f"that was {self.name}; its message is above")
            if partial and not partial.exists():
                raise CourseError(f"{self.name}: {Path(self.command[0]).name} has written nothing", 1)


def plots(arguments) -> int:
    """Returns the exit code; raises CourseError for a name that no set has, or a program or script that failed."""
    out = Path(arguments.out or "out") / ("quick" if arguments.quick else "")
    sets = chosen(arguments.names)
    if arguments.list:
        print(listing(sets, out))
        return 0
    with made_dir(out):
        sets = possible(sets, out, arguments)
        makers = makers_of(sets)
        due = due_of(makers, out, arguments.rerun)
        if arguments.shard:
            return run_share(makers, due, out, arguments)
        drawing = {one.command(one.drawn_by, out): one for one in sets}  # a script that draws several sets runs once
        draw = [Job(command, one.seconds[1] / CORES, one.name) for command, one in drawing.items()]
        make_tables(due, out, arguments.quick, draw)
    print(f"The figures: {out}")
    return 0


def make_missing(sets: list, out: Path) -> None:
    """Makes the tables that these sets lack, and says so."""
    if due := due_of(makers_of(sets), out):
        make_tables(due, out)


def chosen(names: list) -> list:
    """The sets whose name contains one of `names`; all without names."""
    for name in names:
        if not any(name in one.name for one in SETS):
            raise CourseError(f"no set of figures is called '{name}'; there are {', '.join(one.name for one in SETS)}")
    return [one for one in SETS if not names or any(name in one.name for name in names)]


def possible(sets: list, out: Path, arguments) -> list:
    """Without those that lack their data, or take too long for --quick; says so, and raises CourseError if none is left."""
    late = [one for one in sets if arguments.quick and one.quick is None]
    blind = [one for one in sets if one not in late and (arguments.rerun or one.lacks_tables(out)) and not one.has_data()]
    for left_out, why in ((late, "they take too long for --quick"), (blind, f"their data are not in {data_folder()}")):
        if left_out:
            warn(f"left out: {', '.join(one.name for one in left_out)}; {why}")
    rest = [one for one in sets if one not in late + blind]
    if not rest:
        raise CourseError("nothing is left to draw")
    return rest


def makers_of(sets: list) -> list:
    """The sets whose tables these draw."""
    names = {name for one in sets for name in (one.name, *one.beside.split())}
    return [one for one in SETS if one.name in names and one.made_by]


def due_of(makers: list, out: Path, rerun=False) -> list:
    """Those of the makers that are to run, with their programs built; says which tables are missing."""
    due = [one for one in makers if rerun or one.lacks_tables(out) or trials_folder(one, out).exists()]
    if missing := [one.name for one in due if one.lacks_tables(out) and not rerun]:
        warn(Progress.say("refute.tables_missing", out=str(out), names=", ".join(missing)))
    programs = {Path(one.command(one.made_by, out)[0]) for one in due}
    if targets := sorted(path.name for path in programs if path.parent == BIN):
        build_or_fail(targets)
    return due


def trials_folder(one, out: Path) -> Path:
    return out / "jobs" / one.name


def jobs_of(one, out: Path, quick: bool) -> list:
    """The runs that make the tables of a set."""
    words, seconds = quick and one.quick or ("", one.seconds[0])
    command = (*one.command(one.made_by, out), *words.split())
    each, jobs = seconds / max(1, sum(counts[0] for counts in one.trials.values())), []
    for study, counts in one.trials.items():
        place = trials_folder(one, out) / f"{study}-{key_of((*command, study))}"
        jobs += [Job((*command, study, "--trial", str(k)), each, f"{one.name}, {study} {k + 1} of {counts[quick]}",
                     place / f"{k}.csv") for k in range(counts[quick])]
    return jobs or [Job(command, seconds, one.name)]


def key_of(words: tuple) -> str:
    digest = hashlib.sha256(os.environ.get("CH5_SIMD", "").encode())
    for word in words:
        digest.update(b"\0" + word.encode("utf-8", "surrogateescape"))
        if Path(word).is_file():
            digest.update(b"\0" + Path(word).read_bytes())
    return digest.hexdigest()[:16]


def make_tables(due: list, out: Path, quick=False, draw=()) -> None:
    """Makes the tables of these sets, then runs the jobs `draw`."""
    jobs = [job for one in due for job in jobs_of(one, out, quick)]
    with locked_dir(out), progress_of("plots" if draw else "tables", [*jobs, *draw]) as progress:
        run_unfinished(jobs, progress)
        for one in due:
            if one.trials:
                merge(jobs_of(one, out, quick), out / one.folder / "csv")
                shutil.rmtree(trials_folder(one, out))
        if (out / "jobs").exists() and not any((out / "jobs").iterdir()):
            (out / "jobs").rmdir()
        run_in_parallel(draw, CORES, progress)


def progress_of(phase: str, jobs: list) -> Progress:
    return Progress(phase, expected=sum(job.seconds for job in jobs if not job.done()))


def run_unfinished(jobs: list, progress: Progress) -> None:
    """Trials share the cores; other programs, some of which use them all or measure time, run one by one."""
    run_in_parallel([job for job in jobs if not job.result], 1, progress)
    run_in_parallel([job for job in jobs if job.result and not job.done()], CORES, progress)


def run_in_parallel(jobs: list, width: int, progress: Progress) -> None:
    """Raises CourseError if one fails. Then, and after Ctrl-C, the running ones are ended, and the done ones stay."""
    with ThreadPoolExecutor(width) as pool:
        waiting = {pool.submit(job.run): job for job in jobs}
        try:
            while waiting:
                progress.expected_step(next(iter(waiting.values())).name)
                for future in wait(waiting, 1.0, FIRST_COMPLETED).done:
                    progress.finished(waiting.pop(future).seconds)
                    future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            processes.end_all()
            raise


def merge(jobs: list, folder: Path) -> None:
    """A table a study, with its trials in their order: it does not depend on who ran which, and when."""
    folder.mkdir(parents=True, exist_ok=True)
    for place, trials in itertools.groupby(jobs, lambda job: job.result.parent):
        texts = [job.result.read_text(encoding="utf-8") for job in trials]
        write_whole(folder / f"{place.name.rpartition('-')[0]}.csv", texts[0] + "".join(text.partition("\n")[2] for text in texts[1:]))


def run_share(makers: list, due: list, out: Path, arguments) -> int:
    """Every n-th run. Which ones does not depend on what others have done meanwhile."""
    number, count = arguments.shard
    jobs = [(one, job) for one in makers for job in jobs_of(one, out, arguments.quick)]
    mine = [job for one, job in jobs[number - 1::count] if one in due]
    with progress_of(f"share {number} of {count}", mine) as progress:
        run_unfinished(mine, progress)
    print(f"Share {number} of {count} is done: {len(mine)} runs. After all shares, the same command without --shard "
          "draws the figures.")
    return 0


def listing(sets: list, out: Path) -> str:
    """What there is, a line each."""
    lines = [f"{'NAME':<30} {'TABLES':>8} {'FIGURES':>8}  STATE"]
    for one in sets:
        makers = makers_of([one])
        missing = [maker for maker in makers if maker.lacks_tables(out)]
        state = "to be drawn" if not missing else "to be run" if one.has_data() else "no data"
        lines.append(f"{one.name:<30} {sum(maker.seconds[0] for maker in makers):>6} s {one.seconds[1]:>6} s  {state}")
    return "\n".join(lines)
