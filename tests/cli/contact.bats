# Contact of muscles with bones: what is said and planned, off is absent, caches, stop and go on, real anatomy.

bats_require_minimum_version 1.5.0

schemas="$BATS_TEST_DIRNAME/../../share/schema"

setup_file() {
    export SAMPLE="$BATS_FILE_TMPDIR/sample"
    sh "$BATS_TEST_DIRNAME/../sample-folder" "$BIN" "$EXAMPLES" "$SAMPLE"
}

setup() {
    cp -r "$SAMPLE" "$BATS_TEST_TMPDIR/arm"
    cd "$BATS_TEST_TMPDIR/arm" || exit 1
    mkdir a b
}

ask() { /usr/bin/python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); assert eval(sys.argv[2]), d' "$@"; }

# set FILE EXPRESSION: arm.scene.json changed by a statement on the document s, into FILE
change() { /usr/bin/python3 -c 'import json, sys; s = json.load(open("arm.scene.json")); exec(sys.argv[2]); json.dump(s, open(sys.argv[1], "w"))' "$@"; }

# least DISTANCE of a muscle's frame to ...: largest penetration and contacts of a log
worst() { /usr/bin/python3 -c '
import json, sys
lines = [json.loads(l) for l in open(sys.argv[1])]
print(max(d["penetration"] for d in lines), sum(d["contacts"] for d in lines))' "$1"; }

@test "the arm bends without a vertex in a bone, where without contact there are some; the bytes of one thread and of four are the same" {
    "$BIN/simulate" -q arm.scene.json --contact -o a --log a.jsonl --threads 1
    "$BIN/simulate" -q arm.scene.json --contact -o b --log b.jsonl --threads 4
    cmp a.jsonl b.jsonl
    for muscle in biceps brachialis triceps; do cmp a/$muscle.pc2 b/$muscle.pc2; done
    read -r depth contacts <<< "$(worst a.jsonl)"
    [ "$contacts" -gt 50 ]
    /usr/bin/python3 -c 'import sys; assert float(sys.argv[1]) < 1e-8, sys.argv' "$depth"
    # the same rows without a push: contact that is there, but whose margin is never felt, is how deep they would be
    "$BIN/simulate" -q arm.scene.json -o b --log off.jsonl
    ! cmp -s a/brachialis.pc2 b/brachialis.pc2
    ! grep -q penetration off.jsonl
}

@test "contact that is off is absent: options, member false, muscles and bones left out" {
    "$BIN/simulate" -q arm.scene.json -o a --log a.jsonl
    change off.scene.json 's["contact"] = False'
    "$BIN/simulate" -q off.scene.json -o b --log b.jsonl
    cmp a.jsonl b.jsonl; cmp a/brachialis.pc2 b/brachialis.pc2
    change on.scene.json 's["contact"] = True'
    "$BIN/simulate" -q on.scene.json --no-contact -o b --log b.jsonl
    cmp a.jsonl b.jsonl
    change out.scene.json 's["contact"] = {"enabled": True}; [m.update(contact=False) for m in s["muscles"]]'
    "$BIN/simulate" -q out.scene.json -o b --log b.jsonl
    cmp a.jsonl b.jsonl
    change bones.scene.json 's["contact"] = True; [m.update(contact=False) for m in s["bones"]]'
    "$BIN/simulate" -q bones.scene.json -o b --log b.jsonl
    cmp a.jsonl b.jsonl
    "$BIN/simulate" --plan bones.scene.json > plan.json
    ask plan.json 'all(g.get("leftOut") == "no bone comes near it over the motion" for m in d["plan"]["muscles"] for g in m["groups"] if g["kind"] == "contact")'
    ask plan.json 'd["plan"]["contact"]["fields"] == [] and d["plan"]["muscles"][0]["bonesLeftOut"] == 4'
}

@test "the plan tells who may touch whom, what that takes, and every default; the schema knows it" {
    change on.scene.json 's["contact"] = {"margin": 0.0004, "cell": 0.003, "resolve": 1, "samples": 1}; s["bones"][0]["contact"] = False'
    "$BIN/simulate" --plan on.scene.json > plan.json
    ask plan.json 'dict(d["scene"]["contact"], margin=0.0004, cell=0.003, friction=0, resolve=1, samples=1) == d["scene"]["contact"]'
    ask plan.json 'd["scene"]["bones"][0]["contact"] is False and "contact" not in d["scene"]["bones"][1]'
    ask plan.json '"humerus" in d["plan"]["muscles"][0]["bonesInReach"] and "scapula" not in d["plan"]["muscles"][0]["bonesInReach"]'
    ask plan.json '[f["cell"] for f in d["plan"]["contact"]["fields"]] == [0.003] * len(d["plan"]["contact"]["fields"])'
    /usr/bin/python3 -c 'import json; json.dump(json.load(open("plan.json"))["scene"], open("full.scene.json", "w"))'
    "$BIN/simulate" -q on.scene.json --frames 0:9 -o a --log a.jsonl
    "$BIN/simulate" -q full.scene.json --frames 0:9 -o b --log b.jsonl
    cmp a.jsonl b.jsonl
    if /usr/bin/python3 -c 'import jsonschema' 2> /dev/null; then
        /usr/bin/python3 -c 'import json, sys, jsonschema
schema = json.load(open(sys.argv[1] + "/scene.schema.json"))
for name in sys.argv[2:]: jsonschema.Draft202012Validator(schema).validate(json.load(open(name)))' "$schemas" on.scene.json full.scene.json
    fi
}

@test "a run that is stopped and goes on, also over other frames, gives the same bytes" {
    "$BIN/simulate" -q arm.scene.json --contact --frames 0:40 -o a --log a.jsonl
    "$BIN/simulate" -q arm.scene.json --contact --frames 0:17 -o b --log b1.jsonl --state s.state
    "$BIN/simulate" -q arm.scene.json --contact --from s.state --frames 18:40 -o b --log b2.jsonl
    cat b1.jsonl b2.jsonl | cmp - a.jsonl
    "$BIN/simulate" -q arm.scene.json --contact --frames 0:40 --stop-after 30:1:4 --state s.state -o b --log b3.jsonl
    "$BIN/simulate" -q arm.scene.json --contact --from s.state --frames 30:40 -o b --log b4.jsonl
    head -n 90 a.jsonl > head; head -n 90 b3.jsonl | cmp - head
    tail -n 33 a.jsonl | cmp - b4.jsonl
    run -1 "$BIN/simulate" -q arm.scene.json --from s.state --frames 30:40 -o b
    "$BIN/rig-view" -q arm.scene.json --contact --state s.state --error pressure,penetration,contact -o p.png
    [ -s p.png ]
}

@test "--grid-cache: built once, read then, the same bytes; a damaged file is told and built anew" {
    "$BIN/simulate" -q arm.scene.json --contact --frames 0:5 --grid-cache cache -o a --log a.jsonl --report a.json
    ask a.json 'd["contact"]["fieldsBuilt"] == 4 and d["contact"]["fieldsRead"] == 0'
    "$BIN/simulate" -q arm.scene.json --contact --frames 0:5 --grid-cache cache -o b --log b.jsonl --report b.json
    ask b.json 'd["contact"]["fieldsBuilt"] == 0 and d["contact"]["fieldsRead"] == 4'
    cmp a.jsonl b.jsonl
    for f in cache/*; do head -c 200 "$f" > cut; cp cut "$f"; break; done
    "$BIN/simulate" arm.scene.json --contact --frames 0:5 --grid-cache cache -o b --log b.jsonl --report b.json 2> err
    cmp a.jsonl b.jsonl
    grep -q "$f" err
    ask b.json 'd["contact"]["fieldsBuilt"] == 1'
}

@test "what is wrong is said: options without contact, negative numbers, a bone without a surface" {
    "$BIN/simulate" arm.scene.json --frames 0:0 --margin 1mm -o a 2> err > log
    grep -q -- '--margin has no effect: contact is off' err
    run -2 "$BIN/simulate" arm.scene.json --contact --no-contact
    run -2 "$BIN/simulate" arm.scene.json --contact --contact-samples 2
    change bad.scene.json 's["contact"] = {"margin": -1}'
    run -1 "$BIN/simulate" bad.scene.json
    change bad.scene.json 's["contact"] = {"samples": 2}'
    run -1 "$BIN/simulate" bad.scene.json
    change bad.scene.json 's["contact"] = {"marign": 1}'
    "$BIN/simulate" -q bad.scene.json --frames 0:0 -o a 2> err > log || true
    "$BIN/simulate" bad.scene.json --frames 0:0 -o a 2> err > log
    grep -q marign err
    change friction.scene.json 's["contact"] = {"friction": 0.5}'
    "$BIN/simulate" friction.scene.json --frames 0:0 -o a 2> err > log
    grep -q 'friction is felt under the solver xpbd alone' err
    "$BIN/simulate" arm.scene.json --contact --frames 0:0 --grid-cell 50mm -o a 2> err > log
    grep -q 'bone "humerus": cells of 50 mm are too coarse' err
    "$BIN/simulate" -q arm.scene.json --contact --grid-cell 1um --frames 0:0 -o a > log 2> err && false
    grep -q 'cell' err
}

@test "--resolve takes out in its time what lies in a bone at rest, and says what was there and is left" {
    change in.scene.json 's["contact"] = True; s["motion"]["joints"][0]["keys"] = [[0, 0], [1, 0]]; s["frames"] = [0, 30]; [m.update(activation=0) for m in s["muscles"]]'
    # a humerus twice as thick lies in the muscles around it
    "$BIN/mesh-clean" -q humerus.ply -o humerus.obj
    awk '$1 == "v" { printf "v %.9g %.9g %.9g\n", $2 * 2, $3 * 2, $4; next } { print }' humerus.obj > thick.obj
    sed -i 's/humerus.ply/thick.obj/' in.scene.json
    "$BIN/simulate" in.scene.json -o a --log a.jsonl --fail-on 'penetration>1e-6' 2> err
    grep -Eq 'at rest [0-9]+ vertices of [0-9]+ muscles? lie in bones, .*--resolve takes them out' err
    # what a preroll has put to sleep wakes for it, also where it takes less than a substep
    "$BIN/simulate" in.scene.json --resolve 1e-9 --preroll 3 -o b 2> err
    grep -Eq 'lie in bones, .*; now 0 mm$' err || { cat err; false; }
    "$BIN/simulate" in.scene.json --resolve 0.5 -o b --log b.jsonl 2> err
    grep -Eq 'lie in bones, .*; now 0 mm$' err || { cat err; false; }
    /usr/bin/python3 -c '
import json
def deepest(name): 
    d = {}
    for l in open(name): l = json.loads(l); d[l["frame"]] = max(d.get(l["frame"], 0), l["overlap"])
    return d
kept, out = deepest("a.jsonl"), deepest("b.jsonl")
assert kept[0] > 5e-4 and abs(kept[30] - kept[0]) < 1e-4, kept
assert out[0] > 5e-4 and out[6] < 0.7 * out[0] and out[13] == 0 and out[30] == 0, out'
}

@test "--fail-on penetration; xpbd, single precision and each matrix keep out, too" {
    for how in "--solver xpbd" "--solver xpbd --precision single" "--preconditioner corotated" "--preconditioner two-level" "--substeps 2"; do
        # shellcheck disable=SC2086
        "$BIN/simulate" -q arm.scene.json --contact --frames 0:50 $how -o a --log a.jsonl --fail-on 'penetration>1e-5' || { echo "$how"; worst a.jsonl; false; }
        read -r depth contacts <<< "$(worst a.jsonl)"
        [ "$contacts" -gt 20 ] || { echo "$how: $contacts"; false; }
    done
}

@test "twelve muscles of a dog's hind leg beside their bones: none enters, and they stretch as in the converged solve" {
    [ -f "$DATA/dog-dmcontrol/dog.xml" ] || skip "no dog-dmcontrol in DATA"
    [ "$CONFIG" != sanitize ] || skip "too slow under the sanitizers"
    "$BATS_TEST_DIRNAME/../../share/examples/dog/hind-leg.sh" "$BIN" "$DATA/dog-dmcontrol" dog 2> err
    cd dog
    mkdir on converged
    "$BIN/simulate" -q hind-leg.scene.json --contact --grid-cache cache -o on --log on.jsonl
    "$BIN/simulate" -q hind-leg.scene.json --contact --grid-cache cache --iterations 400 --tolerance 1e-9 -o converged --log converged.jsonl
    /usr/bin/python3 << 'END'
import json
def read(name):
    most = {}
    for line in open(name):
        d = json.loads(line); m = most.setdefault(d["muscle"], {"edge": 0, "way": 0, "end": 0, "triangle": 9, "contacts": 0})
        m["edge"] = max(m["edge"], d["largest_edge_ratio"]); m["way"] = max(m["way"], d["penetration"]); m["end"] = d["penetration"]
        m["triangle"] = min(m["triangle"], d["smallest_triangle"]); m["contacts"] += d["contacts"]
    return most
on, converged = read("on.jsonl"), read("converged.jsonl")
assert len(on) == 12 and sum(m["contacts"] for m in on.values()) > 1000, on
for name, m in on.items():
    assert m["way"] <= 5e-4 and m["end"] <= 1e-4 and m["triangle"] >= 0.05, (name, m)
    assert abs(m["edge"] - 1 - (converged[name]["edge"] - 1)) <= 0.1 * (converged[name]["edge"] - 1) + 0.01, (name, m, converged[name])
END
}

@test "soleus, tibialis anterior and peroneus longus of a leg over an ankle that turns: none enters a bone, no triangle collapses, and they come to rest as in the converged solve" {
    [ -d "$DATA/leg-vhf" ] || skip "no leg-vhf in DATA"
    [ "$CONFIG" != sanitize ] || skip "too slow under the sanitizers"
    "$BATS_TEST_DIRNAME/../../share/examples/leg/ankle.sh" "$BIN" "$DATA/leg-vhf/meshes" leg 2> err
    cd leg
    mkdir on converged
    "$BIN/simulate" -q ankle.scene.json --contact --grid-cache cache --frames 0:60 -o on --log on.jsonl --state 60.state
    "$BIN/simulate" -q ankle.scene.json --contact --grid-cache cache --from 60.state --frames 61:72 -o on --log end.jsonl
    "$BIN/simulate" -q ankle.scene.json --contact --grid-cache cache --from 60.state --frames 61:72 --iterations 400 --tolerance 1e-9 -o converged \
        --log converged.jsonl
    /usr/bin/python3 << 'END'
import json
def read(*names): return [json.loads(line) for name in names for line in open(name)]
way = read("on.jsonl", "end.jsonl")
end, converged = ({d["muscle"]: d for d in read(name) if d["frame"] == 72} for name in ("end.jsonl", "converged.jsonl"))
assert len(way) == 3 * 73 and len(end) == len(converged) == 3
for name, last in end.items():
    mine = [d for d in way if d["muscle"] == name]
    assert sum(d["contacts"] for d in mine) > 50 and max(d["largest_edge_ratio"] for d in mine) > 1.4, name
    for d in mine:
        assert d["nan"] == 0 and not d["torn"] and d["penetration"] <= 5e-4 and d["smallest_triangle"] >= 0.05, d
    strain = converged[name]["largest_edge_ratio"] - 1
    assert last["penetration"] <= 1e-4 and abs(last["largest_edge_ratio"] - 1 - strain) <= 0.1 * strain, (last, converged[name])
END
}
