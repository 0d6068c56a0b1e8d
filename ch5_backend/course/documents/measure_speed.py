"""Measures what the fifth lecture shows, and writes the tables that are kept in slides/measured/.

usage: python3 -m ch5_backend.course.documents.measure_speed [--rounds N] [--bench DIR] [--no-bench] [--out DIR]

Each round runs every case once, so that a slow quarter of an hour of the machine falls on all alike; of each step the
fastest round counts, since whatever disturbs a measurement makes it slower. Needs Ceres and the data folder, CH5_DATA_DIR.
About a minute on a machine that does nothing else, and then ./course bench. --bench DIR measures nothing: it keeps what
./course bench has written to DIR, out/bench as a rule. Of each processor and problem the last rows are kept.
"""

import argparse
import csv
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from ch5_backend.figures import tables
from slides.deck_fast_solver_facts import PROBLEMS, RUNGS

from ..base.cmake_build import BIN, ROOT, build_or_fail
from ..experiments.bench import processor, source

MEASURED = ROOT / "slides" / "measured"
MACHINE = ("processor", "date", "rounds", "load")  # of a kept table
KEPT = ("problem", "setting", "threads", "ours_ms", "peer", "peer_way", "peer_ms", "ratio", "ours_cost", "peer_cost", "ours_peak_mb",
        "peer_peak_mb")
SHOWN = ("bal/49-7776", "window/real_euroc_sub2", "pose_graph/intel")  # by the README, cost over time: real data of three kinds
REDUCED = ("sparse", "implicit-pcg", "power-series")  # solvers for the cameras' system of the largest problem


def run(*words, **environment):
    """The lines that a program prints."""
    done = subprocess.run([str(word) for word in words], env={**os.environ, "OPENBLAS_NUM_THREADS": "1", **environment},
                          capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"measure_speed.py: {done.stderr.strip()}")
    return done.stdout.splitlines()


def trace(program, *words):
    """(iteration, seconds, cost) of each iteration of a program that solves a file, one thread."""
    with tempfile.TemporaryDirectory() as out:
        run(BIN / program, *words, "--out", out, "--threads", 1)
        return [(row["iteration"], row["seconds"], row["cost"]) for row in csv_rows(Path(out) / "trace.csv")]


def steps(best):
    for problem in PROBLEMS:
        for solver, simd in RUNGS.values():  # each one idea more than the one before
            if solver == "dense" and problem.startswith("bal/"):
                continue  # its H would take 36 gigabytes
            repeat = 3 if solver != "sparse" else 9
            for line in run(BIN / "measure_steps", source(problem), "--solver", solver, "--repeat", repeat, CH5_SIMD=simd):
                step, time, flop, size = line.split(",")
                key = problem, solver, simd, step
                if key not in best or float(time) < float(best[key][0]):
                    best[key] = time, flop, size


def machine(best):
    for simd in ("portable", "avx2"):
        for line in run(BIN / "measure_steps", "machine", CH5_SIMD=simd):
            *name, value = line.split(",")
            key = simd, name[0], name[1] if len(name) > 1 else "0"
            best[key] = max(best.get(key, "0"), value, key=float)


def keep_traces(folder, about, out):
    """The way down of both sides, for the README, if all that it shows were measured."""
    rows = [row for row in csv_rows(Path(folder) / "traces.csv") if row["problem"] in SHOWN and row["threads"] == "1"]
    if {row["problem"] for row in rows} == set(SHOWN):
        head = ("problem", "threads", "side", "seconds", "cost")
        write(out, "speed_traces", (*MACHINE, *head), [[about.get(key) or row[key] for key in (*MACHINE, *head)] for row in rows])


def keep_peers(folder, out):
    """The table of ./course bench, before what is kept of other problems and processors. Of a machine that does much else the
    rows with two threads are left out: they are measured by the clock."""
    about = csv_rows(Path(folder) / "about.csv")[0]
    keep_traces(folder, about, out)
    busy = float(about["load"]) > 2.0 * int(about["cores"])
    rows = [{**{key: about[key] for key in MACHINE}, **row} for row in csv_rows(Path(folder) / "rows.csv")
            if not (busy and int(row["threads"]) > 1)]
    new = {(row["processor"], row["problem"].split(" ")[0]) for row in rows}
    path = MEASURED / "speed_peers.csv"
    rows += [row for row in csv_rows(path) if (row["processor"], row["problem"].split(" ")[0]) not in new] if path.exists() else []
    write(out, "speed_peers", (*MACHINE, *KEPT), [[row[key] for key in (*MACHINE, *KEPT)] for row in rows])


def csv_rows(path):
    """Each row as words, none of them rounded."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def reduced(rounds):
    """The way of each solver for the cameras' system through 20 iterations, of the fastest round."""
    rows = []
    for solver in REDUCED:
        ways = [trace("ch5_bal", source("bal/maplab-969-22767"), "--iterations", 20, "--solver", solver) for _ in range(rounds)]
        rows += [(solver, *row) for row in min(ways, key=lambda way: float(way[-1][1]))]
    return rows


def refined(rounds):
    """The way through 8 iterations of a window, without and with steps of each landmark alone; of the fastest round."""
    rows = []
    for steps in (0, 2):
        ways = [trace("ch5_window", source("window/vio_M"), "--iterations", 8, "--landmark-steps", steps) for _ in range(rounds)]
        rows += [(steps, *row) for row in min(ways, key=lambda way: float(way[-1][1]))]
    return rows


def rays():
    """The way of 49 cameras through 20 iterations, points moved by x + δ and along their rays."""
    return [(points, *row) for points in ("xyz", "ray")
            for row in trace("ch5_bal", source("bal/49-7776"), "--iterations", 20, "--points", points)]


def write(out, name, head, rows):
    tables.write(out / f"{name}.csv", head, rows)


def main():
    parser = argparse.ArgumentParser(prog="measure_speed.py", description=__doc__.split("\n\n")[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--bench", metavar="DIR", help="keep this folder's tables, and measure nothing")
    parser.add_argument("--out", metavar="DIR", type=Path, default=MEASURED, help="where the tables go, default: slides/measured")
    parser.add_argument("--no-bench", action="store_true", help="leave out ./course bench, which takes half an hour")
    given = parser.parse_args()
    rounds, out = given.rounds, given.out
    if given.bench:
        return keep_peers(given.bench, out)
    build_or_fail(["measure_steps", "ch5_bal", "ch5_window"])
    by_step, limits = {}, {}
    for turn in range(rounds):
        print(f"round {turn + 1} of {rounds}", file=sys.stderr)
        steps(by_step)
        machine(limits)
    write(out, "speed_steps", ("problem", "solver", "simd", "step", "milliseconds", "flop", "bytes"),
          [(*key, *value) for key, value in by_step.items()])
    write(out, "speed_machine", ("simd", "limit", "megabytes", "value"), [(*key, value) for key, value in limits.items()])
    if not given.no_bench:
        with tempfile.TemporaryDirectory() as scratch:
            run(ROOT / "course", "bench", "--out", scratch)
            keep_peers(Path(scratch) / "bench", out)
    about = processor(), time.strftime("%Y-%m-%d"), 1
    write(out, "speed_reduced", ("processor", "date", "threads", "solver", "iteration", "seconds", "cost"), [(*about, *row) for row in reduced(rounds)])
    write(out, "speed_refined", ("landmark_steps", "iteration", "seconds", "cost"), refined(5 * rounds))
    write(out, "speed_rays", ("points", "iteration", "seconds", "cost"), rays())
    write(out, "speed_about", ("processor", "cores", "threads", "rounds", "date"), [(about[0], os.cpu_count(), 1, rounds, about[1])])


if __name__ == "__main__":
    main()
