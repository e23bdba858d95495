# The dog's hip of share/examples/hip: areas grown around its sites, and what Kohout and Cervenka (2021) ask of muscles around a hip that flexes.

bats_require_minimum_version 1.5.0

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    PATH=$BIN:$PATH
    HIP=$BATS_TEST_DIRNAME/../../share/examples/hip
    export EXAMPLES PATH
}

# sites NAME ...: of the generated biceps, near both ends
sites() { printf 'bone\tarea\tx\ty\tz\n'; printf '%s\n' "$@"; }

@test "areas grow around sites: a closed line of landmarks at one distance, apart from each other" {
    "$EXAMPLES/arm/arm" --out arm -t 4000 > /dev/null
    mesh-clean -q arm/biceps.ply -o biceps.ply
    sites "$(printf 'humerus\torigin\t0.02\t0\t0.2')" "$(printf 'radius\tinsertion\t0.015\t-0.005\t-0.03')" > sites.tsv
    "$EXAMPLES/hip/areas" biceps.ply sites.tsv 5% 16 > areas.tsv 2> said
    [ "$(grep -c origin areas.tsv)" -eq 16 ]
    [ "$(grep -c insertion areas.tsv)" -eq 16 ]
    grep -q '^areas: origin on humerus: radius' said
    # straight ways are no longer than those along the surface; around the belly's site opposite points are far apart (the insertion's is at a tip)
    awk -F '\t' 'FNR == 1 { file++ } file == 1 { sub(/.*radius /, ""); r[++n] = $0; next }
        { k = $2 == "origin" ? 1 : 2; i = ++c[k]; x[k, i] = $3; y[k, i] = $4; z[k, i] = $5 }
        END { for (k = 1; k <= 2; k++) for (i = 1; i <= 8; i++) { j = i + 8
            d = sqrt((x[k, i] - x[k, j])^2 + (y[k, i] - y[k, j])^2 + (z[k, i] - z[k, j])^2)
            if (!(d <= 2.05 * r[k] && (k == 2 || d > 0.4 * r[k]))) { print k, i, d, r[k]; exit 1 } } }' said areas.tsv
    # an area of attach-detect from them holds vertices within the radius, and none beyond
    attach-detect -q --method area --landmarks areas.tsv biceps.ply -o rig.muscle.json
    /usr/bin/python3 - << 'END'
import json, math
d = json.load(open("rig.muscle.json")); p = d["mesh"]["vertices"]; p = [p[3*i:3*i+3] for i in range(len(p)//3)] if not isinstance(p[0], list) else p
radius = [float(l.split("radius ")[1]) for l in open("said")]
sites = [list(map(float, l.split("\t")[2:])) for l in open("sites.tsv").read().splitlines()[1:]]
held = {a["end"]: a["vertices"] for a in d["attachments"]}
for end, site, r in zip(("origin", "insertion"), sites, radius):
    near = min(range(len(p)), key=lambda v: math.dist(p[v], site))
    assert near in held[end] and len(held[end]) > 10, (end, near)
    assert max(math.dist(p[v], p[near]) for v in held[end]) < 1.1 * r, end
    assert not set(held["origin"]) & set(held["insertion"])
END
}

@test "sites that are another's, in another unit, or malformed are refused, and so is a surface that is not closed" {
    "$EXAMPLES/arm/arm" --out arm -t 1000 > /dev/null
    mesh-clean -q arm/biceps.ply -o biceps.ply
    sites "$(printf 'humerus\torigin\t20\t0\t200')" > mm.tsv
    run -1 "$EXAMPLES/hip/areas" biceps.ply mm.tsv 5%
    [[ "$output" == *"another's, or in another unit"* ]]
    sites "$(printf 'humerus\torigin\t0.02\t0')" > short.tsv
    run -1 "$EXAMPLES/hip/areas" biceps.ply short.tsv 5%
    sites > none.tsv
    sed -i '2d' none.tsv
    run -1 "$EXAMPLES/hip/areas" biceps.ply none.tsv 5%
    [[ "$output" == *"no site"* ]]
    sites "$(printf 'humerus\torigin\t0.02\t0\t0.2')" > one.tsv
    for radius in 0 -1 x 5%x 5%,; do run -1 "$EXAMPLES/hip/areas" biceps.ply one.tsv "$radius"; done
    run -2 "$EXAMPLES/hip/areas" biceps.ply one.tsv
    # two sites at one place leave no room
    sites "$(printf 'a\torigin\t0.02\t0\t0.2')" "$(printf 'b\torigin 2\t0.02\t0\t0.2001')" > same.tsv
    run -1 "$EXAMPLES/hip/areas" biceps.ply same.tsv 5%
    [[ "$output" == *"no radius above"* ]]
}

@test "moment arms of a table: a strap over a cylinder gives its radius, each sweep by itself, and a second that is off is told" {
    # l = 0.2 + r q there (r = 20 mm), and back with r = 21 mm from where it was; the corner where it turns is in neither sweep
    awk 'BEGIN { print "time\tq.rad\tm.1\tm.2"; for (i = 0; i <= 40; i++) { q = (i <= 20 ? i : 40 - i) * 0.05; r = i <= 20 ? 0.02 : 0.021
        print i / 10 "\t" q "\t" 0.2 + r * (q - 1) + 0.0 "\t" 0.3 - 2 * r * (q - 1) } }' > l.tsv
    awk -f "$HIP/arms.awk" -v over=q.rad -v summary=s.tsv l.tsv > a.tsv
    [ "$(wc -l < a.tsv)" -eq 39 ]
    awk -F '\t' 'NR > 1 { r = $2 == 1 ? 20 : 21
        if (!($4 > 0.5 * r - 1e-3 && $4 < 0.5 * r + 1e-3 && $5 > -r - 1e-3 && $5 < -r + 1e-3 && $6 > 2 * r - 1e-3 && $6 < 2 * r + 1e-3)) exit 1 }' a.tsv
    awk -F '\t' 'NR > 1 { exit !($1 == "m" && $2 == 2 && $7 == 1 && $10 > 0.499 && $10 < 0.501 && $11 > 99.9 && $11 < 100.1) }' s.tsv
    # turned around the arm changes its sign
    awk -f "$HIP/arms.awk" -v over=q.rad -v sign=-1 l.tsv | awk -F '\t' 'NR > 1 && !($4 < -9.99 && $4 > -10.51) { exit 1 }'
    # a sine: the derivative, but for what smoothing and differences take
    awk 'BEGIN { print "time\tk.angle\tm.1"; for (i = 0; i <= 45; i++) print i "\t" 2 * i "\t" 0.1 - 0.03 * sin(2 * i * 0.017453292519943295) }' > l.tsv
    awk -f "$HIP/arms.awk" -v over=k.angle l.tsv | awk -F '\t' 'NR > 1 && $3 > 10 && $3 < 80 { d = $4 - 30 * cos($3 * 0.017453292519943295); if (d > 0.15 || d < -0.15) exit 1; n++ } END { exit n < 30 }'
    run -1 awk -f "$HIP/arms.awk" -v over=nothing.rad l.tsv
    run -1 awk -f "$HIP/arms.awk" -v over=time l.tsv
    awk '{ print $1 "\t0\t" $3 }' l.tsv | sed '1s/.*/time\tk.angle\tm.1/' > still.tsv
    run -1 awk -f "$HIP/arms.awk" -v over=k.angle still.tsv
}

@test "a joint of one's own: landmarks as they are, a site beside them; areas on one bone alone are refused" {
    "$EXAMPLES/arm/arm" --out arm -t 1000 > /dev/null
    mkdir bones
    cp arm/scapula.ply arm/radius.ply bones/
    printf 'biceps\t%s\n' "$PWD/arm/biceps.ply" > muscles.tsv
    # landmarks around the lower end, from a first run; a site at the upper
    mesh-clean -q arm/biceps.ply -o b.ply
    printf 'radius\tinsertion\t0.015\t-0.005\t-0.03\n' > site.tsv
    "$EXAMPLES/hip/areas" b.ply site.tsv 5% > ring.tsv
    { sed 's/^/biceps\t/' ring.tsv; printf 'biceps\tscapula\torigin\t0.02\t0\t0.2\n'; } > landmarks.tsv
    cat > m.motion.json << 'END'
{"format": "sinew-motion", "version": 1, "metersPerUnit": 1, "rate": 24, "joints": [{"name": "elbow", "type": "hinge", "point": [0, 0, 0], "axis": [0, -1, 0],
 "keys": [[0, 0], [0.5, 20], [1, 0]], "interpolation": "linear"}]}
END
    "$HIP/joint.sh" -e 0 -f 10 -n mine -j radius=elbow -s 'b*.density=1000' out muscles.tsv landmarks.tsv bones m.motion.json > said
    grep -q '^joint.sh: biceps: origin on scapula: radius' said
    ! grep -q 'insertion on radius' said
    cmp <(sort ring.tsv) <(grep insertion out/areas/biceps.tsv | sort)
    /usr/bin/python3 -c '
import json
s = json.load(open("out/mine.scene.json")); assert s["contact"] is True and s["muscles"][0]["density"] == 1000, s
assert {b["name"]: b.get("joint") for b in s["bones"]} == {"radius": "elbow", "scapula": None}, s["bones"]
m = json.load(open("out/rigs/biceps.muscle.json")); assert {a["bone"]: a["end"] for a in m["attachments"]} == {"radius": "insertion", "scapula": "origin"}
assert len(m["fibers"]["polylines"]) == 10'
    "$HIP/sweep.sh" -o there out/mine.scene.json elbow.angle > said
    [ "$(wc -l < there/sweep.tsv)" -eq 2 ]
    head -c 5 there/arms.svg | grep -q '<'
    run -1 "$HIP/sweep.sh" -o there out/mine.scene.json knee.angle
    [[ "$output" == *"there is no column knee.angle"* ]]
    sed '/scapula/d' landmarks.tsv > one.tsv
    run -1 "$HIP/joint.sh" -e 0 out muscles.tsv one.tsv bones m.motion.json
    [[ "$output" == *"one bone alone"* ]]
    printf 'triceps\t%s\n' "$PWD/arm/triceps.ply" > muscles.tsv
    run -1 "$HIP/joint.sh" -e 0 out muscles.tsv landmarks.tsv bones m.motion.json
    [[ "$output" == *"triceps has no landmarks"* ]]
    run -2 "$HIP/joint.sh" out
    run -1 "$HIP/dog.sh" nowhere out
    [[ "$output" == *"no dog.xml"* ]]
}

@test "flexion goes there and back in whole steps" {
    awk -f "$HIP/flexion.awk" -v coordinate=c -v to=-90 > f.sto
    awk '/^time/ { on = 1; next } on { v[n++] = $2 } END { exit !(n == 91 && v[0] == 0 && v[45] == -90 && v[90] == 0 && v[1] == -2 && v[46] == -88) }' f.sto
    run -1 awk -f "$HIP/flexion.awk" -v coordinate=c -v to=0
    run -1 awk -f "$HIP/flexion.awk" -v to=90
}

@test "the dog's hip flexes by 90 degrees and goes back: out of the bones, volumes, lengths of extensors and flexors, moment arms both ways" {
    [ -f "$DATA/dog-dmcontrol/dog.xml" ] || skip "no dog-dmcontrol in DATA"
    [ "$CONFIG" != sanitize ] && [ "$CONFIG" != thread ] && [ "$CONFIG" != debug ] || skip "too slow in this configuration"
    "$HIP/dog.sh" "$DATA/dog-dmcontrol" hip > said
    "$HIP/sweep.sh" -o out -s -1 hip/hip.scene.json hip_L_extend.rad
    /usr/bin/python3 - << 'END'
import csv, json, math
rows = {r[0]: r for r in csv.reader(open("out/sweep.tsv"), delimiter="\t")}
names = rows.pop("muscle")
extensors = ["gluteus_superficialis_major", "gluteus_medius", "gluteus_profundus_minor", "adductor_magnus"]
flexors = ["iliacus", "psoas_major"]
assert set(rows) == {*extensors, *flexors, "adductor_longus"}, rows
get = lambda m, n: float(rows[m][names.index(n)])
for m in rows:
    assert get(m, "deepest_mm") <= 0.2 and get(m, "volume_error_%") < 1 and get(m, "torn_frames") == 0, rows[m]
    assert get(m, "fibres") == 100 and get(m, "difference_%") <= 5, rows[m]
# both bones hold each muscle, by areas
for m in rows:
    held = json.load(open(f"hip/rigs/{m}.muscle.json"))["attachments"]
    assert {a["end"] for a in held} == {"origin", "insertion"} and all(a["method"] == "area" and len(a["vertices"]) >= 6 for a in held), m
# contact did something, and frames are all there
log = [json.loads(line) for line in open("out/log.jsonl")]
assert len(log) == 7 * 91 and sum(d["contacts"] for d in log) > 1000 and not any(d["nan"] for d in log)
lengths = [line.split("\t") for line in open("out/lengths.tsv").read().splitlines()]
q = [-math.degrees(float(r[lengths[0].index("hip_L_extend.rad")])) for r in lengths[1:]]
assert len(q) == 91 and abs(q[45] - 90) < 1e-6 and abs(q[20] - 40) < 1e-6
column = {n: [float(r[i]) for r in lengths[1:]] for i, n in enumerate(lengths[0])}
def fibres(m): return [column[f"{m}.{i}"] for i in range(1, 101)]
for m in extensors: # every fibre is longer at 90 degrees
    assert all(f[45] > f[0] for f in fibres(m)), m
# flexors shrink, up to 56 and 38 degrees; then they grow, the exception: by less than 10 % (every fibre of iliacus is still shorter at 90 degrees
# than at 0) and 5 % (psoas is as long as at 0 again). The lesser trochanter has turned past the line from the hip to where they come from
assert all(f[45] < f[0] for f in fibres("iliacus"))
for m, least, most, rise in (("iliacus", 50, 75, 0.10), ("psoas_major", 30, 60, 0.05)):
    mean = [sum(f[i] for f in fibres(m)) / 100 for i in range(46)]
    low = min(range(46), key=lambda i: mean[i])
    assert mean[45] < 1.01 * mean[0] and least <= q[low] <= most and mean[low] < 0.98 * mean[0] and mean[45] < (1 + rise) * mean[low], (m, mean[0], mean[low], q[low], mean[45])
    assert all(b < a for a, b in zip(mean[:low], mean[1:low + 1])), m
# the adductor longus runs across, at the height of the joint: a flexor, then an extensor; nothing is gained or lost by more than 10 %
mean = [sum(f[i] for f in fibres("adductor_longus")) / 100 for i in range(46)]
assert max(mean) < 1.001 * mean[0] and min(mean) > 0.9 * mean[0]
# signs of the arms, and of the right size: none is longer than the bones are wide
for m in extensors[:2] + ["adductor_magnus"]: assert get(m, "arm_greatest_mm") < 0, m
for m in flexors: assert get(m, "arm_greatest_mm") > 5, m
assert all(-40 < get(m, "arm_least_mm") and get(m, "arm_greatest_mm") < 25 for m in rows)
END
    [ "$(head -c 4 out/arms.png | tail -c 3)" = PNG ]
}
