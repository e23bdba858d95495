#!/usr/bin/env python3
"""Forward kinematics of OpenSim's and MuJoCo's models by 4 x 4 matrices, to judge the library's: it shares no line with it.

model-fk.py origins MODEL.osim MOTION|- CLIP     frames of all bodies, and coordinates, within 1e-9 of CLIP (motion_models --write)
model-fk.py lengths MODEL.osim CLIP LENGTHS.sto  lengths of the muscles' paths over the bodies of CLIP, within 2e-6 m of OpenSim's
model-fk.py mjcf MODEL.xml MOTION|- CLIP         frames of all bodies and centres of joints within 1e-9
model-fk.py bones MODEL MOTION|- DOCUMENT FOLDER vertices of all bones that motion-import --bones has written, moved by the joints of the
                                                 motion document, within 1e-9 m of those of the model's mesh files in FOLDER
model-fk.py trot MODEL.xml MOTION                columns of the dog's trot (share/examples/dog): in the joints' ranges, feet in turn, diagonals
                                                 together, standing where they stand
Prints a line of figures; status 1 where a limit is passed. Only the standard library is used.
"""
import json
import math
import os
import struct
import sys
import xml.etree.ElementTree as ET

# ---- matrices: rows of four ---------------------------------------------------------------------------------------------------------


def identity():
    return [[float(i == j) for j in range(4)] for i in range(4)]


def mul(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def chain(*matrices):
    out = identity()
    for m in matrices:
        out = mul(out, m)
    return out


def shift(v):
    m = identity()
    for i in range(3):
        m[i][3] = v[i]
    return m


def turn(axis, angle):
    """Rodrigues' formula."""
    n = math.sqrt(sum(a * a for a in axis))
    x, y, z = (a / n for a in axis)
    c, s = math.cos(angle), math.sin(angle)
    k = 1 - c
    return [[c + x * x * k, x * y * k - z * s, x * z * k + y * s, 0.0], [y * x * k + z * s, c + y * y * k, y * z * k - x * s, 0.0],
            [z * x * k - y * s, z * y * k + x * s, c + z * z * k, 0.0], [0.0, 0.0, 0.0, 1.0]]


def rigid_inverse(m):
    r = [[m[j][i] for j in range(3)] for i in range(3)]
    t = [-sum(r[i][k] * m[k][3] for k in range(3)) for i in range(3)]
    return [r[0] + [t[0]], r[1] + [t[1]], r[2] + [t[2]], [0.0, 0.0, 0.0, 1.0]]


def quaternion(w, x, y, z):
    n = math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / n, x / n, y / n, z / n
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 0.0],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 0.0],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), 0.0], [0.0, 0.0, 0.0, 1.0]]


def point(m, p):
    return [sum(m[i][k] * p[k] for k in range(3)) + m[i][3] for i in range(3)]


def apart(a, b):
    return max(abs(a[i][j] - b[i][j]) for i in range(4) for j in range(4))


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def body_xyz(angles):
    return chain(turn(X, angles[0]), turn(Y, angles[1]), turn(Z, angles[2]))


# ---- functions ----------------------------------------------------------------------------------------------------------------------


def solve(a, b):
    """Gauss with pivots, dense."""
    n = len(b)
    rows = [list(a[i]) + [b[i]] for i in range(n)]
    for c in range(n):
        p = max(range(c, n), key=lambda r: abs(rows[r][c]))
        rows[c], rows[p] = rows[p], rows[c]
        for r in range(c + 1, n):
            f = rows[r][c] / rows[c][c]
            if f:
                rows[r] = [u - f * v for u, v in zip(rows[r], rows[c])]
    out = [0.0] * n
    for r in range(n - 1, -1, -1):
        out[r] = (rows[r][n] - sum(rows[r][k] * out[k] for k in range(r + 1, n))) / rows[r][r]
    return out


def third_derivative(x, y):
    """Of the cubic through four points: six times the third divided difference."""
    d = list(y)
    for order in range(1, 4):
        d = [(d[i + 1] - d[i]) / (x[i + order] - x[i]) for i in range(len(d) - 1)]
    return 6 * d[0]


class Spline:
    """Second derivatives m_i at the knots: C2, and the third derivative at both ends that of the cubic through four points."""

    def __init__(self, x, y):
        n = len(x)
        self.x, self.y = x, y
        if n == 2:
            self.m = [0.0, 0.0]
            return
        h = [x[i + 1] - x[i] for i in range(n - 1)]
        a = [[0.0] * n for _ in range(n)]
        b = [0.0] * n
        for i in range(1, n - 1):
            a[i][i - 1], a[i][i], a[i][i + 1] = h[i - 1] / 6, (h[i - 1] + h[i]) / 3, h[i] / 6
            b[i] = (y[i + 1] - y[i]) / h[i] - (y[i] - y[i - 1]) / h[i - 1]
        a[0][0], a[0][1], a[n - 1][n - 2], a[n - 1][n - 1] = -1 / h[0], 1 / h[0], -1 / h[-1], 1 / h[-1]
        if n > 3:
            b[0], b[n - 1] = third_derivative(x[:4], y[:4]), third_derivative(x[-4:], y[-4:])
        self.m = solve(a, b)

    def slope(self, i, t):
        h = self.x[i + 1] - self.x[i]
        u, v = self.x[i + 1] - t, t - self.x[i]
        return (self.y[i + 1] - self.y[i]) / h - self.m[i] * (u * u / (2 * h) - h / 6) + self.m[i + 1] * (v * v / (2 * h) - h / 6)

    def __call__(self, t):
        x, y, m = self.x, self.y, self.m
        if t < x[0]:
            return y[0] + (t - x[0]) * self.slope(0, x[0])
        if t > x[-1]:
            return y[-1] + (t - x[-1]) * self.slope(len(x) - 2, x[-1])
        i = max(k for k in range(len(x) - 1) if x[k] <= t)
        h = x[i + 1] - x[i]
        u, v = x[i + 1] - t, t - x[i]
        return m[i] * u ** 3 / (6 * h) + m[i + 1] * v ** 3 / (6 * h) + (y[i] / h - m[i] * h / 6) * u + (y[i + 1] / h - m[i + 1] * h / 6) * v


def numbers(text):
    return [float(w) for w in (text or "").split()]


def text_of(element, *names):
    for name in names:
        child = element.find(name)
        if child is not None and child.text and child.text.strip():
            return child.text.strip()
    return ""


def function_of(element):
    tag = element.tag
    if tag == "Constant":
        value = float(text_of(element, "value"))
        return lambda t: value
    if tag == "LinearFunction":
        a, b = numbers(text_of(element, "coefficients"))
        return lambda t: a * t + b
    if tag == "MultiplierFunction":
        scale, inner = float(text_of(element, "scale")), function_of(held(element, "function"))
        return lambda t: scale * inner(t)
    if tag == "SimmSpline":
        return Spline(numbers(text_of(element, "x")), numbers(text_of(element, "y")))
    raise SystemExit("model-fk.py: no function " + tag)


def held(owner, name):
    wrapped = owner.find(name)
    if wrapped is not None:
        return list(wrapped)[0]
    return next((c for c in owner if c.get("name") == name), None)


# ---- OpenSim ------------------------------------------------------------------------------------------------------------------------


class Osim:
    """Joints as closures: values of coordinates to the frame of the child in its parent."""

    def __init__(self, path):
        self.root = ET.parse(path).getroot()
        self.model = self.root.find("Model")
        self.default, self.rotational, self.joints, self.parent = {}, {}, {}, {}
        joint_set = self.model.find("JointSet")
        if joint_set is not None and joint_set.find("objects") is not None and len(joint_set.find("objects")):
            for joint in joint_set.find("objects"):
                self.version_4(joint)
        else:
            for body in self.model.find("BodySet/objects"):
                joint = body.find("Joint")
                if joint is not None and len(joint):
                    self.version_3(body.get("name"), joint[0])

    def version_3(self, child, joint):
        place = lambda w, o: chain(shift(numbers(text_of(joint, w)) or [0, 0, 0]), body_xyz(numbers(text_of(joint, o)) or [0, 0, 0]))
        coordinates = joint.findall("CoordinateSet/objects/Coordinate")
        self.add(child, text_of(joint, "parent_body"), joint, coordinates, place("location_in_parent", "orientation_in_parent"),
                 place("location", "orientation"))

    def version_4(self, joint):
        frames = {f.get("name"): f for f in joint.findall("frames/PhysicalOffsetFrame")}

        def end(socket):
            frame = frames[text_of(joint, socket)]
            where = chain(shift(numbers(text_of(frame, "translation"))), body_xyz(numbers(text_of(frame, "orientation"))))
            return text_of(frame, "socket_parent").split("/")[-1], where

        parent, inner = end("socket_parent_frame")
        child, outer = end("socket_child_frame")
        self.add(child, parent, joint, joint.findall("coordinates/Coordinate"), inner, outer)

    def add(self, child, parent, joint, coordinates, inner, outer):
        names = [c.get("name") for c in coordinates]
        for c in coordinates:
            self.default[c.get("name")] = float(text_of(c, "default_value") or 0)
            self.rotational[c.get("name")] = text_of(c, "motion_type") == "rotational"
        if joint.tag == "CustomJoint":
            across = self.custom(joint)
        elif joint.tag == "PinJoint":
            self.rotational[names[0]] = True
            across = lambda q: turn(Z, q[names[0]])
        elif joint.tag == "WeldJoint":
            across = lambda q: identity()
        else:
            raise SystemExit("model-fk.py: no joint " + joint.tag)
        back = rigid_inverse(outer)
        self.parent[child] = parent
        self.joints[child] = lambda q: chain(inner, across(q), back)

    def custom(self, joint):
        axes = {}
        for t in joint.findall("SpatialTransform/TransformAxis"):
            f = held(t, "function")
            name = text_of(t, "coordinates")
            axes[t.get("name")] = (numbers(text_of(t, "axis")), name, function_of(f))
            if t.get("name").startswith("rotation") and f.tag == "LinearFunction" and numbers(text_of(f, "coefficients"))[0] == 1:
                self.rotational[name] = True

        def across(q):
            value = lambda n: axes[n][2](q[axes[n][1]] if axes[n][1] else 0.0)
            m = identity()
            for n in ("translation1", "translation2", "translation3"):
                m = mul(m, shift([a * value(n) for a in axes[n][0]]))
            for n in ("rotation1", "rotation2", "rotation3"):
                m = mul(m, turn(axes[n][0], value(n)))
            return m

        return across

    def frames(self, q):
        out = {"ground": identity()}
        while len(out) <= len(self.joints):
            for child, across in self.joints.items():
                if child not in out and self.parent[child] in out:
                    out[child] = mul(out[self.parent[child]], across(q))
        return out


# ---- files --------------------------------------------------------------------------------------------------------------------------


def read_storage(path):
    """Names and rows, and whether angles are degrees."""
    lines = open(path).read().split("\n")
    end = next(i for i, line in enumerate(lines) if line.strip() == "endheader")
    degrees = any(line.strip().lower() == "indegrees=yes" for line in lines[:end])
    names = lines[end + 1].split()
    return names, [[float(w) for w in line.split()] for line in lines[end + 2:] if line.strip()], degrees


def read_clip(path):
    coordinates, joints, last = {}, {}, None
    for line in open(path):
        w = line.rstrip("\n").split("\t")
        if w[0] == "coordinate":
            coordinates[w[1]] = [float(v) for v in w[3:]]
        elif w[0] == "joint":
            last = joints[w[1]] = {"parent": w[2], "rest": [float(v) for v in w[3:6]], "q": quaternion(*[float(v) for v in w[6:10]]), "poses": []}
        elif w[0] == "pose":
            v = [float(u) for u in w[2:]]
            last["poses"].append(chain(shift(v[4:]), quaternion(*v[:4])))
    return coordinates, joints


def body_frame(joint, k):
    """World frame of a body whose joint's centre is its origin."""
    return chain(joint["poses"][k], shift(joint["rest"]), joint["q"])


def coordinate_rows(model, motion):
    """Values of every coordinate, row by row."""
    if motion == "-":
        return [dict(model.default)]
    names, rows, degrees = read_storage(motion)
    out = []
    for row in rows:
        q = dict(model.default)
        for name, value in zip(names[1:], row[1:]):
            short = name.split("/")[-2] if name.startswith("/") else name
            if short in q:
                q[short] = math.radians(value) if degrees and model.rotational[short] else value
        out.append(q)
    return out


# ---- checks -------------------------------------------------------------------------------------------------------------------------


def origins(model_path, motion, clip_path):
    model = Osim(model_path)
    coordinates, joints = read_clip(clip_path)
    rows = coordinate_rows(model, motion)
    assert set(joints) == set(model.joints) and set(coordinates) == set(model.default)
    worst = worst_origin = worst_coordinate = 0.0
    for k, q in enumerate(rows):
        for name, frame in model.frames(q).items():
            if name == "ground":
                continue
            mine = body_frame(joints[name], k)
            worst = max(worst, apart(mine, frame))
            worst_origin = max(worst_origin, *(abs(mine[i][3] - frame[i][3]) for i in range(3)))
        worst_coordinate = max(worst_coordinate, *(abs(coordinates[n][k] - v) for n, v in q.items()))
    assert all(len(j["poses"]) == len(rows) for j in joints.values())
    print(f"{len(rows)} frames, {len(joints)} bodies, {len(coordinates)} coordinates: origins within {worst_origin:.2e} m, "
          f"frames within {worst:.2e}, coordinates within {worst_coordinate:.2e}")
    return worst < 1e-9 and worst_coordinate < 1e-12


def path_points(path, coordinates, k):
    """(body, place) of the points of a path that are active at frame k."""
    for p in path.find("PathPointSet/objects"):
        body = text_of(p, "body") or text_of(p, "socket_parent_frame").split("/")[-1]
        place = numbers(text_of(p, "location"))
        if p.tag == "ConditionalPathPoint":
            name = (text_of(p, "coordinate") or text_of(p, "socket_coordinate")).split("/")[-1]
            low, high = numbers(text_of(p, "range"))
            if not low - 1e-5 <= coordinates[name][k] <= high + 1e-5:
                continue
        if p.tag == "MovingPathPoint":
            place = []
            for a in "xyz":
                name = (text_of(p, a + "_coordinate") or text_of(p, f"socket_{a}_coordinate")).split("/")[-1]
                place.append(function_of(held(p, a + "_location"))(coordinates[name][k]))
        yield body, place


def lengths(model_path, clip_path, sto):
    model = Osim(model_path)
    coordinates, joints = read_clip(clip_path)
    names, rows, _ = read_storage(sto)
    muscles = {m.get("name"): m.find("GeometryPath") for m in model.model.find("ForceSet/objects") if m.find("GeometryPath") is not None}
    worst, where, checked = 0.0, "", 0
    for column, name in enumerate(names[1:], 1):
        muscle = name.split("/")[-1].split("|")[0]
        path = muscles[muscle]
        checked += 1
        for k, row in enumerate(rows):
            points = [point(body_frame(joints[b], k), p) for b, p in path_points(path, coordinates, k)]
            off = abs(sum(math.dist(a, b) for a, b in zip(points, points[1:])) - row[column])
            if off > worst:
                worst, where = off, f"{muscle} in frame {k}"
    print(f"{checked} muscles, {len(rows)} frames: lengths within {worst:.2e} m of OpenSim's ({where})")
    return checked == 18 and worst < 2e-6


# ---- MuJoCo -------------------------------------------------------------------------------------------------------------------------


class Mjcf:
    def __init__(self, path):
        self.root = ET.parse(path).getroot()
        compiler = self.root.find("compiler")
        self.degrees = compiler is None or compiler.get("angle", "degree") == "degree"
        self.defaults = {}
        for d in self.root.findall("default"):
            self.read_default(d, {}, "main")
        self.bodies, self.range = [], {}
        for body in self.root.findall("worldbody/body"):
            self.read_body(body, "", "main")

    def read_default(self, element, inherited, name):
        mine = dict(inherited)
        for joint in element.findall("joint"):
            mine.update(joint.attrib)
        self.defaults[name] = mine
        for d in element.findall("default"):
            self.read_default(d, mine, d.get("class"))

    def orientation(self, element):
        if element.get("quat"):
            return quaternion(*numbers(element.get("quat")))
        if element.get("euler"):
            return body_xyz([math.radians(a) if self.degrees else a for a in numbers(element.get("euler"))])
        return identity()

    def read_body(self, body, parent, style):
        style = body.get("childclass", style)
        joints = []
        for j in body.findall("joint"):
            a = dict(self.defaults[j.get("class", style)])
            a.update(j.attrib)
            self.range[j.get("name")] = numbers(a.get("range"))
            joints.append((j.get("name"), a.get("type", "hinge"), numbers(a.get("pos", "0 0 0")), numbers(a.get("axis", "0 0 1"))))
        place = chain(shift(numbers(body.get("pos", "0 0 0"))), self.orientation(body))
        free = body.find("freejoint")
        self.bodies.append((body.get("name"), parent, place, joints, free.get("name") if free is not None else None))
        for child in body.findall("body"):
            self.read_body(child, body.get("name"), style)

    def frames(self, q):
        """World frame of each body, and the centre of its first joint in it."""
        out, centres = {"": identity()}, {}
        for name, parent, place, joints, free in self.bodies:
            gone = shift([q.get(f"{free}_t{axis}", 0.0) for axis in "xyz"])  # in the world's axes; it is never turned here
            m = chain(gone, out[parent], place)
            for joint, kind, centre, axis in joints:
                assert kind == "hinge"
                m = chain(m, shift(centre), turn(axis, q.get(joint, 0.0)), shift([-c for c in centre]))
            out[name] = m
            centres[name] = joints[0][2] if joints else [0.0, 0.0, 0.0]
        return out, centres


def mjcf_rows(model, motion):
    """Values of the coordinates that a motion tells, row by row."""
    if motion == "-":
        return [{}]
    lengths = {f"{body[4]}_t{axis}" for body in model.bodies if body[4] for axis in "xyz"}
    names, table, degrees = read_storage(motion)
    return [{n: math.radians(v) if degrees and n not in lengths else v for n, v in zip(names[1:], row[1:])} for row in table]


def mjcf(model_path, motion, clip_path):
    model = Mjcf(model_path)
    coordinates, joints = read_clip(clip_path)
    rows = mjcf_rows(model, motion)
    rest, centres = model.frames({})
    worst = 0.0
    for k, q in enumerate(rows):
        frames, _ = model.frames(q)
        for name, _, _, _, _ in model.bodies:
            j, centre = joints[name], centres[name]
            mine = chain(j["poses"][k], shift(j["rest"]), j["q"], shift([-c for c in centre]))
            worst = max(worst, apart(mine, frames[name]), math.dist(point(j["poses"][k], j["rest"]), point(frames[name], centre)))
    moved = max(math.dist(point(frames[n], [0, 0, 0]), point(rest[n], [0, 0, 0])) for n in rest if n)
    count = sum(len(b[3]) for b in model.bodies)
    print(f"{len(rows)} frames, {len(model.bodies)} bodies, {count} hinges: within {worst:.2e}; the last frame moves a body by {moved:.3f} m")
    return worst < 1e-9 and len(joints) == len(model.bodies) and len(coordinates) >= count and (motion == "-" or moved > 0.05)


# ---- bones --------------------------------------------------------------------------------------------------------------------------


def read_ply(path):
    """Positions and triangles of what motion-import writes."""
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + 11
    head = data[:end].decode().split("\n")
    assert head[1] == "format binary_little_endian 1.0" and [h for h in head if h.startswith("property")] == [
        "property double x", "property double y", "property double z", "property list uchar int vertex_indices"], head
    vertices, faces = (int(next(h for h in head if h.startswith("element " + e)).split()[2]) for e in ("vertex", "face"))
    points = [struct.unpack_from("<3d", data, end + 24 * i) for i in range(vertices)]
    return points, [struct.unpack_from("<B3i", data, end + 24 * vertices + 13 * i)[1:] for i in range(faces)]


def read_vtp(path):
    """Points of an ASCII file, in their order."""
    root = ET.parse(path).getroot()
    flat = numbers(root.find("PolyData/Piece/Points/DataArray").text)
    return [flat[i:i + 3] for i in range(0, len(flat), 3)]


def read_stl(path):
    """Corners of the triangles of a binary file, in their order."""
    data = open(path, "rb").read()
    count = struct.unpack_from("<I", data, 80)[0]
    return [struct.unpack_from("<3f", data, 84 + 50 * i + 12 + 12 * k) for i in range(count) for k in range(3)]


def osim_meshes(model):
    """Name, file, body, scale and place of every mesh of a document of version 4, all of them fixed to a body itself."""
    owners = [model.model.find("Ground")] + list(model.model.find("BodySet/objects"))
    for owner in owners:
        for m in owner.findall("attached_geometry/Mesh"):
            assert text_of(m, "socket_frame") == ".."
            yield text_of(m, "mesh_file")[:-4], text_of(m, "mesh_file"), owner.get("name"), numbers(text_of(m, "scale_factors")), identity()


def mjcf_meshes(model):
    """The same of a model of MuJoCo's: geoms of a class that makes them meshes, at pos and euler or quat."""
    files = {m.get("name"): m.get("file") for m in model.root.findall("asset/mesh")}
    for body in model.root.iter("body"):
        for g in body.findall("geom"):
            if g.get("mesh"):
                yield g.get("name"), files[g.get("mesh")], body.get("name"), [1, 1, 1], chain(shift(numbers(g.get("pos", "0 0 0"))), model.orientation(g))


def world_poses(document, frame):
    """World pose of each joint of a motion document at one of its frames."""
    out = {}
    for joint in document["joints"]:
        key = joint["keys"][min(frame, len(joint["keys"]) - 1)]
        own = chain(shift(key.get("translation", [0, 0, 0])), quaternion(*key.get("rotation", [1, 0, 0, 0])))
        out[joint["name"]] = mul(out[joint["parent"]], own) if joint.get("parent") else own
    return out


def bone_error(bone, document_path, source, poses, frame, scale, up_y):
    """How far off the vertices of a bone are, a few hundred of them; and how far they have gone from rest."""
    points, triangles = read_ply(os.path.join(os.path.dirname(document_path), bone["mesh"]))
    if source.endswith(".vtp"):
        theirs, mine = read_vtp(source), points
    else:
        theirs, mine = read_stl(source), [points[v] for t in triangles for v in t]
    assert len(theirs) == len(mine), (bone["name"], len(theirs), len(mine))
    worst, moved, pose = 0.0, 0.0, poses.get(bone.get("joint"), identity())
    for k in range(0, len(mine), max(1, len(mine) // 300)):
        x, y, z = point(frame, [s * c for s, c in zip(scale, theirs[k])])
        now = point(pose, mine[k])
        worst = max(worst, math.dist(now, (x, -z, y) if up_y else (x, y, z)))
        moved = max(moved, math.dist(now, mine[k]))
    return worst, moved


def bones(model_path, motion, document_path, folder):
    document = json.load(open(document_path))
    up_y = model_path.endswith(".osim")
    model = Osim(model_path) if up_y else Mjcf(model_path)
    meshes = {m[0]: m[1:] for m in (osim_meshes(model) if up_y else mjcf_meshes(model))}
    rows = coordinate_rows(model, motion) if up_y else mjcf_rows(model, motion)
    worst = moved = 0.0
    frames = sorted({0, len(rows) // 3, len(rows) // 2, len(rows) - 1})
    for k in frames:
        bodies = model.frames(rows[k]) if up_y else model.frames(rows[k])[0]
        poses = world_poses(document, k)
        assert len(document["bones"]) == len(meshes)
        for bone in document["bones"]:
            file, body, scale, frame = meshes[bone["name"]]
            assert bone.get("joint", "ground") == body and bone["units"] == 1, bone
            off, way = bone_error(bone, document_path, os.path.join(folder, os.path.basename(file)), poses, mul(bodies[body], frame), scale, up_y)
            worst, moved = max(worst, off), max(moved, way)
    names = [b["name"] for b in document["bones"]]
    print(f"{len(names)} bones at {len(frames)} of {len(rows)} frames: vertices within {worst:.2e} m; one has gone {moved:.3f} m")
    return worst < 1e-9 and len(set(names)) == len(names) and (motion == "-" or moved > 0.05)


# ---- the dog's trot -----------------------------------------------------------------------------------------------------------------

FEET = {"hind left": "toe_L", "fore right": "finger_R", "hind right": "toe_R", "fore left": "finger_L"}
UP = 0.02  # m above its lowest place: a foot that swings


def runs_of(flags):
    """How many times a foot is lifted."""
    return sum(b and not a for a, b in zip([False] + flags, flags))


def out_of_range(model, names, table):
    return [n for k, n in enumerate(names[1:], 1) if model.range.get(n) and
            not all(model.range[n][0] <= row[k] <= model.range[n][1] for row in table)]


def trot(model_path, motion):
    model = Mjcf(model_path)
    names, table, _ = read_storage(motion)
    unknown = [n for n in names[1:] if n not in model.range and n not in ("root_tx", "root_tz")]
    wrong = out_of_range(model, names, table)
    places = {foot: [] for foot in FEET}
    for q in mjcf_rows(model, motion):
        frames, _ = model.frames(q)
        for foot, body in FEET.items():
            places[foot].append((frames[body][0][3], frames[body][2][3]))
    lift = {foot: [z - min(p[1] for p in path) for _, z in path] for foot, path in places.items()}
    up = {foot: [h > UP for h in heights] for foot, heights in lift.items()}
    rows, step = len(table), table[1][0]
    strides = round(table[-1][0] / 0.5)
    together = min(sum(a == b for a, b in zip(up[x], up[y])) / rows for x, y in (("hind left", "fore right"), ("hind right", "fore left")))
    flying = sum(all(up[f][k] for f in FEET) for k in range(rows))
    standing = sum(not any(up[f][k] for f in FEET) for k in range(rows))
    slip = 0.0
    for n, path in enumerate(places.values()):
        for k in range(rows - 1):
            if 0.08 <= (table[k][0] / 0.5 + (n >= 2) * 0.5) % 1 <= 0.42:  # well within its stance
                slip = max(slip, abs(path[k + 1][0] - path[k][0]) / step, abs(path[k + 1][1] - path[k][1]) / step)
    heights = [max(lift[f]) for f in FEET]
    again = max(abs(a - b) for n, a, b in zip(names[2:], table[0][2:], table[round(0.5 / step)][2:]))
    print(f"{rows} rows, {len(names) - 1} columns: diagonals agree in {100 * together:.0f} % of them, all feet up in {flying}, down in {standing}; "
          f"lifted by {min(heights):.3f} to {max(heights):.3f} m; feet that stand move by at most {slip:.2f} m/s of {table[-1][1] / table[-1][0]:.2f}")
    print("not of the model:", unknown, "out of range:", wrong)
    lifted = all(runs_of(up[f]) in (strides, strides + 1) for f in FEET)
    return not unknown and not wrong and together >= 0.9 and lifted and 0.04 < min(heights) and max(heights) < 0.15 and again < 1e-3 \
        and flying <= rows // 20 and standing < rows // 2 and slip < 0.4


def main():
    modes = {"origins": (origins, 3), "lengths": (lengths, 3), "mjcf": (mjcf, 3), "bones": (bones, 4), "trot": (trot, 2)}
    if len(sys.argv) < 2 or sys.argv[1] not in modes or len(sys.argv) != 2 + modes[sys.argv[1]][1]:
        raise SystemExit(__doc__)
    sys.exit(0 if modes[sys.argv[1]][0](*sys.argv[2:]) else 1)


if __name__ == "__main__":
    main()
