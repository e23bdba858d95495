#!/usr/bin/python3
"""Do the triggers "strike_l" and "strike_r" of a report of motion-sense fire at the strikes of the feet of CMU's motion, and at nothing else?

Usage: foot-strikes.py MOTION REPORT FRAMES

Strikes are found by heights alone: the first frame of each stance in which the lower of a foot's joints (ankle, ball) is within 10 mm of its
lowest height over the motion. The floor of the captures rises by 1.5 % along the way, as the lowest points of the stances tell; that is taken
off: heights are those above the longest edge of the lower hull of all of them. A stance ends with a swing, in which the foot is 40 mm up. Each
strike must have one firing within FRAMES, in order, and there must be no other. Prints what it found.
"""
import json
import sys


def multiply(a, b):
    (w, x, y, z), (W, X, Y, Z) = a, b
    return (w * W - x * X - y * Y - z * Z, w * X + x * W + y * Z - z * Y, w * Y - x * Z + y * W + z * X, w * Z + x * Y - y * X + z * W)


def rotate(q, v):
    w, x, y, z = q
    t = (2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0]))
    return (v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0])


def apply(pose, p):
    return tuple(a + b for a, b in zip(rotate(pose[0], p), pose[1]))


def world_poses(joints, frame):
    poses = {}
    for joint in joints:
        key = joint["keys"][frame]
        pose = (key["rotation"], key["translation"])
        if "parent" in joint:
            parent = poses[joint["parent"]]
            pose = (multiply(parent[0], pose[0]), apply(parent, pose[1]))
        poses[joint["name"]] = pose
    return poses


def lower_hull(points):
    hull = []
    for p in sorted(points):
        while len(hull) > 1 and (hull[-1][0] - hull[-2][0]) * (p[1] - hull[-2][1]) <= (hull[-1][1] - hull[-2][1]) * (p[0] - hull[-2][0]):
            hull.pop()
        hull.append(p)
    return hull


def strikes(heights):
    found, least, swung = [], min(heights), False
    for frame, z in enumerate(heights):
        swung = swung or z > least + 0.04
        if z <= least + 0.01 and swung:
            found.append(frame)
            swung = False
    return found


motion, report, allowed = json.load(open(sys.argv[1])), json.load(open(sys.argv[2])), float(sys.argv[3])
joints = motion["joints"]
rest = {j["name"]: j["rest"] for j in joints}
frames = len(joints[0]["keys"])
poses = [world_poses(joints, f) for f in range(frames)]
begin, end = (apply(p["root"], rest["root"]) for p in (poses[0], poses[-1]))
way = [end[i] - begin[i] for i in (0, 1)]
length = (way[0] ** 2 + way[1] ** 2) ** 0.5


def along(p):
    return (p[0] * way[0] + p[1] * way[1]) / length


lowest = {s: [min((apply(p[s + "foot"], rest[s + k]) for k in ("foot", "toes")), key=lambda q: q[2]) for p in poses] for s in "lr"}
hull = lower_hull((along(p), p[2]) for s in "lr" for p in lowest[s])
a, b = max(zip(hull, hull[1:]), key=lambda edge: edge[1][0] - edge[0][0])
slope = (b[1] - a[1]) / (b[0] - a[0])
assert 0.013 < slope < 0.017 and b[0] - a[0] > 2, (slope, a, b)
for side in "lr":
    fired = [t * motion["rate"] for s in report["sensors"] if s["name"] == "strike_" + side for t in s["fired"]]
    level, raw = strikes([p[2] - slope * along(p) for p in lowest[side]]), strikes([p[2] for p in lowest[side]])
    print(side, "strikes:", level, "by heights as recorded:", raw, "fired:", [round(f, 2) for f in fired])
    assert len(level) >= 2 and set(raw) <= {f + d for f in level for d in range(-3, 4)}
    due = [f for f in level if f < frames - 5]  # a foot that strikes as the motion ends may not have come to rest
    assert len(due) <= len(fired) <= len(level), (level, fired)
    assert all(abs(t - f) <= allowed for f, t in zip(level, fired)), (level, fired)
    for f in raw:
        assert sum(abs(t - f) <= allowed for t in fired) == 1, (raw, fired)
