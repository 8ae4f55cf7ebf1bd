"""Answers for axioms/clingo.rs: a request is a line of JSON with facts, the answer a line with models.

usage: clingo_oracle.py FOLDER, that of the theory files
request: {"facts": text, "preferred": whether only the optimal models are asked for}
answer: for each model its visits, each [observation, place, rotation]
"""

import json
import sys
from pathlib import Path

import clingo

THEORY = ["star", "causal", "topological", "planarity", "boundary", "metrical"]


def solve(folder, facts, preferred):
    options = ["--opt-mode=optN", "--project=show"] if preferred else []
    control = clingo.Control(["0", "--warn=no-other", *options])
    for name in THEORY + ["preference"] * preferred:
        control.load(str(folder / f"{name}.lp"))
    control.add("base", [], facts)
    control.ground([("base", [])])
    models = []
    with control.solve(yield_=True) as handle:
        for model in handle:
            if not preferred or model.optimality_proven:
                atoms = model.symbols(shown=True)
                models.append([[term.number for term in atom.arguments] for atom in atoms])
    return models


def main():
    folder = Path(sys.argv[1])
    for line in sys.stdin:
        request = json.loads(line)
        models = solve(folder, request["facts"], request["preferred"])
        print(json.dumps(models, separators=(",", ":")), flush=True)


main()
