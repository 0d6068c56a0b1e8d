"""./course grade: many submissions at once; each record is written whole as soon as it is there, and never made twice."""

import json
import os
import random
import re
import threading
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from ch5_backend.figures.atomic_write import write_whole

from ..base import jsonout, processes
from ..base.cmake_build import CORES
from ..homework.check import select
from ..homework.diagnosis import because, cause_of, said_in
from ..base.errors import CourseError, warn
from ..base.language import Speaker, speaker
from ..base.output_dir import locked_dir, made_dir
from ..base.progress import Progress, duration
from . import classbook, likeness, outputs, pages, summary
from .job import grade
from .rubric import PATH, read_rubric
from .sandbox import Sandbox, Unguarded, preflight
from .submission import collect, handed_in, refuse
from .toolchain import Infrastructure, Toolchain

ASSIGNMENT = "Chapter 5"  # the name of the column in Canvas and Moodle
OWN_FILES = ("grades.csv", "summary.html", "session.json", "students.csv", "canvas.csv", "moodle.csv")  # beside the submissions' folders
LONGEST_NAME = 200  # bytes
VERSION = 2  # of the records; another one is graded again


def run_grade(arguments) -> int:
    """Grades what has no record yet, then writes the class's tables from all records; 0, or 1 if a fault of ours is left."""
    refuse(arguments)
    stages, rubric = select(arguments.stages), read_rubric()
    points = {stage["id"]: sum(rubric.get(stage["id"], {}).values()) for stage in stages}
    book = the_class(arguments, points)
    lacking = [stage["id"] for stage in stages if stage["id"] not in rubric]
    if lacking:
        raise CourseError(f"{PATH}: no points for stage {', '.join(lacking)}")
    submissions = named([Path(path) for path in arguments.submissions])
    if arguments.trust:
        warn("--trust: NO SANDBOX. The submissions' code runs as you, with all that you may do.")
    else:
        preflight()
    box = Unguarded if arguments.trust else Sandbox
    if arguments.prepare:
        ready_toolchain(box)
        print("ready: the sandbox holds, and the compilers work in it")
        return 0
    out = Path(arguments.out or "out/grades")
    with made_dir(out) if arguments.shard else locked_dir(out):  # shards may work side by side
        toolchain, say = ready_toolchain(box), speaker(arguments.language)
        session = Session(out, toolchain, stages, rubric, the_seed(out, arguments.seed), say)
        session.grade_all(share(submissions, arguments.shard), arguments.jobs or CORES)
        records = read_records(out, say)
        if not arguments.shard:
            outputs.write_class(out, records, [stage["id"] for stage in stages])
            marks, nobodys = classbook.settle(book, records, points) if book else ([], [])
            for name, rows in (classbook.tables(book, marks, points, ASSIGNMENT) if book else {}).items():
                outputs.write_table(out / name, rows)
            summary.write(out, records, points, book, marks, nobodys, say)
            if nobodys:
                warn(say("grade.nobodys", names=say("grade.list").join(nobodys)))
    failed = [record for record in records if "error" in record]
    tell(out, records, failed, arguments.json, say)
    return 1 if failed else 0


def the_class(arguments, points: dict):
    """The class that was named, or None. Raises CourseError."""
    if not arguments.class_file:
        if arguments.due or arguments.late is not None or arguments.keep:
            raise CourseError("--due, --late and --keep need --class FILE; see ./course grade --help")
        return None
    book = classbook.read_class(Path(arguments.class_file), points)
    book.due = classbook.read_time("--due", arguments.due) if arguments.due else None
    book.percent_a_day = book.percent_a_day if arguments.late is None else arguments.late
    book.keep = arguments.keep or book.keep
    return book


def ready_toolchain(box) -> Toolchain:
    toolchain = Toolchain(box)
    try:
        toolchain.prepare()
    except Infrastructure as error:
        raise CourseError(f"nothing was graded: {error}", exit_code=1) from error
    return toolchain


def named(paths: list) -> dict:
    """{name of its folder: path}; submissions of one name are told apart by the folders that they lie in."""
    names = {}
    for path in paths:
        path = path.absolute()
        if path in names.values():
            raise CourseError(f"{path}: this submission is named twice")
        parts = [part for part in path.parts if part != path.anchor]
        tries = ["-".join(parts[-depth:]) for depth in range(1, len(parts) + 1)]
        tries.append(f"{tries[0]}-{outputs.short_hash(str(path))}")  # where the letters that differ are none of a name
        names[next(name for name in map(folder_name, tries) if name not in names and name not in OWN_FILES)] = path
    return names


def folder_name(text: str) -> str:
    """With the letters of any language, and of what is not UTF-8 the bytes."""
    text = re.sub("[\udc80-\udcff]", lambda byte: f"_{ord(byte[0]) - 0xdc00:X}", text)
    name = re.sub(r"[^\w.@ +-]", "_", text).encode()[-LONGEST_NAME:].decode("utf-8", "ignore")
    return name.strip(". ") or "_"


def share(submissions: dict, shard) -> dict:
    """The I-th of N shares, by place in the list."""
    index, count = shard or (1, 1)
    return {name: path for k, (name, path) in enumerate(submissions.items()) if k % count == index - 1}


def the_seed(out: Path, asked) -> int:
    """The seed asked for, or that of the records that are there, or a new one that nobody can guess."""
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

    def __init__(self, out: Path, toolchain: Toolchain, stages: list, rubric: dict, seed: int, say: Speaker):
        self.out, self.toolchain, self.stages, self.rubric, self.seed = out, toolchain, stages, rubric, seed
        self.say = say
        points = {stage["id"]: rubric[stage["id"]] for stage in stages}
        self.key = f"{VERSION} {toolchain.digest} {seed} {json.dumps(points, sort_keys=True)}"
        self.locks, self.guard = {}, threading.Lock()

    def grade_all(self, submissions: dict, jobs: int) -> None:
        begin, done = time.monotonic(), 0
        pool = ThreadPoolExecutor(jobs)
        try:
            with Progress("grade") as progress:
                futures = [pool.submit(self.grade_one, name, path) for name, path in submissions.items()]
                graded = 0  # those that had a record cost nothing and say nothing about the time left
                for future in as_completed(futures):
                    done, graded = done + 1, graded + bool(future.result())
                    left = (time.monotonic() - begin) / max(graded, 1) * (len(futures) - done)
                    progress.step(f"{done} of {len(futures)}" + (f", about {duration(left)} left" if graded and left else ""),
                                  in_pipes=True)
        finally:
            pool.shutdown(wait=True, cancel_futures=True)

    def grade_one(self, name: str, path: Path) -> bool:
        """Writes the folder of one submission, unless its record is there already; whether it had to be graded."""
        submission = collect(path)
        key = outputs.short_hash(f"{submission.key()} {self.key} {submission.faults}")
        folder = self.out / name
        known = read_record(folder, self.say)
        if known and known["key"] == key and known["status"] == "graded":
            self.tell(folder, known)  # perhaps in another language
            return False
        record = {"name": name, "path": os.fsencode(path).decode("utf-8", "backslashreplace"), "key": key, "content": submission.key(), "seed": self.seed,
                  "handed_in": handed_in(path), **grade(submission, self.toolchain, self.stages, self.rubric, self.seed, self.cached)}
        if processes.stopped_by() is not None:
            return False  # its programs were ended: this is no verdict
        if known and known["status"] == "graded" and record["status"] != "graded":
            record = {**known, "error": record["error"]}  # a fault of ours never replaces a mark
        record["fingerprint"] = likeness.fingerprint(submission.files)
        folder.mkdir(exist_ok=True)
        self.tell(folder, record)
        write_whole(folder / "record.json", json.dumps(record, ensure_ascii=False, indent=1), "backslashreplace")  # last: now it is done
        return True

    def tell(self, folder: Path, record: dict) -> None:
        """What is read of a record, which itself belongs to no language."""
        outputs.write_one(folder, record, self.say)
        pages.write_feedback(folder, record, self.say)

    def cached(self, file: str, content: bytes, make):
        """The same content is compiled and judged once, also if two submissions bring it at the same time."""
        key = outputs.short_hash(f"{file} {outputs.short_hash(content)} {self.key}")
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


def read_records(out: Path, say: Speaker) -> list:
    """All that are there, also those of other shards, by name."""
    folders = sorted(path for path in out.iterdir() if path.is_dir())
    return [record for folder in folders if (record := read_record(folder, say))]


def tell(out: Path, records: list, failed: list, as_json: bool, say: Speaker) -> None:
    for record in failed:
        warn(f"{record['name']}: not graded: {record['error']}")
    if as_json:
        jsonout.emit({"out": str(out), "records": [{key: record[key] for key in ("name", "status", "score", "points")}
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
    print(say("grade.written", n=len(records), path=str(out / "summary.html")))
