# motion-import on glTF, FBX and Collada, through mesh-import: poses that are known, which animation, what is refused and what is said.

bats_require_minimum_version 1.5.0

# `timeout 300` is a limit against hanging, far beyond what any of these takes: it judges no speed.

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    import="$BIN/motion-import"
    child="$BIN/../libexec/sinew/mesh-import"
    write="$BATS_TEST_DIRNAME/../write-motion"
    man="$BATS_TEST_DIRNAME/../../share/man/motion-import.1"
    export ASAN_OPTIONS="${ASAN_OPTIONS:+$ASAN_OPTIONS:}hard_rss_limit_mb=2048:max_allocation_size_mb=2048"
}

# Run with a status of 1 and exactly one line on stderr that matches $1, and no output.
refused() {
    local pattern=$1 code=0
    shift
    "$@" > out 2> err || code=$?
    [ "$code" -eq 1 ] && [ ! -s out ] && [ "$(wc -l < err)" -eq 1 ] || { cat err; return 1; }
    grep -Eq "^motion-import: $pattern" err || { cat err; return 1; }
}

# Exactly one line on stderr, a warning that matches.
warns() {
    local pattern=$1
    shift
    "$@" 2> err
    [ "$(wc -l < err)" -eq 1 ] || { cat err; return 1; }
    grep -Eq "^motion-import: warning: $pattern" err || { cat err; return 1; }
}

# poses DOCUMENT WHAT: every joint's pose in every frame against a formula, by what it does to four points around the rest place.
poses() {
    python3 - "$@" << 'END'
import json, math, sys

def turn(axis, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    i, j = [(1, 2), (2, 0), (0, 1)]["xyz".index(axis)]
    m = [[float(a == b) for b in range(3)] for a in range(3)]
    m[i][i] = m[j][j] = c
    m[i][j], m[j][i] = -s, s
    return m

mul = lambda a, b: [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
apply = lambda m, p: [sum(m[i][k] * p[k] for k in range(3)) for i in range(3)]
add = lambda a, b: [x + y for x, y in zip(a, b)]
transposed = lambda m: [list(r) for r in zip(*m)]
between = lambda t, times, values: next(a + (b - a) * (t - s) / (e - s) for s, e, a, b in zip(times, times[1:], values, values[1:]) if t <= e + 1e-9)

def gltf(t, step=False, begin=0):
    """Frames in the file's axes: hip and knee."""
    rig, at = turn("y", 90), [0, 1, 0]
    angle = (0 if t < 0.5 - 1e-9 else 90 if t < 1 - 1e-9 else 45) if step else between(t, (0, .5, 1), (0, 90, 45))
    hip = [1, 2, between(t, (0, .5, 1), (3, 4, 3))]
    return {"hip": (rig, add(at, apply(rig, hip))), "knee": (mul(rig, turn("x", angle)), add(at, apply(rig, add(hip, [0, -0.5, 0]))))}

def collada(t):
    angle, x = between(t, (0, .5, 1), (0, 90, 90)), 100 * t
    hip = turn("z", angle), [x / 100, 0, 0.8]
    return {"hip": hip, "knee": (mul(hip[0], turn("x", 60 * t)), add(hip[1], [0, 0, -0.4]))}

def fbx(t, pre=0):
    return {"hip": (mul(turn("x", pre), turn("z", 90 * t)), [t, 0.8, 0])}

def fbx_pivot(t):
    """About a point 0.1 m off in x."""
    m = turn("z", 90 * t)
    return {"hip": (m, add([t + 0.1, 0.8, 0], apply(m, [-0.1, 0, 0])))}

kinds = {"gltf": (gltf, True), "step": (lambda t: gltf(t, True), True), "collada": (collada, False), "fbx": (fbx, True),
         "fbx-pre": (lambda t: fbx(t, 90), True), "fbx-pivot": (fbx_pivot, True)}
document, (frames, up_y) = json.load(open(sys.argv[1])), kinds[sys.argv[2]]
rest = frames(0)
up = (lambda p: [p[0], -p[2], p[1]]) if up_y else (lambda p: p)
worst, poses = 0.0, {}
assert set(rest) == {j["name"] for j in document["joints"]}, document["joints"]
count = len(document["joints"][0]["keys"])
assert count == round(document["rate"]) + 1
for f in range(count):
    now = frames(f / document["rate"])
    for joint in document["joints"]:
        key = joint["keys"][f]
        w, x, y, z = key.get("rotation", [1, 0, 0, 0])
        m = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
             [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
        own = m, key.get("translation", [0, 0, 0])
        if joint.get("parent"):
            p = poses[joint["parent"]]
            own = mul(p[0], own[0]), add(p[1], apply(p[0], own[1]))
        poses[joint["name"]] = own
        (r0, t0), (r1, t1) = rest[joint["name"]], now[joint["name"]]
        worst = max(worst, math.dist(joint["rest"], up(t0)))
        for e in ([0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]):  # points of the joint's own frame
            before, after = up(add(t0, apply(r0, e))), up(add(t1, apply(r1, e)))
            worst = max(worst, math.dist(add(own[1], apply(own[0], before)), after))
print("%s: %d frames of %d joints within %.1e m" % (sys.argv[2], count, len(rest), worst))
assert worst < 1e-6
END
}

@test "glTF and GLB: joints, names, metres, z up; keys between by straight lines and the shortest turns" {
    for format in gltf glb; do
        "$write" $format a.$format
        "$import" a.$format -o a.json 2> err
        [ ! -s err ]
        poses a.json gltf
        "$import" a.$format --source-rate 7 -o seven.json
        poses seven.json gltf
    done
    "$import" --list a.glb > list
    [ "$(head -5 list)" = "$(printf 'format\tglTF\nframes\t31\nrate\t30\nseconds\t1\nanimation\t1\twalk\t1')" ]
    grep -qP '^joint\t2\tknee\thip\t' list
    # the same bytes through a pipe but for the name, and again; keys later than 0 begin the clip
    "$import" < a.glb | sed '/^  "name"/d' > pipe.json
    "$import" a.glb | sed '/^  "name"/d' | cmp - pipe.json
    "$write" glb late.glb begin=3
    "$import" late.glb -o late.json
    poses late.json gltf
}

@test "glTF: steps are steps; what is told by curves is taken as straight, and said" {
    "$write" glb step.glb interpolation=STEP
    "$import" step.glb -o step.json 2> err
    [ ! -s err ]
    poses step.json step
    "$write" gltf nameless.gltf interpolation=STEP nameless=1
    "$import" nameless.gltf | sed 's/nodes\[1\]/hip/g; s/nodes\[2\]/knee/g' > nameless.json
    poses nameless.json step
    "$write" glb curve.glb interpolation=CUBICSPLINE
    warns 'curve.glb: keys are up to 0.5 s apart; between them straight lines' "$import" curve.glb -o curve.json
    poses curve.json gltf
}

@test "the rate is that whose frames the keys are on; else 30 is said" {
    for rate in 24 60 120; do
        "$write" glb $rate.glb rate=$rate
        "$import" --list $rate.glb | grep -qx "rate	$rate"
    done
    "$write" glb odd.glb rate=37
    "$import" odd.glb -o odd.json 2> err
    grep -q 'odd.glb tells no rate: taken as 30 Hz' err
    "$import" odd.glb --source-rate 37 -o odd.json 2> err
    [ ! -s err ]
}

@test "Collada: its unit and its axis; matrices and single angles" {
    "$write" dae a.dae
    warns 'a.dae: keys are up to 1 s apart; between' "$import" a.dae -o a.json
    poses a.json collada
    "$import" -q --units m --up y a.dae --list | grep -qP '^joint\t1\thip\t-\t0\t-80\t0$'
}

@test "FBX: centimetres, y up, frames by its time mode; nodes that the importer makes of pre-rotations and pivots are none" {
    "$write" fbx a.fbx
    "$import" -q a.fbx -o a.json
    poses a.json fbx
    "$write" fbx pre.fbx pre=1
    "$import" -q pre.fbx -o pre.json
    poses pre.json fbx-pre
    # about a pivot: channels of the made-up nodes themselves
    sed 's/^\(.*\)P: "Lcl Translation", "Lcl Translation", "", "A",0,80,0/\1P: "RotationPivot", "Vector3D", "Vector", "",10,0,0\n&/' a.fbx > pivot.fbx
    "$import" -q pivot.fbx -o pivot.json
    poses pivot.json fbx-pivot
    # where its mesh is in its frame moves nothing
    sed 's/RotationPivot", "Vector3D", "Vector", "",10,0,0/GeometricTranslation", "Vector3D", "Vector", "",5,6,7/' pivot.fbx > shape.fbx
    "$import" -q shape.fbx -o shape.json
    poses shape.json fbx
    "$write" fbx film.fbx mode=11
    "$import" -q --list film.fbx | grep -qx 'rate	24'
    sed 's/RotationPivot", "Vector3D", "Vector", "",10,0,0/PostRotation", "Vector3D", "Vector", "",0,0,90/' pivot.fbx > post.fbx
    refused 'post.fbx: the node "hip" has a post-rotation or' "$import" post.fbx
}

@test "one of several animations, by name or number; the first is said" {
    "$write" glb two.glb second=1
    warns 'two.glb: the first of 2 animations is taken, "walk"; --animation names another' "$import" two.glb -o one.json
    poses one.json gltf
    "$import" two.glb --animation wave -o wave.json 2> err
    [ ! -s err ]
    "$import" two.glb --animation 2 --no-history | cmp - <("$import" two.glb --animation wave --no-history)
    python3 -c '
import json, math
d = json.load(open("wave.json"))
assert [j["name"] for j in d["joints"]] == ["knee"] and d["joints"][0]["keys"][-1]["frame"] == 60, d["joints"]
w = d["joints"][0]["keys"][-1]["rotation"][0]
assert abs(w - math.cos(math.radians(15))) < 1e-7, w
assert d["history"][0]["args"] == ["--animation", "wave"], d["history"]'
    "$import" --list -q two.glb > list
    [ "$(grep -c ^animation list)" -eq 2 ]
    grep -qP '^animation\t2\twave\t2$' list
    refused 'two.glb: has no animation "3"; it has 2' "$import" two.glb --animation 3
    refused 'two.glb: has no animation ""; it has 2' "$import" two.glb --animation ''
    printf 'sinew-nodes 1\nnode -1 a\n1 0 0 0 0 1 0 0 0 0 1 0\nbind 0\n1 0 0 0 0 1 0 0 0 0 1 0\nend\n' > bone.nodes
    refused 'bone.nodes: has no animation "1"; it has 0' "$import" bone.nodes --animation 1
}

@test "bones of a skin rest where it was bound" {
    "$write" glb skin.glb skin=1
    "$import" skin.glb -o skin.json 2> err
    [ ! -s err ]
    poses skin.json gltf
    # bound a metre off, across the rig: the joints have the mesh a metre off then, and rest as it does
    "$write" glb off.glb skin=2
    "$import" off.glb -o off.json 2> err
    [ ! -s err ]
    cmp <(sed '/"name"/d; /history/,$d' skin.json) <(sed '/"name"/d; /history/,$d' off.json)
    # only the knee was: it rests there, and its poses bring it to where its node is
    "$write" glb knee.glb skin=3
    warns "knee.glb: the joints of '.*' are not as its skin was bound" "$import" knee.glb -o knee.json
    python3 -c '
import json, math
a, b = (json.load(open(f))["joints"] for f in ("skin.json", "knee.json"))
assert math.dist(a[0]["rest"], b[0]["rest"]) < 1e-6, (a[0]["rest"], b[0]["rest"])
assert math.isclose(math.dist(a[1]["rest"], b[1]["rest"]), 1, abs_tol=1e-6), (a[1]["rest"], b[1]["rest"])
# the pose of frame 0 carries the rest place to the node
t = b[1]["keys"][0]["translation"]
assert math.dist([x + y for x, y in zip(b[1]["rest"], t)], a[1]["rest"]) < 1e-6, t'
    "$write" glb still.glb skin=1 still=1
    "$import" --list still.glb > list
    grep -qx 'frames	1' list
    [ "$(grep -c ^joint list)" -eq 2 ]
}

@test "a scale that changes is said, not hidden; one that stays is part of the places" {
    "$write" glb scale.glb scale=2
    warns 'scale.glb: sizes change, which bones do not: .*"knee" does most, by 100 %' "$import" scale.glb -o scale.json
    poses scale.json gltf
    python3 -c '
import json
d = json.loads(open("a.gltf").read())' 2> /dev/null || "$write" gltf a.gltf
    # the whole rig at twice its size, and mirrored
    python3 -c '
import json
d = json.load(open("a.gltf"))
d["nodes"][0]["scale"] = [2, 2, 2]
json.dump(d, open("large.gltf", "w"))
d["nodes"][0]["scale"] = [-1, 1, 1]
json.dump(d, open("mirror.gltf", "w"))'
    "$import" a.gltf -o a.json
    "$import" large.gltf -o large.json 2> err
    [ ! -s err ]
    "$import" mirror.gltf -o mirror.json 2> err
    [ ! -s err ]
    python3 -c '
import json, math
a, b, m = (json.load(open(f))["joints"] for f in ("a.json", "large.json", "mirror.json"))
for p, q in zip(a, b):
    off = [x - 2 * y for x, y in zip(q["rest"], p["rest"])]  # twice as far from the origin of the rig, which is at (0, 0, 1)
    assert math.dist(off, [0, 0, -1]) < 1e-6, off
    for k, l in zip(p["keys"], q["keys"]):
        assert math.dist(k.get("rotation", [1, 0, 0, 0]), l.get("rotation", [1, 0, 0, 0])) < 1e-6
# x of the rig is -z of the file and y of ours: mirrored there
assert math.dist([m[1]["rest"][0], -m[1]["rest"][1], m[1]["rest"][2]], a[1]["rest"]) < 1e-6, m[1]["rest"]'
}

@test "what is no motion, broken or unclear is refused in one sentence" {
    "$write" glb still.glb still=1
    refused 'still.glb: holds no animation of a node and no bones' "$import" still.glb
    "$write" glb twins.glb twins=1
    refused 'twins.glb: an animation or a skin names the node "hip", and more than one is called so' "$import" twins.glb
    "$write" glb a.glb
    head -c 300 a.glb > cut.glb
    refused 'cut.glb: ' "$import" cut.glb
    "$write" gltf a.gltf
    python3 -c '
import json
d = json.load(open("a.gltf"))
turn = d["animations"][0]["samplers"][1]["output"]
d["accessors"][turn]["componentType"] = 5122
json.dump(d, open("short.gltf", "w"))
d["accessors"][turn]["componentType"] = 5126
d["animations"][0]["channels"][0]["target"]["node"] = 77
json.dump(d, open("gone.gltf", "w"))'
    refused 'short.gltf: ' "$import" short.gltf
    refused 'gone.gltf: ' "$import" gone.gltf
    refused 'a.glb: has its skeleton in it' "$import" a.glb --skeleton a.glb
    refused 'a.glb: has no meshes of bones: glTF is no model' "$import" a.glb --bones bones
}

@test "a tree 10 000 nodes deep" {
    "$write" gltf deep.gltf deep=10000
    timeout 300 "$import" deep.gltf -o deep.json 2> err
    [ ! -s err ]
    poses deep.json gltf
}

@test "a child that lies is not believed: text of nodes that makes no sense" {
    good='sinew-nodes 1\nmetersPerUnit 1\nup z\nnode -1 a\n1 0 0 0 0 1 0 0 0 0 1 0\nanimation 1 1 walk\nchannel 0 2 0 0\n0 0 0 0\n1 1 0 0\nend\n'
    printf "$good" > good.nodes
    "$import" --list good.nodes | grep -qx 'format	nodes'
    "$write" glb a.glb
    # the same text for a file and from a pipe
    "$child" --motion a.glb > a.nodes
    [ "$(head -1 a.nodes)" = 'sinew-nodes 1' ]
    "$import" -q a.nodes -o text.json
    poses text.json gltf
    broken() { printf "$good" | sed "$1" > broken.nodes; refused "broken.nodes: $2" "$import" broken.nodes; }
    broken '$d' 'line 10: the end is missing'
    broken 's/^node -1/node 0/' 'line 4: a node without a parent'
    broken 's/^channel 0 2/channel 1 2/' 'line 7: a channel of no node'
    broken 's/^channel 0 2/channel 0 999999999/' 'line 7: a wrong number of keys'
    broken 's/^channel 0 2/channel 0 -1/' 'line 7: a wrong number of keys'
    broken 's/^animation 1 1/animation 1 99999999/' 'line 6: a wrong number of channels'
    broken 's/^channel 0 2/channel 0 3/' 'line 7: a wrong number of keys'
    broken 's/^1 1 0 0/1 1 0/' 'line 9: a number is missing'
    broken 's/^1 1 0 0/-1 1 0 0/' 'the keys of an animation are not in the order of their times'
    broken 's/^1 1 0 0/1 nan 0 0/' 'a key of an animation is not finite'
    broken 's/^1 0 0 0 0 1 0 0 0 0 1 0/0 0 0 0 0 0 0 0 0 0 0 0/' 'the node "a" has a scale of 0 at rest'
    broken 's/^channel 0 2/channel -1 2/' '1 of the 1 channels of the animation "walk" move nodes that are not in the scene'
    broken 's/^1 1 0 0/1e9 1 0 0/' '30000000001 frames of 1 joints are too many'
    mkdir fake
    printf '#!/bin/sh\ncat > /dev/null\nprintf "%s"\n' 'sinew-nodes 1\nnonsense\n' > fake/mesh-import
    chmod +x fake/mesh-import
    SINEW_LIBEXEC=$PWD/fake refused 'a.glb: cannot be imported as glTF: .* answers with something that is no motion' "$import" a.glb
}

@test "mutated files: a motion or one sentence, status 0 or 1" {
    "$write" glb a.glb skin=1 second=1
    "$write" gltf a.gltf
    "$write" dae a.dae
    "$write" fbx a.fbx pre=1
    for format in glb gltf dae fbx; do
        for seed in $(seq 25); do
            "$BATS_TEST_DIRNAME/../write-scene" mutate a.$format "$seed" "mutant.$format"
            code=0
            timeout 300 "$import" -q "mutant.$format" -o mutant.json > out 2> err || code=$?
            case $code in
                0) [ ! -s err ] ;;
                1) [ "$(wc -l < err)" -eq 1 ] && grep -Eq "^motion-import: mutant.$format:([0-9:]*) ." err ;;
                *) false ;;
            esac || { echo "$format $seed: status $code"; cat err; false; }
            [ ! -s out ]
        done
    done
}
