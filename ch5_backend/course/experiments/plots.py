"""./course plots: every figure of the project out of its tables, and where they are missing, the tables first."""

import sys
from pathlib import Path

from ..base.build import BIN, CORES, build_or_fail, data_folder
from ..base.errors import CourseError
from .figure_sets import SETS
from .jobs import Job, clear, merge, run_jobs, trial_jobs
from ..base.output_dir import alone_in, make_writable
from ..base.progress import Progress


def plots(arguments) -> int:
    """Returns the exit code; raises CourseError for a name that no set has, or a program or script that failed."""
    out = Path(arguments.out or "out") / ("quick" if arguments.quick else "")
    sets = chosen(arguments.names)
    if arguments.list:
        print(listing(sets, out))
        return 0
    sets = possible(sets, out, arguments)
    make_writable(out)
    makers = makers_for(sets)
    sets_to_make = [one for one in makers if arguments.rerun or one.lacks(out) or jobs_folder(one, out).exists()]
    if missing := [one.name for one in sets_to_make if one.lacks(out) and not arguments.rerun]:
        say(f"tables are missing in {out}, and are made first: {', '.join(missing)}")
    programs = {Path(one.command(one.made_by, out)[0]) for one in sets_to_make}
    if targets := sorted(path.name for path in programs if path.parent == BIN):
        build_or_fail(targets)
    if arguments.shard:
        return run_share(makers, sets_to_make, out, arguments)
    with alone_in(out):
        make = jobs_of(sets_to_make, out, arguments.quick)
        draw = draw_jobs(sets, out)
        with Progress("plots", expected=sum(job.seconds for job in unfinished(make) + draw)) as progress:
            make_tables(make, progress)
            for one in sets_to_make:
                merge_trials(one, out, arguments.quick)
            run_jobs(draw, CORES, progress)
    print(f"The figures: {out}")
    return 0


def make_missing(sets: list, out: Path) -> None:
    """Makes the tables that these sets lack, and says so."""
    lacking = [one for one in makers_for(sets) if one.lacks(out)]
    if not lacking:
        return
    say(f"tables are missing in {out}, and are made first: {', '.join(one.name for one in lacking)}")
    build_or_fail(sorted({Path(one.command(one.made_by, out)[0]).name for one in lacking}))
    jobs = jobs_of(lacking, out, quick=False)
    with alone_in(out), Progress("tables", expected=sum(job.seconds for job in unfinished(jobs))) as progress:
        make_tables(jobs, progress)
        for one in lacking:
            merge_trials(one, out, quick=False)


def makers_for(sets: list) -> list:
    """Those of the sets that make tables, and the sets whose tables they draw besides."""
    found = [one for one in sets if one.made_by]
    beside = {name for one in sets for name in one.beside.split()}
    return found + [one for one in SETS if one.name in beside and one not in found]


def say(text: str) -> None:
    print(f"course: {text}", file=sys.stderr)


def chosen(names: list) -> list:
    """The sets whose name contains one of `names`; all without names."""
    for name in names:
        if not any(name in one.name for one in SETS):
            raise CourseError(f"no set of figures is called '{name}'; there are {', '.join(one.name for one in SETS)}")
    return [one for one in SETS if not names or any(name in one.name for name in names)]


def possible(sets: list, out: Path, arguments) -> list:
    """Without those that lack their data, or take too long for --quick; says so, and raises CourseError if none is left."""
    late = [one for one in sets if arguments.quick and one.quick is None]
    blind = [one for one in sets if one not in late and (arguments.rerun or one.lacks(out)) and not one.has_data()]
    for left_out, why in ((late, "they take too long for --quick"), (blind, f"their data are not in {data_folder()}")):
        if left_out:
            say(f"left out: {', '.join(one.name for one in left_out)}; {why}")
    rest = [one for one in sets if one not in late + blind]
    if not rest:
        raise CourseError("nothing is left to draw")
    return rest


def jobs_folder(one, out: Path) -> Path:
    return out / "jobs" / one.name


def jobs_of(sets: list, out: Path, quick: bool) -> list:
    """All runs that make the tables of these sets; a run that serves two sets is listed once."""
    jobs = {}
    for one in sets:
        command = one.command(one.made_by, out)
        words, seconds = quick and one.quick or ("", one.seconds[0])
        command += tuple(words.split())
        if one.trials:
            studies = {study: counts[quick] for study, counts in one.trials.items()}
            share = sum(studies.values()) / sum(counts[0] for counts in one.trials.values())
            found = trial_jobs(command, one.name, studies, jobs_folder(one, out), seconds * share)
        else:
            found = [Job(command, seconds, one.name)]
        jobs.update((job.command, job) for job in found if job.command not in jobs)
    return list(jobs.values())


def draw_jobs(sets: list, out: Path) -> list:
    """The scripts to run; one that draws several sets is listed once."""
    jobs = [Job(one.command(one.drawn_by, out), one.seconds[1] / CORES, one.name) for one in sets]
    return list({job.command: job for job in jobs}.values())


def unfinished(jobs: list) -> list:
    return [job for job in jobs if not (job.result and job.result.exists())]


def make_tables(jobs: list, progress: Progress) -> None:
    """Trials share the cores; other programs, some of which use them all or measure time, run one by one."""
    left = unfinished(jobs)
    run_jobs([job for job in left if not job.result], 1, progress)
    run_jobs([job for job in left if job.result], CORES, progress)


def merge_trials(one, out: Path, quick: bool) -> None:
    """The tables of a set of trials; then their files have served."""
    jobs = jobs_of([one], out, quick) if one.trials else []
    for study in one.trials:
        merge([job for job in jobs if job.study() == study], out / one.folder / "csv" / f"{study}.csv")
    clear(jobs_folder(one, out))


def run_share(sets: list, due: list, out: Path, arguments) -> int:
    """Every n-th run. Which ones does not depend on what others have done meanwhile."""
    number, count = arguments.shard
    share = jobs_of(sets, out, arguments.quick)[number - 1::count]
    wanted = {job.command for job in jobs_of(due, out, arguments.quick)}
    mine = [job for job in share if job.command in wanted]
    with Progress(f"share {number} of {count}", expected=sum(job.seconds for job in unfinished(mine))) as progress:
        make_tables(mine, progress)
    print(f"Share {number} of {count} is done: {len(mine)} runs. After all shares, the same command without --shard "
          "draws the figures.")
    return 0


def listing(sets: list, out: Path) -> str:
    """What there is, a line each."""
    lines = [f"{'NAME':<30} {'TABLES':>8} {'FIGURES':>8}  STATE"]
    for one in sets:
        state = "to be drawn" if not one.lacks(out) else "to be run" if one.has_data() else "no data"
        lines.append(f"{one.name:<30} {one.seconds[0]:>6} s {one.seconds[1]:>6} s  {state}")
    return "\n".join(lines)
