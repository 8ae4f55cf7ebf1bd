"""Answers for tests/bench/perception_rival.rs: a request is a line of JSON, the answer a line of JSON.

request: {"width", "height", "free": whether each cell is free, one byte each, row by row, base64,
          "core": the same of the cells to be thinned, or null, "seconds": how long to repeat each}
answer: {"distance": the distances in cells, float32, base64, "distance_seconds": of the processor, the least,
         "holes": of the core, "skeletons": for each way to a skeleton its name, seconds, the cells as base64 bytes,
         "components" and "loops" of its graph, and "junctions", each [row, column]}
"""

import base64
import json
import sys
import time
import warnings

import cv2
import networkx
import numpy
import sknw
from scipy import ndimage
from skimage.morphology import medial_axis, skeletonize

warnings.filterwarnings("ignore")
cv2.setNumThreads(1)


def least(work, seconds):
    """The result of some work, and the least time on the processor it took in so many seconds."""
    best, begun = float("inf"), time.perf_counter()
    result = work()  # Warm: what is compiled on first use is compiled now.
    while best == float("inf") or time.perf_counter() - begun < seconds:
        start = time.thread_time()
        result = work()
        best = min(best, time.thread_time() - start)
    return result, best


def packed(array):
    return base64.b64encode(numpy.ascontiguousarray(array).tobytes()).decode()


def cut_to(core):
    """The smallest part of an array that holds what is true, in a frame of one cell."""
    first_last = [numpy.flatnonzero(core.any(axis=axis))[[0, -1]] for axis in (1, 0)]
    return tuple(slice(max(first - 1, 0), last + 2) for first, last in first_last)


def skeletons(core, seconds):
    whole = slice(0, None), slice(0, None)
    ways = [("skeletonize", skeletonize, whole), ("cut, skeletonize", skeletonize, cut_to(core)),
            ("medial_axis", medial_axis, whole)]
    for name, thin, part in ways:
        def graph_of():
            cells = thin(core[part])
            return cells, sknw.build_sknw(cells.astype(numpy.uint16), multi=True)

        (cells, graph), took = least(graph_of, seconds)
        found = numpy.zeros(core.shape, numpy.uint8)
        found[part] = cells
        components = networkx.number_connected_components(graph)
        loops = graph.number_of_edges() - graph.number_of_nodes() + components
        corner = [rows_or_columns.start for rows_or_columns in part]
        junctions = [list(map(float, graph.nodes[n]["o"] + corner)) for n in graph.nodes if graph.degree(n) >= 3]
        yield {"name": name, "seconds": took, "cells": packed(found), "components": components,
               "loops": loops, "junctions": junctions}


def main():
    for line in sys.stdin:
        request = json.loads(line)
        shape = request["height"], request["width"]
        grid = lambda name: numpy.frombuffer(base64.b64decode(request[name]), numpy.uint8).reshape(shape)
        free = grid("free").copy()
        field = lambda: cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        distance, took = least(field, request["seconds"])
        answer = {"distance": packed(distance.astype(numpy.float32)), "distance_seconds": took}
        if request["core"] is not None:
            core = grid("core").astype(bool)
            # Sides alone join what is not in the core; the outside is one piece of it.
            _, pieces = ndimage.label(numpy.pad(~core, 1, constant_values=True))
            answer["holes"] = pieces - 1
            answer["skeletons"] = list(skeletons(core, request["seconds"]))
        print(json.dumps(answer), flush=True)


main()
