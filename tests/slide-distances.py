#!/usr/bin/python3
# How far what slides is from what it slides on in the last frame, beside that at rest: the mean over all free vertices that have candidates,
# and how much each has changed, in the mean. Usage: slide-distances.py DOCUMENTS FRAMES: the folder of the tied muscles (in metres), and that
# of their point caches.
import glob, json, math, struct, sys


def sub(x, y): return (x[0] - y[0], x[1] - y[1], x[2] - y[2])


def dot(x, y): return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]


def along(a, b, t): return tuple(p + t * (q - p) for p, q in zip(a, b))


def to_segment(p, a, b):
    ab = sub(b, a)
    length = dot(ab, ab)
    return math.dist(p, along(a, b, min(max(dot(sub(p, a), ab) / length, 0.0), 1.0) if length > 0.0 else 0.0))


def to_triangle(p, a, b, c):
    ab, ac, ap = sub(b, a), sub(c, a), sub(p, a)
    aa, bb, cc, d, e = dot(ab, ab), dot(ab, ac), dot(ac, ac), dot(ab, ap), dot(ac, ap)
    area = aa * cc - bb * bb
    if area > 0.0:
        v, w = (cc * d - bb * e) / area, (aa * e - bb * d) / area
        if v >= 0.0 and w >= 0.0 and v + w <= 1.0:
            return math.dist(p, tuple(a[k] + v * ab[k] + w * ac[k] for k in range(3)))
    return min(to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a))


def last_frame(path):
    data = open(path, "rb").read()
    points, samples = struct.unpack("<i", data[16:20])[0], struct.unpack("<i", data[28:32])[0]
    numbers = struct.unpack("<%df" % (3 * points), data[32 + 12 * points * (samples - 1):32 + 12 * points * samples])
    return [numbers[i:i + 3] for i in range(0, 3 * points, 3)]


def targets_of(document, names):
    """vertex -> (distance at rest, name) of each of its targets among the muscles"""
    held = {v for attachment in document["attachments"] for v in attachment["vertices"]}
    found = {}
    for external in document["externals"]:
        for v, distance in zip(external["vertices"], external["distances"]):
            if external["target"] in names and v not in held:
                found.setdefault(v, []).append((abs(distance), external["target"]))
    return found


documents = {d["name"]: d for d in (json.load(open(path)) for path in glob.glob(sys.argv[1] + "/*.muscle.json"))}
places = {name: last_frame(sys.argv[2] + "/" + name + ".pc2") for name in documents}
triangles = {name: [d["mesh"]["triangles"][i:i + 3] for i in range(0, len(d["mesh"]["triangles"]), 3)] for name, d in documents.items()}
rest, now = [], []
for name, document in documents.items():
    for v, targets in targets_of(document, documents).items():
        rest.append(min(targets)[0])
        now.append(min(to_triangle(places[name][v], *(places[target][corner] for corner in t)) for _, target in targets for t in triangles[target]))
mean = sum(rest) / len(rest)
print("%d vertices slide %.3f mm from their targets in the mean, %.3f at rest; each has changed by %.1f %% of that in the mean" % (
    len(now), 1e3 * sum(now) / len(now), 1e3 * mean, 100 * sum(abs(a - b) for a, b in zip(now, rest)) / len(now) / mean))
