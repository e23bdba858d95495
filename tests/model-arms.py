#!/usr/bin/env python3
"""Moment arms of lines over OpenSim's models, to judge moment-arm: by central differences of path lengths over frames of 4 x 4 matrices.

model-arms.py arms MODEL.osim TABLE LIMIT        every arm of TABLE (moment-arm's output over one coordinate) within LIMIT metres, all other
                                                 coordinates at rest; muscles of fixed points only. Prints a line of figures.
model-arms.py share MODEL.osim TABLE LINE LIMIT  the mean arms of the one muscle of TABLE within LIMIT x the arm of the model's muscle LINE
model-arms.py tube MODEL.osim LINE RADIUS        a tube around the line from the first to the last point of LINE, at rest, z up: an OFF mesh; its
                                                 rings lie every RADIUS or less
Status 1 where a limit is passed. Only the standard library is used.
"""
import importlib.util
import math
import os
import sys

spec = importlib.util.spec_from_file_location("model_fk", os.path.join(os.path.dirname(os.path.abspath(__file__)), "model-fk.py"))
fk = importlib.util.module_from_spec(spec)
spec.loader.exec_module(fk)

STEP = 1e-5  # rad


def points_of(model, muscle):
    """(body, place in it) of each point of a path; fixed ones only."""
    for force in model.model.find("ForceSet/objects"):
        if force.get("name") != muscle:
            continue
        points = force.find("GeometryPath/PathPointSet/objects")
        if any(p.tag != "PathPoint" for p in points):
            raise SystemExit(muscle + " has points that are not fixed")
        return [(fk.text_of(p, "body", "socket_parent_frame").split("/")[-1], fk.numbers(fk.text_of(p, "location"))) for p in points]
    raise SystemExit("the model has no muscle " + muscle)


def length(model, points, q):
    frames = model.frames(q)
    places = [fk.point(frames[body], place) for body, place in points]
    return sum(math.dist(a, b) for a, b in zip(places, places[1:]))


def arm(model, points, coordinate, angle):
    q = dict(model.default)
    ends = []
    for side in (1, -1):
        q[coordinate] = angle + side * STEP
        ends.append(length(model, points, q))
    return -(ends[0] - ends[1]) / (2 * STEP)


def read_table(path):
    lines = [line.rstrip("\n").split("\t") for line in open(path)]
    rows = [dict(zip(lines[0], line)) for line in lines[1:]]
    assert rows, "no arm in " + path
    for row in rows:
        name = row["coordinate"]
        row["coordinate"] = name.split("/")[-2] if name.startswith("/") else name.removesuffix(".rad")
    return rows


def arms(model_path, table, limit):
    model = fk.Osim(model_path)
    worst = {}
    for row in read_table(table):
        line = points_of(model, row["muscle"])
        own = arm(model, line, row["coordinate"], math.radians(float(row["angle"])))
        assert abs(own) > 1e-3, (row, own)
        worst[row["muscle"]] = max(worst.get(row["muscle"], 0.0), abs(own - float(row["arm"])))
    print("; ".join(f"{name}: {value:.2g} m" for name, value in worst.items()))
    return max(worst.values()) <= float(limit)


def share(model_path, table, name, limit):
    model = fk.Osim(model_path)
    line = points_of(model, name)
    worst = 0.0
    for row in read_table(table):
        own = arm(model, line, row["coordinate"], math.radians(float(row["angle"])))
        worst = max(worst, abs(float(row["arm"]) / own - 1))
    print(f"{name}: {100 * worst:.3g} % of the line's arm")
    return worst <= float(limit)


def tube(model_path, name, radius):
    model, radius = fk.Osim(model_path), float(radius)
    frames = model.frames(dict(model.default))
    body = points_of(model, name)
    a, b = (fk.point(frames[where], place) for where, place in (body[0], body[-1]))
    a, b = ([p[0], -p[2], p[1]] for p in (a, b))  # y up to z up
    axis = [(v - u) / math.dist(a, b) for u, v in zip(a, b)]
    cross = lambda u, v: [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    side = cross(axis, [1.0, 0.0, 0.0])
    side = [s / math.hypot(*side) for s in side]
    other = cross(axis, side)
    around, along = 16, math.ceil(math.dist(a, b) / radius) + 1
    vertices, faces = [], []
    for i in range(along):
        for k in range(around):
            c, s = radius * math.cos(2 * math.pi * k / around), radius * math.sin(2 * math.pi * k / around)
            vertices.append([a[j] + (b[j] - a[j]) * i / (along - 1) + c * side[j] + s * other[j] for j in range(3)])
    ring = lambda i, k: around * i + k % around
    for i in range(along - 1):
        for k in range(around):
            faces += [(ring(i, k), ring(i, k + 1), ring(i + 1, k + 1)), (ring(i, k), ring(i + 1, k + 1), ring(i + 1, k))]
    vertices += [a, b]
    for k in range(around):
        faces += [(ring(0, k + 1), ring(0, k), len(vertices) - 2), (ring(along - 1, k), ring(along - 1, k + 1), len(vertices) - 1)]
    print(f"OFF\n{len(vertices)} {len(faces)} 0")
    for v in vertices:
        print(*(repr(x) for x in v))
    for f in faces:
        print(3, *f)
    return True


if __name__ == "__main__":
    sys.exit(0 if {"arms": arms, "share": share, "tube": tube}[sys.argv[1]](*sys.argv[2:]) else 1)
