# mesh-clean: clean surfaces stay as they are, dirty ones become manifolds, and what cannot be done is said.

bats_require_minimum_version 1.5.0

setup_file() {
    "$EXAMPLES/arm/arm" --out "$BATS_FILE_TMPDIR" --dirty
    export ARM="$BATS_FILE_TMPDIR"
}

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    cat > cube.obj <<'END'
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 1 3 2
f 1 4 3
f 5 6 7
f 5 7 8
f 1 2 6
f 1 6 5
f 2 3 7
f 2 7 6
f 3 4 8
f 3 8 7
f 4 1 5
f 4 5 8
END
}

# value REPORT PATH...: one value of a report
value() { python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); [d := d[int(k) if isinstance(d, list) else k] for k in sys.argv[2:]]; print(d)' "$@"; }

# every muscle of a set: status 0, nothing changed
unchanged() {
    local set="$DATA/$1" mesh count=0
    [ -d "$set" ] || skip "$1 is not here"
    for mesh in $(awk -F'\t' '$2 == "muscle" { print $1 }' "$set/manifest.tsv"); do
        "$BIN/mesh-clean" -q --units mm "$set/meshes/$mesh" -o cleaned.muscle.json --report report.json
        [ "$(value report.json unchanged)" = True ] || { echo "$mesh has changed"; return 1; }
        count=$((count + 1))
    done
    [ "$count" -eq "$2" ]
}

@test "all 38 muscles of leg-vhf come out as they went in" { unchanged leg-vhf 38; }

@test "all 253 muscles of dog-dmcontrol come out as they went in" { unchanged dog-dmcontrol 253; }

@test "an unchanged mesh has the very vertices and triangles of its file, in their order" {
    set="$DATA/leg-vhf"
    [ -d "$set" ] || skip "leg-vhf is not here"
    "$BIN/mesh-clean" -q --units mm "$set/meshes/VHF_Left_Muscle_Soleus_smooth.ply" -o soleus.json
    python3 - "$set/meshes/VHF_Left_Muscle_Soleus_smooth.ply" soleus.json <<'END'
import json, struct, sys
data = open(sys.argv[1], "rb").read()
header, body = data.split(b"end_header\n", 1)
counts = {l.split()[1]: int(l.split()[2]) for l in header.decode().splitlines() if l.startswith("element")}
n, m = counts["vertex"], counts["face"]
assert b"binary_little_endian" in header and len(body) == 12 * n + 13 * m
mesh = json.load(open(sys.argv[2]))["mesh"]
assert tuple(mesh["vertices"]) == struct.unpack_from("<%df" % (3 * n), body)
faces = [v for t in range(m) for v in struct.unpack_from("<3i", body, 12 * n + 13 * t + 1)]
assert mesh["triangles"] == faces
END
}

@test "of the 148 defective muscles of body-bp3d-low, 120 or more come out closed, none fails, and cleaning again changes nothing" {
    set="$DATA/body-bp3d-low"
    [ -d "$set" ] || skip "body-bp3d-low is not here"
    closed=0
    for mesh in $(awk -F'\t' '$2 == "muscle" { print $1 }' "$set/manifest.tsv"); do
        status=0
        "$BIN/mesh-clean" -q --units mm "$set/meshes/$mesh" -o cleaned.ply 2> err || status=$?
        [ "$status" -eq 0 ] || [ "$status" -eq 3 ]
        if "$BIN/mesh-clean" -q --check cleaned.ply 2> err; then closed=$((closed + 1)); fi
        "$BIN/mesh-clean" -q cleaned.ply -o again.ply --report again.json 2> err || [ "$?" -eq 3 ]
        [ "$(value again.json unchanged)" = True ] || { echo "$mesh is not clean the second time"; return 1; }
    done
    echo "$closed closed"
    [ "$closed" -ge 120 ]
}

@test "the dirty biceps becomes the clean one" {
    "$BIN/mesh-clean" -q "$ARM/biceps-dirty.obj" -o cleaned.ply --report report.json
    "$BIN/mesh-clean" --check "$ARM/biceps.ply" --report clean.json
    "$BIN/mesh-clean" --check cleaned.ply
    [ "$(value report.json after genus)" = 0 ]
    python3 - "$(value report.json after volume)" "$(value clean.json before volume)" <<'END'
import sys
cleaned, clean = map(float, sys.argv[1:])
assert abs(cleaned / clean - 1) < 1e-3, (cleaned, clean)
END
    [ "$(value report.json welded)" -gt 0 ]
    [ "$(value report.json duplicate)" -gt 0 ]
    [ "$(value report.json flippedTriangles)" -gt 0 ]
    [ "$(value report.json holesFilled)" -gt 0 ]
    [ "$(python3 -c 'import json; print(len(json.load(open("report.json"))["dropped"]))')" -eq 1 ]
}

@test "cleaning twice changes nothing, and files and pipes give the same bytes" {
    "$BIN/mesh-clean" -q --no-history "$ARM/biceps-dirty.obj" -o once.json
    "$BIN/mesh-clean" -q --no-history < "$ARM/biceps-dirty.obj" > piped.json
    # a document takes the name of its file where it has one
    python3 -c 'import json; a, b = (json.load(open(f))["mesh"] for f in ("once.json", "piped.json")); assert a == b'
    "$BIN/mesh-clean" -q --no-history once.json --report report.json > twice.json
    cmp once.json twice.json
    [ "$(value report.json unchanged)" = True ]
    "$BIN/mesh-clean" -q "$ARM/biceps-dirty.obj" > first
    "$BIN/mesh-clean" -q "$ARM/biceps-dirty.obj" > second
    cmp first second
}

@test "--check says what is wrong, writes nothing, and exits with 3" {
    run -0 "$BIN/mesh-clean" --check cube.obj
    [ -z "$output" ]
    sed -i '$d' cube.obj
    run -3 --separate-stderr "$BIN/mesh-clean" --check cube.obj --report report.json
    [ -z "$output" ]
    [ "$stderr" = "mesh-clean: cube.obj: 3 boundary edges" ]
    [ "$(value report.json before boundaryEdges)" -eq 3 ]
    run -2 "$BIN/mesh-clean" --check cube.obj -o x.ply
    [ ! -e x.ply ]
}

@test "crossing triangles are found by --self-intersections" {
    sed 's/^v 1 1 1/v -0.5 -0.5 0.5/' cube.obj > crossed.obj
    run -3 "$BIN/mesh-clean" --check --self-intersections crossed.obj
    [[ "$output" == *"that cross"* ]]
    run -0 "$BIN/mesh-clean" --check --self-intersections cube.obj
}

@test "what is still open is written with status 3 and one sentence" {
    sed -i '$d' cube.obj
    run -3 --separate-stderr "$BIN/mesh-clean" --max-hole 0 cube.obj -o open.ply
    [ -s open.ply ]
    [ "${#stderr_lines[@]}" -eq 1 ]
    [[ "$stderr" == *"3 boundary edges"* ]]
    run -0 "$BIN/mesh-clean" cube.obj -o closed.ply
    run -0 "$BIN/mesh-clean" --check closed.ply
}

@test "a one-sided surface is said to be one" {
    python3 > moebius.obj <<'END'
from math import cos, pi, sin
n = 20
for i in range(n):
    t = 2 * pi * i / n
    for s in (-0.3, 0.3):
        r = 1 + s * cos(t / 2)
        print("v", r * cos(t), r * sin(t), s * sin(t / 2))
for i in range(n):
    a, b, c, d = 2 * i + 1, 2 * i + 2, 2 * i + 3, 2 * i + 4
    if i == n - 1:
        c, d = 2, 1
    print("f", a, c, b)
    print("f", b, c, d)
END
    run -3 --separate-stderr "$BIN/mesh-clean" moebius.obj -o x.ply
    [[ "$stderr" == *"one-sided"* ]]
}

@test "a lone triangle stays open, and a folded sheet is said to enclose nothing" {
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > triangle.obj
    run -3 --separate-stderr "$BIN/mesh-clean" triangle.obj -o x.ply
    [[ "$stderr" == *"3 boundary edges"* ]]
    printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n' > sheet.obj
    run -3 --separate-stderr "$BIN/mesh-clean" sheet.obj -o x.ply
    [[ "$stderr" == *"no volume"* ]]
}

@test "a coordinate that is not finite is an error that names the vertex, or repaired on request" {
    sed 's/^v 1 1 1/v nan 1 1/' cube.obj > nan.obj
    run -1 --separate-stderr "$BIN/mesh-clean" nan.obj -o x.ply
    [[ "$stderr" == *"nan.obj"*"vertex 6"*"--repair-nonfinite"* ]]
    [ ! -e x.ply ]
    run -0 "$BIN/mesh-clean" -q --repair-nonfinite nan.obj -o repaired.ply
    run -0 "$BIN/mesh-clean" --check repaired.ply
}

@test "what has no area is an error" {
    printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' > line.obj
    printf 'v 3 3 3\nv 3 3 3\nv 3 3 3\nf 1 2 3\n' > point.obj
    printf 'v 0 0 0\nv 1e300 0 0\nv 0 1e300 0\nf 1 2 3\n' > huge.obj
    for mesh in line point huge; do
        run -1 --separate-stderr "$BIN/mesh-clean" $mesh.obj -o x.ply
        [ "${#stderr_lines[@]}" -eq 1 ]
        [[ "$stderr" == "mesh-clean: $mesh.obj: "* ]]
        [ ! -e x.ply ]
    done
}

@test "--keep takes largest, all or a number" {
    { cat cube.obj; sed -n 's/^v \(.*\) \(.*\) \(.*\)/\1 \2 \3/p' cube.obj | awk '{ print "v", $1 / 2 + 5, $2 / 2, $3 / 2 }'
      sed -n 's/^f //p' cube.obj | awk '{ print "f", $1 + 8, $2 + 8, $3 + 8 }'; } > two.obj
    "$BIN/mesh-clean" two.obj --report report.json 2> err > /dev/null
    grep -q "dropped 1 component with 20 %" err
    [ "$(value report.json after components)" -eq 1 ]
    [ "$(value report.json dropped 0 area)" = 1.5 ]
    for keep in all 2 7; do
        "$BIN/mesh-clean" --keep $keep two.obj --report report.json > /dev/null
        [ "$(value report.json after components)" -eq 2 ]
    done
    run -2 "$BIN/mesh-clean" --keep 0 two.obj
    run -2 "$BIN/mesh-clean" --keep most two.obj
}

@test "--triangles decimates to the target and keeps the volume" {
    "$BIN/mesh-clean" --triangles 600 "$ARM/biceps.ply" -o coarse.ply --report report.json
    [ "$(value report.json after triangles)" -le 600 ]
    [ "$(value report.json after triangles)" -ge 590 ]
    [ "$(value report.json after closed)" = True ]
    python3 - report.json <<'END'
import json, sys
r = json.load(open(sys.argv[1]))
assert abs(r["after"]["volume"] / r["before"]["volume"] - 1) < 0.02
assert r["moved"] < 0.01 * r["before"]["diagonal"]
END
    run -2 "$BIN/mesh-clean" --triangles 3 "$ARM/biceps.ply"
}

@test "--stop-after writes the mesh as it is then, and --trace says what was done" {
    "$BIN/mesh-clean" -q --trace trace.jsonl "$ARM/biceps-dirty.obj" -o whole.ply
    steps=$(wc -l < trace.jsonl)
    [ "$steps" -ge 7 ]
    python3 -c 'import json; [json.loads(line) for line in open("trace.jsonl")]'
    for n in $(seq 0 "$steps"); do
        "$BIN/mesh-clean" -q --stop-after "$n" "$ARM/biceps-dirty.obj" -o part.ply
        run "$BIN/mesh-clean" --check part.ply
        [ "$status" -eq 0 ] || [ "$status" -eq 3 ]
    done
    cmp part.ply whole.ply
}

@test "painted values stay on their vertices" {
    cat > painted.ply <<'END'
ply
format ascii 1.0
element vertex 5
property double x
property double y
property double z
property double share
element face 4
property list uchar int vertex_indices
end_header
9 9 9 5
0 0 0 0.5
1 0 0 1.5
0 1 0 2.5
0 0 1 3.5
3 1 3 2
3 1 2 4
3 2 3 4
3 3 1 4
END
    "$BIN/mesh-clean" -q painted.ply -o out.ply --report report.json
    [ "$(value report.json unused)" -eq 1 ]
    "$BIN/mesh-clean" -q out.ply -o out.off
    [ "$(sed -n 2p out.off | cut -d' ' -f1)" -eq 4 ]
    LC_ALL=C grep -aq "property double share" out.ply
}

@test "the report has every figure and the time of each step" {
    "$BIN/mesh-clean" -q "$ARM/biceps-dirty.obj" -o x.ply --report report.json
    python3 - report.json <<'END'
import json, sys
r = json.load(open(sys.argv[1]))
for key in ("before", "after", "welded", "dropped", "hausdorff", "moved", "stageSeconds", "tool", "version", "seconds"):
    assert key in r, key
for key in ("input", "weld", "drop", "manifold", "components", "holes", "outward"):
    assert r["stageSeconds"][key] >= 0, key
assert r["after"]["genus"] == 0 and r["before"]["genus"] is None
END
}

@test "-v prints a table, -q nothing" {
    run -0 --separate-stderr "$BIN/mesh-clean" -v "$ARM/biceps-dirty.obj" -o x.ply
    [[ "$stderr" == *"boundary edges"* ]]
    run -0 --separate-stderr "$BIN/mesh-clean" -q "$ARM/biceps-dirty.obj" -o x.ply
    [ -z "$stderr" ]
}
