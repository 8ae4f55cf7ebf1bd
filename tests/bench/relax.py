"""GTSAM on pose graphs: a request a line of JSON in, an answer a line out. The rival in `tests/bench/relax.rs`."""

import json
import os
import sys
import time

import gtsam
import numpy as np

# One thread: GTSAM's wheel brings a pool of its own.
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


def graph_of(request):
    graph = gtsam.NonlinearFactorGraph()
    start = gtsam.Values()
    for number, pose in enumerate(request["poses"]):
        start.insert(number, gtsam.Pose2(*pose))
    anchor = gtsam.noiseModel.Diagonal.Sigmas(np.full(3, 1e-6))
    graph.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(*request["poses"][0]), anchor))
    for i, j, x, y, theta, a, b, c, d, e, f in request["edges"]:
        information = np.array([[a, b, c], [b, d, e], [c, e, f]])
        noise = gtsam.noiseModel.Gaussian.Information(information)
        graph.add(gtsam.BetweenFactorPose2(int(i), int(j), gtsam.Pose2(x, y, theta), noise))
    return graph, start


def optimizer(graph, start, method):
    if method == "gauss-newton":
        return gtsam.GaussNewtonOptimizer(graph, start, gtsam.GaussNewtonParams())
    return gtsam.LevenbergMarquardtOptimizer(graph, start, gtsam.LevenbergMarquardtParams())


def answer(request):
    since = time.process_time()
    graph, start = graph_of(request)
    told = {"setup": time.process_time() - since, "seconds": None, "error": None, "iterations": 0, "own": 0.0, "poses": []}
    spent = 0.0
    for _ in range(request["repetitions"]):
        since = time.process_time()
        try:
            running = optimizer(graph, start, request["method"])
            values = running.optimize()
        except RuntimeError as error:
            told["error"] = str(error).strip().splitlines()[0]
            return told
        seconds = time.process_time() - since
        spent += seconds
        told["seconds"] = min(seconds, told["seconds"] or seconds)
        if spent > request["patience"]:
            break
    told["iterations"] = running.iterations()
    told["own"] = 2.0 * graph.error(values)
    poses = (values.atPose2(number) for number in range(len(request["poses"])))
    told["poses"] = [[pose.x(), pose.y(), pose.theta()] for pose in poses]
    return told


for line in sys.stdin:
    print(json.dumps(answer(json.loads(line))), flush=True)
