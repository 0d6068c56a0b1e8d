"""./course grade: many submissions at once; each record is written whole as soon as it is there, and never made twice."""

import json
import os
import random
import threading
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from ch5_backend.figures.atomic_write import write_whole

from ..base import jsonout, processes
from ..base.cmake_build import CORES
from ..homework.check import select
from ..homework.diagnosis import because, cause_of, said_in
from ..homework.regions import FILES, STAGES
from ..base.errors import CourseError, warn
from ..base.language import Speaker, sentence, speaker
from ..base.output_dir import locked_dir, made_dir
from ..base.progress import Progress, duration
from . import anonymous, classbook, gradebooks, likeness, outputs, pages, rename, summary, talk
from .engines import choose
from .handed_in import gradescope, listed, named
from .job import grade
from .outputs import plain
from .rubric import STAGE_TABLE, mark, read_rubric
from .sandbox import Unguarded
from .submission import collect, handed_in, refuse
from .toolchain import Infrastructure, Toolchain

MOST_TOLD = 40  # lines on the terminal; summary.html has all
VERSION = 4  # of the records; another one is graded again


def run_grade(arguments) -> int:
    """Grades what has no record yet, then marks all records and writes the class's tables; 0, or 1 if somebody who has handed
    something in has no mark."""
    refuse(arguments)
    out, say = Path(arguments.out or "out/grades"), speaker(arguments.language)
    earlier = likeness.earlier(arguments.earlier)
    asked = arguments.stages or arguments.submissions or arguments.list
    stages, rubric = select(arguments.stages) if asked else judged_in(out, say), read_rubric()
    points = {stage["id"]: sum(rubric.get(stage["id"], {}).values()) for stage in stages}
    book = the_class(arguments, points)
    lacking = [stage["id"] for stage in stages if stage["id"] not in rubric]
    if lacking:
        raise CourseError(f"{STAGE_TABLE}: no points for stage {', '.join(lacking)}")
    submissions = named(listed(arguments.submissions, arguments.list))
    if arguments.trust:
        warn("--trust: NO SANDBOX. The submissions' code runs as you, with all that you may do.")
        box = Unguarded
    elif submissions or arguments.prepare or arguments.rename:
        box = choose(arguments.sandbox or "")
    if arguments.prepare:
        toolchain = ready_toolchain(box)
        for file in FILES:
            toolchain.solved(file)
        print(f"ready: the sandbox, {box.name}, holds, and the compilers work in it")
        return 0
    with made_dir(out) if arguments.shard else locked_dir(out):  # shards may work side by side
        toolchain = ready_toolchain(box) if submissions or arguments.rename else None
        learned = rename.learn(toolchain) if arguments.rename else []
        if submissions:
            session = Session(out, toolchain, stages, rubric, the_seed(out, arguments.seed), say, not arguments.whole)
            session.grade_all(share(submissions, arguments.shard), arguments.jobs or CORES)
        rename.rename_all(out)
        records = read_records(out, stages, rubric, say)
        if not records and not submissions:
            if not arguments.rename:
                raise CourseError(f"{out}: nothing was graded there yet; name the submissions")
            if arguments.json:
                jsonout.emit({"out": str(out), "records": []})
            else:
                print(say("grade.learned", names=say("grade.list").join(learned) or "–", path=str(out)))
            return 0
        marks, lost = classbook.settle(book, records, points) if book else ([], [])
        if not arguments.shard:
            write_tables(out, records, points, book, marks, lost, say, earlier)
            if arguments.anonymous:
                anonymous.write(Path(arguments.anonymous), out, records, points, book, marks, say)
            if arguments.talk:
                graded = {record["name"]: record for record in records if record["status"] == "graded"}
                talk.write(Path(arguments.talk), [(graded[name], collect(*paths).files) for name, paths in submissions.items() if name in graded], say)
    looked_at = look_at(records, book, marks, lost, points, say)
    tell(out, records, looked_at, arguments, say)
    return 1 if any(record["status"] != "graded" or "error" in record for record in records) or lost else 0


def write_tables(out: Path, records: list, points: dict, book, marks: list, lost: list, say: Speaker, earlier: list = ()) -> None:
    """All that is made of the records: nothing is compiled or judged for it."""
    count_for = {}
    for one in marks:
        for name in {record["name"] for record in one.records.values()}:
            count_for.setdefault(name, []).append(one)
    for record in records:
        outputs.write_one(out / record["name"], record, say)
        pages.write_feedback(out / record["name"], record, say, count_for.get(record["name"], ()))
    outputs.write_class(out, records, list(points))
    for name, (rows, delimiter, encoding) in (gradebooks.tables(book, marks, points, say) if book else {}).items():
        outputs.write_table(out / name, rows, delimiter, encoding)
    summary.write(out, records, points, book, marks, look_at(records, book, marks, lost, points, say), say, earlier)


def look_at(records: list, book, marks: list, lost: list, points: dict, say: Speaker) -> list:
    """[(who, why)] of all that is no mark yet, or one that is not certain: a human looks there first."""
    unread = lambda record: " ".join(say("grade.fault", fault=fault) for fault in record.get("unread", ()))
    found = [(name, say.text(why)) for name, why in lost]
    found += [(record["name"], say.text(classbook.why_not_judged(record))) for record in records if "error" in record]
    found += [(record["name"], unread(record)) for record in records if record["status"] == "not-read"]
    found += [(record["name"], say("grade.partly_read") + " " + unread(record)) for record in records
              if record["status"] == "graded" and record.get("unread")]
    found += [(f"{student.id} {student.name}", say("grade.no_such_submission", name=plain(name)))
              for student, name in (classbook.not_there(book, records) if book else ())]
    if late := [f"{one.student.id} {one.student.name}" for one in marks if classbook.is_late_by_file_time(one)]:
        found.append((say("grade.list").join(late), say("grade.by_a_files_time")))
    most = sum(points.values()) + sum(book.read.values() if book else ())
    if book and (theirs := gradebooks.refused_there(book, most)):
        found.append((book.table.path.name, say("grade.less_in_moodle", n=theirs, m=f"{most:g}")))
    return found


def the_class(arguments, points: dict):
    """The class that was named, or None. Raises CourseError."""
    if not arguments.class_file:
        if arguments.due or arguments.late is not None or arguments.keep or arguments.column:
            raise CourseError("--due, --late, --keep and --column need --class FILE; see ./course grade --help")
        return None
    book = classbook.read_class(Path(arguments.class_file), points)
    book.due = classbook.read_due(arguments.due or "", points)
    book.percent_a_day = book.percent_a_day if arguments.late is None else arguments.late
    book.keep, book.column = arguments.keep or book.keep, arguments.column or book.column
    return book


def ready_toolchain(box) -> Toolchain:
    toolchain = Toolchain(box)
    try:
        toolchain.prepare()
    except Infrastructure as error:
        raise CourseError(f"nothing was graded: {error}", exit_code=1) from error
    return toolchain


def share(submissions: dict, shard) -> dict:
    """The I-th of N shares, by place in the list."""
    index, count = shard or (1, 1)
    return {name: path for k, (name, path) in enumerate(submissions.items()) if k % count == index - 1}


def the_seed(out: Path, asked) -> int:
    """The seed asked for, or that of the records that are there, or a new one that cannot be guessed."""
    path = out / "session.json"
    if asked is not None:
        write_whole(path, json.dumps({"seed": asked}))
        return asked
    chosen = path.with_name(f".session.json.{os.getpid()}")
    chosen.write_text(json.dumps({"seed": random.SystemRandom().randrange(10**9)}), encoding="utf-8")
    try:
        os.link(chosen, path)  # of two shards that begin at once, one gives the seed to both
    except FileExistsError:
        pass
    chosen.unlink()
    return json.loads(path.read_text(encoding="utf-8"))["seed"]


class Session:
    """What all submissions of a run share."""

    def __init__(self, out: Path, toolchain: Toolchain, stages: list, rubric: dict, seed: int, say: Speaker, by_blanks: bool = True):
        self.out, self.toolchain, self.stages, self.rubric, self.seed = out, toolchain, stages, rubric, seed
        self.say, self.by_blanks = say, by_blanks
        self.key = f"{VERSION} {toolchain.digest} {seed}" + " whole" * (not by_blanks)
        self.locks, self.guard = {}, threading.Lock()

    def grade_all(self, submissions: dict, jobs: int) -> None:
        begin, done = time.monotonic(), 0
        pool = ThreadPoolExecutor(jobs)
        try:
            with Progress("grade") as progress:
                futures = [pool.submit(self.grade_one, name, paths) for name, paths in submissions.items()]
                graded = 0  # those that had a record cost nothing and say nothing about the time left
                for future in as_completed(futures):
                    done, graded = done + 1, graded + bool(future.result())
                    left = (time.monotonic() - begin) / max(graded, 1) * (len(futures) - done)
                    progress.step(f"{done} of {len(futures)}" + (f", about {duration(left)} left" if graded and left else ""),
                                  in_pipes=True)
        finally:
            pool.shutdown(wait=True, cancel_futures=True)

    def grade_one(self, name: str, paths: list) -> bool:
        """Writes the folder of one submission, unless all its stages have been judged already; whether it had to be graded."""
        submission, path = collect(*paths), paths[0]
        key = outputs.short_hash(f"{submission.key()} {self.key} {submission.faults}")
        folder = self.out / name
        known = read_record(folder, self.say)
        same = known is not None and known["key"] == key
        judged = known["stages"] if same else []
        lacking = [stage for stage in self.stages if stage["id"] not in {row["id"] for row in judged}]
        if same and not lacking and "error" not in known:
            return False
        record = {"name": name, "path": os.fsencode(path).decode("utf-8", "backslashreplace"), "key": key, "content": submission.key(), "seed": self.seed, "sandbox": self.toolchain.box.name,
                  "handed_in": handed_in(*paths), **gradescope(path.parent).get(path.name, {}),
                  **grade(submission, self.toolchain, lacking or self.stages, self.rubric, self.seed, self.cached, self.by_blanks)}
        if processes.stopped_by() is not None:
            return False  # its programs were ended: this is no verdict
        if known and known["stages"] and "error" in record:
            record = {**known, "error": record["error"]}  # a fault of ours never replaces a mark
        else:
            order = [stage["id"] for stage in STAGES]
            record["solved"] = {**(known.get("solved", {}) if same else {}), **record.get("solved", {})}
            record["stages"] = sorted([*judged, *record["stages"]], key=lambda row: order.index(row["id"]))
        record["fingerprint"] = likeness.fingerprint(submission.files)
        folder.mkdir(exist_ok=True)
        seen = mark(limit_to(json.loads(json.dumps(record)), self.stages), self.rubric)
        outputs.write_one(folder, seen, self.say)
        pages.write_feedback(folder, seen, self.say)
        write_whole(folder / "record.json", json.dumps(record, ensure_ascii=False, indent=1), "backslashreplace")  # last: now it is done
        return True

    def cached(self, file: str, stages: list, content: bytes, make):
        """The same content is compiled and judged once, also if two submissions bring it at the same time."""
        key = outputs.short_hash(f"{file} {outputs.short_hash(content)} {self.key} {[stage['id'] for stage in stages]}")
        path = self.out / ".cache" / f"{key}.json"
        with self.guard:
            lock = self.locks.setdefault(key, threading.Lock())
        with lock:
            try:
                return json.loads(path.read_text(encoding="utf-8"))
            except (OSError, ValueError):
                pass
            result = make()
            if processes.stopped_by() is None and result["complete"]:
                path.parent.mkdir(exist_ok=True)
                write_whole(path, json.dumps(result, ensure_ascii=False), "backslashreplace")
            return result


def read_record(folder: Path, say: Speaker):
    try:
        record = json.loads((folder / "record.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    # A record of another version of the course may hold sentences that are gone, or that want other values.
    record["faults"] = [fault for fault in record["faults"] if say.knows(fault)]
    for row in record["stages"]:
        if not all(map(say.knows, said_in(row["diagnosis"]))):
            row["diagnosis"] = because("grade.of_another_version")
    return record


def limit_to(record: dict, stages: list) -> dict:
    """The record with the requested stages only, and its status then: one of them may not have been judged yet."""
    asked = [stage["id"] for stage in stages]
    record["stages"] = [row for row in record["stages"] if row["id"] in asked]
    lacking = set(asked) - {row["id"] for row in record["stages"]}
    if record["status"] != "infrastructure-error":
        record["status"] = "graded" if all(row["state"] != "unread" for row in record["stages"]) else "not-read"
        if lacking:
            record.update(status="not-judged")
            record.setdefault("error", sentence("grade.stages_lacking", stages=", ".join(stage for stage in asked if stage in lacking)))
    return record


def judged_in(out: Path, say: Speaker) -> list:
    """The stages that any record has: a class that was never asked for the others lacks none of them. All where there is no record."""
    judged = {row["id"] for path in out.glob("*/") if (record := read_record(path, say)) for row in record["stages"]}
    return [stage for stage in STAGES if stage["id"] in judged] or STAGES


def read_records(out: Path, stages: list, rubric: dict, say: Speaker) -> list:
    """All that are there, also those of other shards, by name, with the points of the rubric as it is now."""
    folders = sorted(path for path in out.iterdir() if path.is_dir())
    return [mark(limit_to(record, stages), rubric) for folder in folders if (record := read_record(folder, say))]


def tell(out: Path, records: list, looked_at: list, arguments, say: Speaker) -> None:
    for who, why in looked_at[:MOST_TOLD]:
        who = outputs.plain(who)
        warn(f"{who if len(who) < 300 else who[:300] + '…'}: {outputs.plain(why)}")
    if len(looked_at) > MOST_TOLD:
        warn(say("grade.and_more", n=len(looked_at) - MOST_TOLD))
    if arguments.json:
        jsonout.emit({"out": str(out), "records": [{key: record.get(key) for key in ("name", "status", "score", "points", "sandbox")}
                                                   for record in records]})
        return
    older = [record["name"] for record in records
             if any(cause_of(row["diagnosis"]) == "grade.of_another_version" for row in record["stages"])]
    if older:
        warn(say("grade.of_another_version_are", names=say("grade.list").join(older)))
    graded = [record for record in records if record["status"] == "graded"]
    for record in graded if len(graded) <= 20 else []:
        states = "  ".join(f"{row['id']} {pages.state_of(row, say)}" for row in record["stages"])
        print(f"{record['name']}: {pages.points_of(record, say)}   {states}")
    print(say("grade.written_shard", n=len(records), path=str(out)) if arguments.shard else
          say("grade.written", n=len(records), path=str(out / "summary.html")))
