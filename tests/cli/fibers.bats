# simulate's volume fibres: carried only where asked for; frames, lengths, blend, penetration, weights kept by hash; refusals.

bats_require_minimum_version 1.5.0

# a && b and ! a do not end a test under bats: state every condition by itself, and what must not hold with `refute`
refute() { if "$@"; then echo "held: $*"; return 1; fi; }

# The sample arm; its biceps with 20 fibres in one.scene.json.
setup_file() {
    sh "$BATS_TEST_DIRNAME/../sample-folder" "$BIN" "$EXAMPLES" "$BATS_FILE_TMPDIR/arm"
    cd "$BATS_FILE_TMPDIR/arm" || exit 1
    for name in biceps brachialis triceps; do mv $name.fibers.json $name.muscle.json; done # as they were before fiber-fill
    "$BIN/fiber-fill" -n 20 biceps.muscle.json -o filled.muscle.json
    python3 -c 'import json
s = json.load(open("arm.scene.json")); s["muscles"] = s["muscles"][:1]; s["muscles"][0]["name"] = "biceps"
json.dump(s, open("bare.scene.json", "w"))
s["muscles"][0]["rig"] = "filled.muscle.json"
json.dump(s, open("one.scene.json", "w"))
s = json.load(open("arm.scene.json")); s["muscles"][0]["rig"] = "filled.muscle.json"
json.dump(s, open("some.scene.json", "w"))'
}

setup() {
    cp -r "$BATS_FILE_TMPDIR/arm" "$BATS_TEST_TMPDIR/arm"
    cd "$BATS_TEST_TMPDIR/arm" || exit 1
    PATH=$BIN:$PATH
}

# lines of a log without what the fibres add
without_fibers() { python3 -c 'import json, sys
for line in open(sys.argv[1]):
    l = json.loads(line); l.pop("fibers", None); print(json.dumps(l))' "$1"; }

@test "nobody asks: the same bytes as of a muscle without fibres; asked: the muscle moves the same" {
    simulate bare.scene.json --frames 0:3 -o bare.pc2 --log bare.jsonl
    simulate one.scene.json --frames 0:3 -o off.pc2 --log off.jsonl
    simulate one.scene.json --frames 0:3 -o on.pc2 --log on.jsonl --fibers --lengths on.tsv --blend 2 --penetration
    cmp bare.pc2 off.pc2
    cmp bare.jsonl off.jsonl
    cmp off.pc2 on.pc2
    without_fibers off.jsonl > a
    without_fibers on.jsonl > b
    cmp a b
    refute grep -q fibers off.jsonl
}

@test "frames: a sequence with its collection and a cache, that agree with the lengths" {
    simulate one.scene.json --frames 0:4 -o out --log log.jsonl --fibers --lengths l.tsv
    [ "$(ls out | tr '\n' ' ')" = "biceps-fibers.0000.vtp biceps-fibers.0001.vtp biceps-fibers.0002.vtp biceps-fibers.0003.vtp biceps-fibers.0004.vtp biceps-fibers.pc2 biceps-fibers.pvd biceps.pc2 " ]
    python3 - <<'END'
import json, math, struct, xml.etree.ElementTree as tree
rest = json.load(open("filled.muscle.json"))
unit, lines = rest["metersPerUnit"], rest["fibers"]["polylines"]
data = open("out/biceps-fibers.pc2", "rb").read()
signature, version, points, start, rate, samples = struct.unpack("<12siiffi", data[:32])
assert samples == 5 and points == sum(len(l["points"]) // 3 for l in lines)
rows = [line.rstrip("\n").split("\t") for line in open("l.tsv")]
assert rows[0][0] == "time" and rows[0][-1] == "biceps.20" and len(rows) == 6
first = rows[0].index("biceps.1")
collection = tree.parse("out/biceps-fibers.pvd").getroot()
sets = collection.findall("./Collection/DataSet")
assert [s.get("file") for s in sets] == ["biceps-fibers.%04d.vtp" % i for i in range(5)]
assert abs(float(sets[3].get("timestep")) - 3 / 24) < 1e-12
for frame in range(5):
    vtp = open("out/biceps-fibers.%04d.vtp" % frame, "rb").read()
    head, raw = vtp.split(b'<AppendedData encoding="raw">\n_')
    assert b'NumberOfLines="20"' in head
    (size,) = struct.unpack_from("<Q", raw)
    assert size == 24 * points
    exact = struct.unpack_from("<%dd" % (3 * points), raw, 8)
    single = struct.unpack_from("<%df" % (3 * points), data, 32 + 12 * points * frame)
    assert all(struct.unpack("<f", struct.pack("<f", a))[0] == b for a, b in zip(exact, single))
    at = 0
    for i, line in enumerate(lines):
        p = [exact[3 * k:3 * k + 3] for k in range(at, at + len(line["points"]) // 3)]
        at += len(p)
        length = unit * sum(math.dist(a, b) for a, b in zip(p, p[1:]))
        assert abs(float(rows[frame + 1][first + i]) - length) < 1e-12, (frame, i)
        if frame == 0: assert max(math.dist(a, line["points"][3 * k:3 * k + 3]) for k, a in enumerate(p)) < 1e-9 * length / unit
END
    simulate one.scene.json --frames 0:1 -o one.pc2 --log log.jsonl --fibers
    [ -s one-fibers.pc2 ]
    [ -s one-fibers.0001.vtp ]
    simulate one.scene.json --frames 0:1 -o meshes --format ply --log log.jsonl --fibers
    [ -s meshes/biceps.0001.ply ]
    [ -s meshes/biceps-fibers.0001.vtp ]
}

@test "the VTP frames are read by VTK" {
    /usr/bin/python3 -c 'import vtkmodules' 2> /dev/null || skip "no VTK for Python here"
    simulate one.scene.json --frames 0:1 -o out --log log.jsonl --fibers
    /usr/bin/python3 - <<'END'
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
r = vtkXMLPolyDataReader()
r.SetFileName("out/biceps-fibers.0001.vtp")
r.Update()
o = r.GetOutput()
assert o.GetNumberOfLines() == 20 and o.GetNumberOfPoints() == 320
assert o.GetCellData().GetArray("length").GetValue(0) > 0 and abs(o.GetCellData().GetArray("stretch").GetValue(0) - 1) < 0.2
END
}

@test "rig-view draws the fibres of a frame, and none that nobody has moved" {
    simulate one.scene.json --frames 0:20 -o out --log log.jsonl --fibers
    simulate one.scene.json --frames 0:20 -o bare --log log.jsonl
    for frame in 0 20; do rig-view one.scene.json --frames out --frame $frame --show fibers --size 160x120 --no-legend --background white -o f$frame.png; done
    rig-view one.scene.json --frames bare --frame 20 --show fibers,surface --size 160x120 --no-legend -o none.png
    rig-view one.scene.json --frames bare --frame 20 --show surface --size 160x120 --no-legend -o surface.png
    cmp none.png surface.png
    refute cmp -s f0.png f20.png
    [ "$(wc -c < f0.png)" -gt 1000 ]
    "$BIN/fiber-fill" -q -n 5 biceps.muscle.json -o filled.muscle.json
    run -1 rig-view one.scene.json --frames out --frame 20 --show fibers -o no.png
    [[ "$output" == *"biceps-fibers.pc2"*"320 points"* ]]
    [ ! -e no.png ]
}

@test "the same bytes on 1 and 2 threads, with a cache of weights that is full, empty or damaged, stopped or not" {
    simulate one.scene.json --frames 0:3 --threads 1 -o a --log a.jsonl --fibers --lengths a.tsv --blend 1
    simulate one.scene.json --frames 0:3 --threads 2 -o b --log b.jsonl --fibers --lengths b.tsv --blend 1 --embedding-cache weights
    [ "$(ls weights | wc -l)" -eq 1 ]
    [ "$(head -c 15 weights/*)" = SINEWEMBEDDING1 ]
    cp weights/* kept
    simulate one.scene.json --frames 0:3 -o c --log c.jsonl --fibers --lengths c.tsv --blend 1 --embedding-cache weights
    simulate --plan one.scene.json --lengths c2.tsv --embedding-cache weights | grep -q '"cached": true'
    head -c 5000 kept > "weights/$(ls weights)"
    simulate one.scene.json --frames 0:3 -o d --log d.jsonl --fibers --lengths d.tsv --blend 1 --embedding-cache weights 2> err
    grep -q 'damaged' err
    cmp kept weights/*
    # a weight, and the count of vertices, that somebody has changed
    for at in 3004 92; do
        { head -c $at kept; printf 'abc\001'; tail -c +$((at + 5)) kept; } > "weights/$(ls weights)"
        simulate one.scene.json --frames 0:1 --lengths d2.tsv --embedding-cache weights --log d2.jsonl 2> err
        [ "$(grep -c warning err)" -eq 1 ]
        cmp kept weights/*
    done
    simulate one.scene.json --frames 0:9 --stop-after 3 -o e --log e.jsonl --fibers --lengths e.tsv --blend 1
    for other in b c d e; do
        cmp a.tsv $other.tsv
        cmp a.jsonl $other.jsonl
        for file in a/*; do cmp "$file" "$other/${file#a/}"; done
    done
}

@test "a muscle that turns with its one bone: its fibres turn with it and keep their lengths" {
    python3 - <<'END'
import json
rig = json.load(open("filled.muscle.json"))
rig["attachments"] = [{"bone": "radius", "method": "pin", "vertices": list(range(len(rig["mesh"]["vertices"]) // 3))}]
json.dump(rig, open("rigid.muscle.json", "w"))
s = json.load(open("one.scene.json"))
s["muscles"][0]["rig"] = "rigid.muscle.json"
json.dump(s, open("rigid.scene.json", "w"))
END
    simulate rigid.scene.json --frames 0:12 --lengths rigid.tsv --blend 1 --log log.jsonl
    python3 - <<'END'
rows = [line.rstrip("\n").split("\t") for line in open("rigid.tsv")]
angles = [i for i, name in enumerate(rows[0]) if name.endswith(".angle")]
lengths = [i for i, name in enumerate(rows[0]) if name.startswith("biceps.")]
assert len(lengths) == 40 and len(angles) >= 1
assert max(abs(float(rows[-1][i]) - float(rows[1][i])) for i in angles) > 1
for row in rows[2:]:
    for i in lengths: assert abs(float(row[i]) / float(rows[1][i]) - 1) < 1e-9
END
}

@test "lengths and frames of a run that ends at points that are not finite are those until then, and the head counts them" {
    python3 -c 'import json
s = json.load(open("one.scene.json"))
s["motion"]["joints"] = [dict(name="elbow", type="pose", keys=[dict(time=0), dict(time=0.2), dict(time=0.21, translation=[0, 0, -1.7e308]),
    dict(time=0.5, translation=[0, 0, 1.7e308])])]
json.dump(s, open("nan.scene.json", "w"))'
    run -3 simulate nan.scene.json --frames 0:1200 -o ended.pc2 --fibers --log log.jsonl --lengths ended.sto
    [ -s ended-fibers.0004.vtp ]
    refute [ -e ended-fibers.0005.vtp ] # 1e308 m away: more than a cache holds
    grep -qx 'nRows=0005' ended.sto
    [ "$(sed '1,/^endheader/d' ended.sto | wc -l)" -eq 6 ] # and the names
    simulate nan.scene.json --frames 0:4 --log log.jsonl --lengths whole.sto
    sed '1,/^endheader/d' whole.sto > a
    sed '1,/^endheader/d' ended.sto | head -n 6 | cmp - a
}

@test "a storage file has the head of OpenSim's own files, and the numbers of the table" {
    simulate one.scene.json --frames 0:4 --log log.jsonl --lengths l.tsv
    simulate one.scene.json --frames 0:4 --log log.jsonl --lengths l.sto
    sed '1,/^endheader/d' l.sto | cmp - l.tsv
    grep -qx 'nRows=5' l.sto
    grep -qx "nColumns=$(head -n 1 l.tsv | tr '\t' '\n' | wc -l)" l.sto
    real=$DATA/gait-opensim/motion/subject01_walk1_ik.mot
    [ -e "$real" ] || skip "no real motion at $DATA"
    # the same lines in the same order, but for the title and the numbers
    head_of() { sed -n '2,/^endheader/p' "$1" | sed 's/=[0-9]*$/=/'; }
    head_of "$real" > theirs
    head_of l.sto | cmp - theirs
}

@test "--smooth-lengths smooths: less second difference, the same ends" {
    simulate one.scene.json --frames 0:30 --log log.jsonl --lengths rough.tsv
    simulate one.scene.json --frames 0:30 --log log.jsonl --lengths smooth.tsv --smooth-lengths
    python3 - <<'END'
def read(name):
    rows = [line.rstrip("\n").split("\t") for line in open(name)]
    return rows[0], [[float(x) for x in row] for row in rows[1:]]
names, rough = read("rough.tsv")
same, smooth = read("smooth.tsv")
assert names == same and len(rough) == len(smooth) == 31
first = names.index("biceps.1")
bent = lambda t, i, k: abs(t[i - 1][k] - 2 * t[i][k] + t[i + 1][k])
for k in range(len(names)):
    column = [row[k] for row in rough]
    if k < first:
        assert column == [row[k] for row in smooth], names[k]
        continue
    for _ in range(5): column = column[:1] + [(a + 4 * b + c) / 6 for a, b, c in zip(column, column[1:], column[2:])] + column[-1:]
    assert max(abs(a - row[k]) for a, row in zip(column, smooth)) < 1e-15
    most = max(bent(rough, i, k) for i in range(1, 30))
    assert max(bent(smooth, i, k) for i in range(6, 25)) <= most
    # 0.1 % of the length per squared frame: no kink
    assert max(bent(smooth, i, k) for i in range(1, 30)) < 1e-3 * rough[0][k]
END
}

@test "the blend starts at rest, and the log counts what is inside bones" {
    simulate one.scene.json --frames 0:20 --lengths l.tsv --blend 1 --penetration --log log.jsonl
    simulate one.scene.json --frames 0:20 --lengths l3.tsv --blend 3 --log log3.jsonl
    refute cmp -s l.tsv l3.tsv
    python3 - <<'END'
import json
rows = [line.rstrip("\n").split("\t") for line in open("l.tsv")]
for i in range(1, 21):
    own, blend = (float(rows[1][rows[0].index(n % i)]) for n in ("biceps.%d", "biceps.blend.%d"))
    assert abs(own / blend - 1) < 1e-9
lines = [json.loads(line)["fibers"] for line in open("log.jsonl")]
for l in lines:
    assert l["least_length"] <= l["mean_length"] <= l["greatest_length"]
    for p in (l, l["blend"]):
        assert 0 <= p["inside_bones"] <= 320 and (p["inside_bones"] > 0) == (p["deepest"] > 0) == (p["deepest_bone"] is not None)
assert "inside_bones" not in json.loads(open("log3.jsonl").readline())["fibers"]
END
    mkdir away
    cp one.scene.json filled.muscle.json away
    simulate away/one.scene.json --frames 0:1 --lengths l.tsv --log log.jsonl # needs no bone's surface
    run -1 simulate away/one.scene.json --frames 0:1 --penetration
    [ "$(echo "$output" | wc -l)" -eq 1 ]
}

@test "--plan says what is left out and why, or what it costs" {
    simulate --plan one.scene.json | grep -q 'none of --fibers, --lengths and --penetration'
    simulate --plan some.scene.json --lengths l.tsv > plan.json 2> err
    python3 - <<'END'
import json
m = json.load(open("plan.json"))["plan"]["muscles"]
f = m[0]["fibers"]
assert f["carried"] and f["fibers"] == 20 and f["points"] == 320 and f["weights"] > 320 and f["bytes"] > 8 * f["weights"]
assert f["cut"] == 3e-4 and 0 < f["droppedMean"] <= f["droppedWorst"] < 1 and f["affineError"] < 1e-12 and f["millisecondsPerFrame"] > 0
assert not m[1]["fibers"]["carried"] and "fiber-fill" in m[1]["fibers"]["why"]
END
    [ "$(grep -c 'has no fibres to carry' err)" -eq 2 ]
    [ ! -e l.tsv ]
    simulate --plan one.scene.json --lengths l.tsv --mvc-cut 0 | python3 -c 'import json, sys
m = json.load(sys.stdin)["plan"]["muscles"][0]
ends = 2 * 20  # on the attachment areas, so on the surface, where the three corners of a triangle have all the weight
assert 280 * m["vertices"] < m["fibers"]["weights"] <= 280 * m["vertices"] + max(3, m["vertices"]) * ends and m["fibers"]["droppedWorst"] == 0'
}

@test "impossible requests: one sentence, nothing written" {
    refused() { # STATUS MESSAGE ARGUMENT...
        status=$1 message=$2
        shift 2
        code=0
        simulate "$@" --log no.jsonl 2> err || code=$?
        [ "$code" -eq "$status" ]
        [ "$(wc -l < err)" -eq 1 ]
        grep -q -e "$message" err
        [ ! -e no ]
        [ ! -e no.tsv ]
        [ ! -e no.jsonl ]
    }
    refused 1 "fiber-fill" bare.scene.json --frames 0:1 --lengths no.tsv -o no
    refused 1 "cannot be" one.scene.json --frames 0:1 --lengths nowhere/no.tsv -o no
    refused 2 "say with -o where" one.scene.json --fibers
    refused 2 "needs --lengths" one.scene.json --smooth-lengths -o no
    refused 2 "needs --lengths" one.scene.json --blend 1 -o no
    refused 2 "--blend" one.scene.json --blend 0 --lengths no.tsv
    refused 2 "--mvc-cut" one.scene.json --mvc-cut 0.5 --lengths no.tsv
    refused 2 "mvc-cut" one.scene.json --mvc-cut 0.01 -o no
    refused 2 "embedding-cache" one.scene.json --embedding-cache no -o no
    refused 2 "needs a file" one.scene.json --lengths -
    touch file
    refused 1 "cannot be written: Not a directory" one.scene.json --embedding-cache file/no --lengths no.tsv
    python3 -c 'import json; m = json.load(open("filled.muscle.json")); m["attachments"] = []; json.dump(m, open("loose.muscle.json", "w"))
s = json.load(open("one.scene.json")); s["muscles"][0]["rig"] = "loose.muscle.json"; json.dump(s, open("loose.scene.json", "w"))'
    refused 1 "attach-detect" -q loose.scene.json --lengths no.tsv --blend 1
    python3 -c 'import json; m = json.load(open("filled.muscle.json")); m["fibers"]["polylines"][3]["points"] = [0, 0, 0] * 4; json.dump(m, open("flat.muscle.json", "w"))
s = json.load(open("one.scene.json")); s["muscles"][0]["rig"] = "flat.muscle.json"; json.dump(s, open("flat.scene.json", "w"))'
    refused 1 "fibre 3 has no length" flat.scene.json --lengths no.tsv
}

@test "a run that fails leaves an old table and collection alone" {
    echo old > l.tsv
    echo old > out-fibers.pvd
    sed 's/"scapula"/"shoulder"/g' one.scene.json > lost.scene.json
    run -1 simulate lost.scene.json --frames 0:1 -o out.pc2 --fibers --lengths l.tsv --log log.jsonl
    [ "$(cat l.tsv)" = old ]
    [ "$(cat out-fibers.pvd)" = old ]
}

# ---- real muscles ------------------------------------------------------------------------------------------------------------

# smooth LENGTHS CACHE: every fibre there, lengths of some sense, and no kink: the second difference of each smoothed curve is below 2e-4
# of its length per squared frame
smooth_curves() {
    python3 - "$@" <<'END'
import sys
rows = [line.rstrip("\n").split("\t") for line in open(sys.argv[1])]
names, rows = rows[0], [[float(x) for x in row] for row in rows[1:]]
own = [i for i, n in enumerate(names) if n[-1].isdigit() and ".blend." not in n]
assert len(own) == 100 and len(rows) >= 10
for k in own:
    for i in range(1, len(rows) - 1):
        bend = abs(rows[i - 1][k] - 2 * rows[i][k] + rows[i + 1][k])
        assert bend < 2e-4 * rows[0][k], (names[k], i, bend)
    assert all(0.7 < row[k] / rows[0][k] < 1.3 for row in rows)
# something has happened
assert max(abs(rows[-1][k] / rows[0][k] - 1) for k in own) > 1e-3
END
}
frames() { if [ "${CONFIG:-release}" = release ]; then echo 0:90; else echo 0:12; fi; } # the slow builds look at the beginning only
scene() { # NAME UNIT BONES-JSON JOINT-JSON
    printf '{"format":"sinew-scene","version":1,"metersPerUnit":%s,"rate":24,"frames":[0,90],"motion":{"joints":[%s]},"bones":[%s],
"muscles":[{"name":"%s","rig":"%s.muscle.json","contraction":0.3,"activation":{"keys":[[0,0],[3.75,1]]}}]}' "$2" "$4" "$3" "$1" "$1" > "$1.scene.json"
}

@test "the tibialis anterior: smooth lengths, fewer vertices in bones than the blend's, a chart" {
    leg=$DATA/leg-vhf/meshes/VHF_Left
    [ -e "${leg}_Bone_Talus_smooth.ply" ] || skip "no real anatomy at $DATA"
    mesh-clean --units mm "${leg}_Muscle_TibialisAnterior_smooth.ply" | root-select | build-structure | fiber-flow |
        attach-detect --bone tibia="${leg}_Bone_Tibia_smooth.ply" --pin talus=half:0,0,221.415,0,0,-1 | fiber-fill -o tibialis.muscle.json
    scene tibialis 0.001 "{\"name\":\"tibia\",\"mesh\":\"${leg}_Bone_Tibia_smooth.ply\"},{\"name\":\"talus\",\"mesh\":\"${leg}_Bone_Talus_smooth.ply\",\"joint\":\"ankle\"}" \
        '{"name":"ankle","type":"hinge","axis":[1,0,0],"point":[510.8,425.2,143.2],"keys":[[0,0],[3.75,-30]]}'
    simulate tibialis.scene.json --frames "$(frames)" --lengths l.tsv --smooth-lengths --blend 1 --penetration > log.jsonl
    smooth_curves l.tsv
    python3 -c 'import json
f = [json.loads(line)["fibers"] for line in open("log.jsonl")]
assert f[0]["inside_bones"] == f[0]["blend"]["inside_bones"] <= 100 # fibres begin where the muscle is attached: on the bone, or in it
assert f[-1]["inside_bones"] <= f[-1]["blend"]["inside_bones"]
if len(f) > 90: assert f[-1]["blend"]["inside_bones"] > 0'
    command -v gnuplot > /dev/null || skip "gnuplot is not here"
    "$BATS_TEST_DIRNAME/../../share/plots/fiber-lengths" --over ankle l.tsv l.svg l.png
}

@test "the dog's left biceps brachii: smooth lengths" {
    dog=$DATA/dog-dmcontrol/meshes
    [ -e "$dog/BONEUlna_L.stl" ] || skip "no real anatomy at $DATA"
    mesh-clean "$dog/MUSCm.biceps_brachii_L.stl" | root-select | build-structure | fiber-flow |
        attach-detect --bone scapula="$dog/BONEScapula_L.stl" --bone humerus="$dog/BONEhumerus_L.stl" --bone radius="$dog/BONERadius_L.stl" \
            --bone ulna="$dog/BONEUlna_L.stl" | fiber-fill -o biceps.muscle.json
    scene biceps 1 '{"name":"scapula","mesh":"s.stl"},{"name":"humerus","mesh":"h.stl"},{"name":"radius","mesh":"r.stl","joint":"elbow"},{"name":"ulna","mesh":"u.stl","joint":"elbow"}' \
        '{"name":"elbow","type":"hinge","axis":[0,1,0.2],"point":[0.1454,0.068,0.28022],"keys":[[0,0],[3.75,-30]]}'
    simulate biceps.scene.json --frames "$(frames)" --lengths l.tsv --smooth-lengths > log.jsonl
    smooth_curves l.tsv
}
