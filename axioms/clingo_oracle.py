"""Answers for axioms/clingo.rs: a request is a line of JSON with a program, the answer a line with models.

request: {"program": text, "preferred": whether only the optimal models are asked for}
answer: for each model its atoms shown
"""

import json
import sys

import clingo


def solve(program, preferred):
    options = ["--opt-mode=optN", "--project=show"] if preferred else []
    control = clingo.Control(["0", "--warn=no-other", *options])
    control.add("base", [], program)
    control.ground([("base", [])])
    models = []
    with control.solve(yield_=True) as handle:
        for model in handle:
            if not preferred or model.optimality_proven:
                models.append([str(atom) for atom in model.symbols(shown=True)])
    return models


def main():
    for line in sys.stdin:
        models = solve(**json.loads(line))
        print(json.dumps(models, separators=(",", ":")), flush=True)


main()
