"""Answers for tests/bench/rival.rs: a request is a line of JSON, the answer a line of JSON.

usage: rival.py FOLDER, that of the theory files
request: {"facts": text, "preferred": whether only the optimal models are asked for, "threads": how many,
          "tell": whether the models are told, "seconds": when to stop}
answer: {"wall": seconds of grounding and solving, "processor": those on all processors, "models": how many, "whole": whether it came to an end,
         "visits": for each model told its visits, each [observation, place, rotation]}
"""

import json
import sys
import time
from pathlib import Path

import clingo

THEORY = ["star", "causal", "topological", "planarity", "boundary", "metrical"]


def solve(folder, request):
    preferred = request["preferred"]
    options = ["--opt-mode=optN", "--project=show"] if preferred else []
    options += [f"--parallel-mode={request['threads']}"] if request["threads"] > 1 else []
    control = clingo.Control(["0", "--warn=no-other", *options])
    for name in THEORY + ["preference"] * preferred:
        control.load(str(folder / f"{name}.lp"))
    control.add("base", [], request["facts"])
    visits = []

    def keep(model):
        if not preferred or model.optimality_proven:
            atoms = model.symbols(shown=True)
            visits.append([[term.number for term in atom.arguments] for atom in atoms])

    begun, idle = time.perf_counter(), time.process_time()
    control.ground([("base", [])])
    # Without a callback nothing is made of a model but a count of one more.
    with control.solve(on_model=keep if request["tell"] else None, async_=True) as handle:
        whole = handle.wait(request["seconds"])
        if not whole:
            handle.cancel()
        handle.get()
    wall, processor = time.perf_counter() - begun, time.process_time() - idle
    counts = control.statistics["summary"]["models"]
    return {
        "wall": wall,
        "processor": processor,
        "models": int(counts["optimal" if preferred else "enumerated"]),
        "whole": whole,
        "visits": visits,
    }


def main():
    folder = Path(sys.argv[1])
    for line in sys.stdin:
        print(json.dumps(solve(folder, json.loads(line)), separators=(",", ":")), flush=True)


main()
