"""What other systems read of a grade: Gradescope, JUnit, Autolab; and the tables of a class."""

import csv
import hashlib
import json
import re
from pathlib import Path
from xml.etree import ElementTree

from ch5_backend.figures.atomic_write import atomic_write, write_whole

from ..homework.diagnosis import in_full, in_short
from ..homework.regions import check_in_words
from ..base.language import Speaker, speaker

# What neither XML nor a terminal takes, and the marks that turn the direction of writing, so that a line reads as another.
CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]")


def short_hash(text) -> str:
    return hashlib.sha256(text if isinstance(text, bytes) else text.encode("utf-8", "surrogateescape")).hexdigest()[:24]


def plain(text: str) -> str:
    """Without control characters, which a student's code or file may hold."""
    return CONTROL.sub("�", text)


def words_on(row: dict, say: Speaker) -> str:
    """A stage's verdict for a human."""
    return plain(in_full(row["diagnosis"], row["output"], say))


def write_one(folder: Path, record: dict, say: Speaker) -> None:
    write_changed(folder / "results.json", json.dumps(gradescope(record, say), ensure_ascii=False, indent=1))
    write_changed(folder / "autolab.json", autolab(record) + "\n")
    write_changed(folder / "junit.xml", ElementTree.tostring(junit(record, say).getroot(), encoding="utf-8", xml_declaration=True).decode("utf-8"))


def write_changed(path: Path, text: str) -> None:
    """Where another text is there, or none: a class that is marked again has thousands of files, and most stay as they are."""
    try:
        if path.read_text(encoding="utf-8") == text:
            return
    except (OSError, ValueError):
        pass
    write_whole(path, text)


def gradescope(record: dict, say: Speaker = speaker("en")) -> dict:
    """results.json; without "score" where there is no mark, so that Gradescope asks for a rerun."""
    extra = {"key": record["key"], "seed": record["seed"], "status": record["status"]}
    if record["status"] != "graded":
        words = {"not-read": "\n".join(map(say.text, record.get("faults", ()))), "not-judged": say("grade.partly_judged")}
        return {"output": words.get(record["status"], say("grade.grader_failed")), "extra_data": extra, "tests": []}
    tests = [{"name": f"{row['id']} {row['name']}: {check_in_words(row['id'], check['name'], say)}", "number": row["id"], "score": check["score"],
              "max_score": check["points"], "status": "passed" if check["passed"] else "failed",
              "visibility": "visible", "output_format": "text",
              "output": "" if check["passed"] or any(not other["passed"] for other in row["checks"][:k]) else
                        words_on(row, say)}
             for row in record["stages"] for k, check in enumerate(row["checks"])]
    tests += [{"name": f"{row['id']} {row['name']}: {say('grade.right_blanks')}", "number": row["id"], "max_score": 0,
               "score": round(row["score"] - sum(check["score"] for check in row["checks"]), 6), "visibility": "visible"}
              for row in record["stages"] if row.get("followed")]
    return {"score": record["score"], "execution_time": record["seconds"], "visibility": "visible",
            "stdout_visibility": "hidden", "extra_data": extra, "tests": tests,
            "output": "\n".join([*map(say.text, record["faults"]), say("grade.same_cases", n=record["seed"])])}


def autolab(record: dict) -> str:
    """The line that Autolab expects last on standard output."""
    return json.dumps({"scores": {row["name"]: row["score"] for row in record["stages"]}})


def junit(record: dict, say: Speaker) -> ElementTree.ElementTree:
    suites = ElementTree.Element("testsuites", name=record["name"])
    for row in record["stages"]:
        failures = sum(not check["passed"] for check in row["checks"])
        suite = ElementTree.SubElement(suites, "testsuite", name=f"stage_{row['id']}.{row['name']}", errors="0",
                                       tests=str(len(row["checks"])), failures=str(failures), time=str(row["seconds"]))
        told = False
        for check in row["checks"]:
            case = ElementTree.SubElement(suite, "testcase", classname=f"stage_{row['id']}.{row['name']}",
                                          name=check["name"])
            if not check["passed"]:
                failure = ElementTree.SubElement(case, "failure", message=plain(in_short(row["diagnosis"], say)),
                                                 type=row["state"])
                failure.text, told = ("" if told else words_on(row, say)), True
    return ElementTree.ElementTree(suites)


def write_class(out: Path, records: list, stages: list) -> None:
    """grades.csv: a row for each submission."""
    table = [["name", "status", "score", "points", *(f"stage {stage}" for stage in stages),
              *(f"state {stage}" for stage in stages), "seed", "cpu_seconds", "peak_mib", "key"]]
    for record in records:
        rows = {row["id"]: row for row in record["stages"]}
        graded = record["status"] == "graded"
        table.append([record["name"], record["status"], f"{record['score']:g}" if graded else "",
                      f"{record['points']:g}", *(f"{rows[stage]['score']:g}" if stage in rows and rows[stage]["state"] != "unread" else "" for stage in stages),
                      *(rows[stage]["state"] if stage in rows else "" for stage in stages), record["seed"],
                      record["cpu_seconds"], record["peak_mib"], record["key"]])
    write_table(out / "grades.csv", table)


def write_table(path: Path, rows: list, delimiter: str = ",", encoding: str = "utf-8") -> None:
    with atomic_write(path) as partial, open(partial, "w", newline="", encoding=encoding) as file:
        csv.writer(file, delimiter=delimiter).writerows([harmless(cell) if isinstance(cell, str) else cell for cell in row] for row in rows)


def harmless(text: str) -> str:
    """A cell that no spreadsheet reads as a formula; a number or a dash, as platforms write them, is not one."""
    return text if re.fullmatch(r"[+-]?[\d.,]*", text) or text[:1] not in ("=", "+", "-", "@", "\t", "\r") else "'" + text
