# Members of documents that take one of some words: every one that the schemas list refuses another, and tells what was meant.

bats_require_minimum_version 1.5.0

@test "every word that a schema lists is refused where it is mistyped, in every member that takes one, with what was meant" {
    cd "$BATS_TEST_TMPDIR"
    /usr/bin/python3 - "$BIN" "$BATS_TEST_DIRNAME/../../share/schema" << 'END'
import copy, json, subprocess, sys
binaries, schemas = sys.argv[1:3]

def words_of(schema):
    """Member names with each list of words that one of that name takes."""
    found = set()
    def walk(node, name):
        if isinstance(node, list):
            for item in node: walk(item, name)
        if not isinstance(node, dict): return
        if "enum" in node: found.add((name, tuple(w for w in node["enum"] if isinstance(w, str) and w)))
        for key, value in node.items():
            if key in ("properties", "$defs"):
                for member, part in value.items(): walk(part, member)
            elif key != "default": walk(value, name)
    walk(schema, "")
    return {(name, words) for name, words in found if words}

def places(node, name, at=()):
    if isinstance(node, dict):
        for key, value in node.items():
            if key == name and not isinstance(value, (dict, list)): yield at + (key,)
            yield from places(value, name, at + (key,))
    elif isinstance(node, list):
        for i, value in enumerate(node): yield from places(value, name, at + (i,))

tetra = {"vertices": [0, 0, 0, .1, 0, 0, 0, .1, 0, 0, 0, .1], "triangles": [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]}
joints = [{"name": "h", "type": "hinge", "axis": [0, 0, 1], "point": [0, 0, 0], "interpolation": "linear", "keys": [{"time": 0, "degrees": 0}, {"time": 1, "degrees": 1}]}]
bones = [{"name": "b", "mesh": "tetra.off", "units": "m", "joint": "h"}]
documents = {
    "muscle": {"format": "sinew-muscle", "version": 1, "name": "m", "metersPerUnit": 1, "space": "RAS", "mesh": tetra,
               "attachments": [{"bone": "b", "end": "origin", "vertices": [0]}],
               "externals": [{"target": "n", "fascia": "deep", "vertices": [0], "triangles": [0], "barycentric": [1, 0, 0], "distances": [0],
                              "minimumDistances": [0], "weights": [1, 0, 0]}]},
    "motion": {"format": "sinew-motion", "version": 1, "joints": joints, "bones": bones,
               "coordinates": [{"name": "q", "unit": "rad", "rate": 1, "values": [0, 1]}]},
    "activation": {"format": "sinew-activation", "version": 1, "channels": {"tetra": {"interpolation": "linear", "times": [0, 1], "values": [0, 1]}}},
    "sensors": {"format": "sinew-sensors", "version": 1, "sensors": [
        {"name": "s", "type": "angle", "joint": "h", "axis": "x", "trigger": {"when": "above", "threshold": 1, "decay": 1}}],
        "channels": [{"muscles": ["m"], "sensors": "s", "combine": "max"}]},
    "scene": {"format": "sinew-scene", "version": 1, "rate": 24, "frames": [0, 1],
              "solver": {"method": "xpbd", "scheme": "guarded", "hinges": "scheme", "precision": "double", "preconditioner": "scalar"},
              "contact": {"collision": "scheme", "boneHits": "follow"},
              "motion": {"joints": joints, "coordinates": [{"name": "q", "unit": "rad", "rate": 1, "values": [0, 1]}]}, "bones": bones,
              "surfaces": [{"name": "s", "mesh": "tetra.off", "frames": "none.#.off", "units": "m", "up": "z"}],
              "muscles": [{"name": "m", "rig": "tetra.off", "stretch": "springs", "law": "projected", "anisotropy": "scheme", "mass": "density"}]},
    "envelope": {"format": "sinew-envelope", "version": 1, "method": "blend"},
}
open("tetra.off", "w").write("OFF\n4 4 6\n0 0 0\n.1 0 0\n0 .1 0\n0 0 .1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n")
json.dump(documents["motion"], open("right.motion.json", "w"))
commands = {"muscle": ["root-select", "x.json"], "motion": ["motion-import", "x.json"], "scene": ["simulate", "--plan", "x.json"],
            "sensors": ["motion-sense", "--sensors", "x.json", "right.motion.json"], "activation": ["scene-build", "tetra.off", "--activation", "x.json"],
            "envelope": ["envelope-bind", "x.json", "--bones", "right.motion.json", "-o", "y.json"]}
elsewhere = {"sensors": {"direction": ["axis"]}} # a definition that members of these names are
tried, wrong = 0, 0
for kind, document in documents.items():
    for name, words in sorted(words_of(json.load(open(f"{schemas}/{kind}.schema.json")))):
        found = [p for member in elsewhere.get(kind, {}).get(name, [name]) for p in places(document, member)]
        if not found:
            print(f"{kind}: no member {name} is tried")
            wrong += 1
        for path in found:
            parent = document
            for step in path[:-1]: parent = parent[step]
            if not isinstance(parent[path[-1]], str) or parent[path[-1]] not in words: continue # another member of that name
            for word in words:
                mistyped = word[:-2] + word[-1] + word[-2] if len(word) > 3 else word + "q"
                changed = copy.deepcopy(document)
                parent = changed
                for step in path[:-1]: parent = parent[step]
                parent[path[-1]] = mistyped
                json.dump(changed, open("x.json", "w"))
                tool, *rest = commands[kind]
                run = subprocess.run([f"{binaries}/{tool}", *rest], capture_output=True, text=True, stdin=subprocess.DEVNULL)
                said = f'"{word}"' in run.stderr and "x.json" in run.stderr and (len(word) < 4 or f'did you mean "{word}"?' in run.stderr)
                tried += 1
                if run.returncode != 1 or not said or run.stderr.count("\n") != 1:
                    print(kind, path, mistyped, run.returncode, run.stderr)
                    wrong += 1
print(tried, "tried")
sys.exit(wrong > 0 or tried < 60)
END
}
