# The documents at the command line: what the tools write is what the schemas say, what they do not own goes through, what is stale goes.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

schemas="$BATS_TEST_DIRNAME/../../share/schema"

# Does each document keep to the schema? By a real validator, which also checks the schema itself.
valid() {
    /usr/bin/python3 - "$schemas/$1.schema.json" "${@:2}" << 'END'
import json, sys
import jsonschema
schema = json.load(open(sys.argv[1]))
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)
bad = 0
for name in sys.argv[2:]:
    for error in validator.iter_errors(json.load(open(name))):
        print(f"{name}: {list(error.absolute_path)}: {error.message[:200]}")
        bad = 1
sys.exit(bad)
END
}

# member FILE EXPRESSION: a value of the document d
member() { /usr/bin/python3 -c "import json, sys; d = json.load(open(sys.argv[1])); print(json.dumps($2))" "$1"; }

# A spindle of 20 cm along z, as OFF.
spindle() {
    awk 'BEGIN {
        rings = 20; around = 16; pi = atan2(0, -1)
        print "OFF"; print rings * around + 2, 2 * rings * around, 0
        for (i = 1; i <= rings; i++) for (j = 0; j < around; j++) {
            u = pi * i / (rings + 1); w = 2 * pi * j / around
            printf "%.9f %.9f %.9f\n", .02 * sin(u) * cos(w), .02 * sin(u) * sin(w), -.1 * cos(u)
        }
        bottom = rings * around; print "0 0 -.1"; print "0 0 .1"
        for (j = 0; j < around; j++) {
            k = (j + 1) % around
            print 3, bottom, k, j
            print 3, bottom + 1, (rings - 1) * around + j, (rings - 1) * around + k
            for (i = 0; i + 1 < rings; i++) {
                print 3, i * around + j, i * around + k, (i + 1) * around + j
                print 3, i * around + k, (i + 1) * around + k, (i + 1) * around + j
            }
        }
    }'
}

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    spindle > spindle.off
    printf 'OFF\n8 12 0\n' > bone.off
    for z in -.14 -.095; do for y in -.02 .02; do for x in -.02 .02; do echo $x $y $z; done; done; done >> bone.off
    printf '3 %s\n' '0 2 3' '0 3 1' '4 5 7' '4 7 6' '0 1 5' '0 5 4' '2 6 7' '2 7 3' '0 4 6' '0 6 2' '1 3 7' '1 7 5' >> bone.off
}

chain() {
    "$BIN/mesh-clean" spindle.off -o 1.json
    "$BIN/attach-detect" --bone lower=bone.off 1.json -o 2.json
    "$BIN/root-select" 2.json -o 3.json
    "$BIN/build-structure" 3.json -o 4.json
    "$BIN/fiber-flow" 4.json -o 5.json
}

@test "every document of the chain keeps to the schema, and its history tells who made it" {
    /usr/bin/python3 -c 'import jsonschema' 2> /dev/null || skip "python3-jsonschema is not installed"
    chain
    valid muscle 1.json 2.json 3.json 4.json 5.json
    [ "$(member 5.json '[h["tool"] for h in d["history"]]')" = \
        '["mesh-clean", "attach-detect", "root-select", "build-structure", "fiber-flow"]' ]
    [ "$(member 5.json '[list(d), d["attachments"][0]["bone"], len(d["attachments"][0]["vertices"]) > 0]')" = \
        '[["format", "version", "name", "metersPerUnit", "mesh", "roots", "structure", "fibers", "attachments", "history"], "lower", true]' ]
}

@test "the validator finds what is wrong" {
    /usr/bin/python3 -c 'import jsonschema' 2> /dev/null || skip "python3-jsonschema is not installed"
    "$BIN/mesh-clean" spindle.off -o 1.json
    sed 's/"metersPerUnit": 1/"metersPerUnit": 0/' 1.json > bad.json
    refute valid muscle bad.json
    sed 's/"triangles": \[/"triangles": [-1,/' 1.json > bad.json
    refute valid muscle bad.json
}

@test "members that sinew does not know go through every tool, equal and in order" {
    chain
    sed '$d' 1.json > start.json
    printf '  ,"zeta": {"a": [1, 2.50, {"b": null}], "t": "\\u00fa\\n"},\n  "omega": [], "alpha": 1e-7}\n' >> start.json
    cp start.json in.json
    for tool in mesh-clean "attach-detect --bone lower=bone.off" root-select build-structure fiber-flow "fiber-fill -n 4"; do
        "$BIN"/$tool in.json -o out.json
        [ "$(member out.json '[d["zeta"], d["omega"], d["alpha"]]')" = "$(member start.json '[d["zeta"], d["omega"], d["alpha"]]')" ]
        [ "$(member out.json '[k for k in d if k in ("zeta", "omega", "alpha", "history")]')" = '["zeta", "omega", "alpha", "history"]' ]
        mv out.json in.json
    done
}

@test "a member inside a section that a tool does not own goes through too" {
    chain
    sed 's/"rule": /"note": "mine", "rule": /' 3.json > noted.json
    "$BIN/build-structure" noted.json -o out.json
    [ "$(member out.json 'd["roots"]["note"]')" = '"mine"' ]
}

@test "what a change makes stale is dropped with a warning, and -q keeps quiet" {
    chain
    "$BIN/root-select" --plane 0,0,.02,0,0,1 5.json -o out.json 2> err
    grep -q 'warning: .*"structure" is dropped' err
    grep -q 'warning: .*"fibers" is dropped' err
    [ "$(member out.json '[k in d for k in ("roots", "structure", "fibers", "attachments")]')" = '[true, false, false, true]' ]
    "$BIN/root-select" -q 5.json -o out.json 2> err
    [ ! -s err ]
}

@test "--no-history leaves it out" {
    chain
    "$BIN/root-select" --no-history 1.json -o out.json
    [ "$(member out.json '"history" in d')" = false ]
}

@test "a newer document, another document and a torn one are refused in one line that tells the place" {
    "$BIN/mesh-clean" spindle.off -o 1.json
    refused() {
        code=0
        "$BIN/root-select" bad.json -o out.json > out 2> err || code=$?
        [ "$code" -eq 1 ] || return 1
        [ "$(wc -l < err)" -eq 1 ] || return 1
        [ ! -e out.json ] || return 1
        grep -Eq "^root-select: bad.json:$1" err || { cat err; return 1; }
    }
    sed 's/"version": 1/"version": 2/' 1.json > bad.json
    refused '3:.*version 2.*newer sinew'
    sed 's/sinew-muscle/sinew-scene/' 1.json > bad.json
    refused '2:.*expected "sinew-muscle", found "sinew-scene"'
    sed '7,$d' 1.json > bad.json
    refused '6:.*not valid JSON'
    sed 's/"triangles": \[[0-9]*,/"triangles": [322,/' 1.json > bad.json
    refused '8:.*mesh.triangles\[0\]: expected a whole number in \[0,321\], found 322'
}

@test "a mesh by reference is read beside its document, checked and kept" {
    mkdir -p folder
    cp spindle.off folder/spindle.off
    hash=$(sha256sum spindle.off | cut -d ' ' -f 1)
    printf '{"format": "sinew-muscle", "version": 1, "metersPerUnit": 1, "mesh": {"uri": "spindle.off", "sha256": "%s"}}' "$hash" > folder/a.json
    "$BIN/root-select" folder/a.json -o folder/b.json
    [ "$(member folder/b.json 'd["mesh"]')" = "{\"uri\": \"spindle.off\", \"sha256\": \"$hash\"}" ]
    "$BIN/root-select" spindle.off -o c.json
    [ "$(member folder/b.json 'd["roots"]')" = "$(member c.json 'd["roots"]')" ]
    echo >> folder/spindle.off
    run -1 "$BIN/root-select" folder/a.json
    [[ "$output" == *"mesh.sha256"* ]]
    rm folder/spindle.off
    run -1 "$BIN/root-select" folder/a.json
    [[ "$output" == *"folder/spindle.off"* ]]
}

@test "the plan of a scene keeps to the schema, and is the same scene" {
    [ -x "$BIN/simulate" ] || skip "there is no simulate"
    /usr/bin/python3 -c 'import jsonschema' 2> /dev/null || skip "python3-jsonschema is not installed"
    chain
    cat > a.scene.json << 'END'
{"format": "sinew-scene", "version": 1, "metersPerUnit": 0.001, "frames": [0, 10],
 "motion": {"joints": [{"name": "elbow", "type": "hinge", "axis": [1, 2, 3], "point": [0.1, 20.3, -100.7], "degreesPerFrame": 1.5},
  {"name": "free", "parent": "elbow", "type": "pose", "keys": [{"frame": 3, "rotation": [0.1, 0.7, 0.1, 0.7]}]}]},
 "bones": [{"name": "lower", "mesh": "bone.off", "units": "m", "joint": "elbow"}],
 "muscles": [{"rig": "5.json", "activation": {"keys": [[0, 0], [0.3, 1]]}, "volumeRatio": 1.1}]}
END
    valid scene a.scene.json
    "$BIN/simulate" --plan a.scene.json > plan.json
    member plan.json 'd["scene"]' > b.scene.json
    valid scene b.scene.json
    "$BIN/simulate" --plan b.scene.json > again.json
    for plan in plan again; do grep -iv milliseconds $plan.json > $plan.unmeasured; done
    cmp plan.unmeasured again.unmeasured
}

# One table of names in the library stands behind documents and options; the schema is written by hand.
@test "the schema names the choices that the tools name, in their order" {
    [ -x "$BIN/simulate" ] || skip "there is no simulate"
    for option in law stretch anisotropy scheme hinges solver precision preconditioner; do
        run -2 "$BIN/simulate" "--$option" what-nobody-names
        names=${output#*not one of } names=${names%%;*}
        member=$option; [ "$option" = solver ] && member=method
        grep -qF "\"$member\": { \"enum\": [\"${names//, /\", \"}\"]" "$schemas/scene.schema.json" || {
            echo "$member: the tools know $names"
            false
        }
    done
}

# mistyped TOOL-COMMAND...: FILE has a mistyped member: it is warned of, with what was meant, and under --strict an error with name and place.
mistyped() { # MEMBER MEANT FILE COMMAND...
    local member=$1 meant=$2 file=$3
    shift 3
    "$@" > out 2> err || { cat err; false; }
    grep -q "warning: $file:[0-9]*: .*$member (did you mean $meant?)" err || { echo "$*"; cat err; false; }
    code=0
    "$@" --strict > out 2> err || code=$?
    [ "$code" -eq 1 ]
    [ ! -s out ]
    [ "$(wc -l < err)" -eq 1 ]
    grep -q ": $file:[0-9]*:[0-9]*: .*$member: sinew knows no such member: did you mean \"$meant\"?" err || { echo "$* --strict"; cat err; false; }
    sed -i "s/\"$member\"/\"x-$member\"/" "$file"
    "$@" --strict > out 2> err || { cat err; false; }
    refute grep -q "$member" err
}

@test "a mistyped member of any kind of document is named as it was meant; --strict refuses it" {
    tetra='"mesh": {"vertices": [0,0,0, 0.1,0,0, 0,0.1,0, 0,0,0.1], "triangles": [0,2,1, 0,1,3, 1,2,3, 2,0,3]}'
    echo '{"format": "sinew-muscle", "version": 1, "metersPerUnit": 1, '"$tetra"', "root": {"vertices": [0]}}' > a.muscle.json
    mistyped root roots a.muscle.json "$BIN/mesh-clean" a.muscle.json
    echo '{"format": "sinew-muscle", "version": 1, "metersPerUnit": 1, '"$tetra"', "attachments": [{"bone": "b", "vertices": [0], "distance": [0]}]}' > a.muscle.json
    mistyped distance distances a.muscle.json "$BIN/mesh-clean" a.muscle.json
    echo '{"format": "sinew-muscle", "version": 1, "metersPerUnit": 1, '"$tetra"', "host": {"vertices": [0]}}' > a.muscle.json
    "$BIN/mesh-clean" a.muscle.json > out 2> err # of another program: passed on without a word
    refute grep -q host err
    run -1 "$BIN/mesh-clean" --strict a.muscle.json
    [[ "$output" == *"a.muscle.json:1:"*"host: sinew knows no such member;"* ]]
    echo '{"format": "sinew-muscle", "version": 1, "metersPerUnit": 1, '"$tetra"'}' > a.muscle.json

    echo '{"format": "sinew-motion", "version": 1, "Rate": 24, "joints": [{"name": "elbow", "type": "hinge", "axis": [1,0,0], "point": [0,0,0], "keys": [[0,0],[1,90]]}]}' > a.motion.json
    mistyped Rate rate a.motion.json "$BIN/motion-import" a.motion.json
    sed -i 's/"axis"/"ends": [0,0,1], "axis"/' a.motion.json
    mistyped ends end a.motion.json "$BIN/motion-import" a.motion.json
    echo '{"format": "sinew-motion", "version": 1, "joints": [{"name": "elbow", "type": "pose", "keys": [{"time": 0, "rotations": [1,0,0,0]}]}]}' > a.motion.json
    mistyped rotations rotation a.motion.json "$BIN/motion-import" a.motion.json

    echo '{"format": "sinew-activation", "version": 1, "nam": "x", "channels": {"a": {"times": [0,1], "values": [0,1], "interpolation": "smooth"}}}' > a.activation.json
    echo '{"format": "sinew-scene", "version": 1, "muscles": [{"name": "a", "rig": "a.muscle.json", "activation": {"uri": "a.activation.json"}}]}' > a.scene.json
    mistyped nam name a.activation.json "$BIN/simulate" --plan a.scene.json
    sed -i 's/"interpolation"/"interpolaton"/' a.activation.json
    mistyped interpolaton interpolation a.activation.json "$BIN/simulate" --plan a.scene.json

    scene() { echo '{"format": "sinew-scene", "version": 1, '"$1"'"muscles": [{"name": "a", "rig": "a.muscle.json"'"$2"'}]}' > a.scene.json; }
    while IFS='|' read -r of_scene of_muscle member meant; do
        scene "$of_scene" "$of_muscle"
        mistyped "$member" "$meant" a.scene.json "$BIN/simulate" --plan a.scene.json
    done << 'END'
"frame": [0, 3], ||frame|frames
"solver": {"methods": "qn"}, ||methods|method
"contact": {"enabled": false, "samplez": 1}, ||samplez|samples
"externals": {"enabled": false, "stifness": 1}, ||stifness|stiffness
"motion": {"joint": []}, ||joint|joints
|, "contration": 0.4|contration|contraction
|, "stiffness": {"relax": 1}|relax|relaxed
|, "maps": {"activations": "x"}|activations|activation
|, "activation": {"keys": [{"time": 0, "activation": 1, "Frame": 3}]}|Frame|frame
END

    cat > a.sensors.json << 'END'
{"format": "sinew-sensors", "version": 1, "sensors": [
  {"name": "bent", "type": "angle", "joint": "elbow", "axis": "x", "curve": [[0, 0], [90, 1]], "filtr": 0}]}
END
    echo '{"format": "sinew-motion", "version": 1, "rate": 24, "joints": [{"name": "elbow", "type": "hinge", "axis": [1,0,0], "point": [0,0,0], "keys": [[0,0],[1,90]]}]}' > a.motion.json
    mistyped filtr filter a.sensors.json "$BIN/motion-sense" a.motion.json --sensors a.sensors.json
    echo '{"format": "sinew-envelope", "version": 1, '"$tetra"', "bones": ["b"], "influences": {"counts": [1,1,1,1], "bones": [0,0,0,0], "weights": [1,1,1,1]}, "reech": 1}' > a.envelope.json
    scene '"motion": {"joints": [{"name": "b", "type": "hinge", "axis": [1,0,0], "point": [0,0,0]}]}, "surfaces": [{"name": "skin", "envelope": "a.envelope.json"}], '
    mistyped reech reach a.envelope.json "$BIN/rig-view" a.scene.json -o a.png
}

@test "so is one of a template, of ends and of landmarks" {
    spindle > s.off
    "$BIN/root-select" -q s.off -o r.json
    "$BIN/build-structure" -q r.json -o s.json
    echo '{"format": "sinew-fiber-template", "version": 1, "curves": [{"points": [0.5,0.5,0, 0.9,0.5,0.5, 0.5,0.5,1], "nam": "x"}], "descripton": ""}' > t.json
    run -1 "$BIN/fiber-fill" --strict -n 4 --template-file t.json s.json
    [[ "$output" == *"t.json:1:"*"descripton: sinew knows no such member;"* ]]
    sed -i 's/"descripton"/"versions"/' t.json
    "$BIN/fiber-fill" -n 4 --template-file t.json s.json > out 2> err
    grep -q "warning: t.json:1: sinew knows no member versions here" err # version is there: it was not meant
    grep -q "warning: t.json:1: curves\[0\]: sinew knows no member nam here" err
    echo '{"format": "sinew-fiber-ends", "version": 1, "origin": [0], "insertion": [320], "origins": [1]}' > e.json
    run -1 "$BIN/fiber-fill" --strict -n 4 --ends e.json s.json
    [[ "$output" == *"e.json:1:"*"origins: sinew knows no such member"* ]]
    echo '{"areas": [{"bone": "b", "landmark": [[0,0,0]]}]}' > l.json
    run -1 "$BIN/attach-detect" --landmarks l.json --pin b=indices:1 s.json
    [[ "$output" == *'areas[0].landmarks: '*'did you mean it by "landmark"?'* ]]
}

@test "the defaults of the scene's schema are those that simulate fills in" {
    echo '{"format": "sinew-muscle", "version": 1, "metersPerUnit": 1, "mesh": {"vertices": [0,0,0, 0.1,0,0, 0,0.1,0, 0,0,0.1], "triangles": [0,2,1, 0,1,3, 1,2,3, 2,0,3]}}' > a.muscle.json
    for method in '{}' '{"method": "xpbd"}' '{"scheme": "kohout"}'; do
        echo '{"format": "sinew-scene", "version": 1, "contact": true, "externals": true, "solver": '"$method"', "muscles": [{"rig": "a.muscle.json"}]}' > a.scene.json
        "$BIN/simulate" --plan a.scene.json > "plan-${#method}.json"
    done
    /usr/bin/python3 - "$schemas/scene.schema.json" plan-*.json << 'END'
import json, sys
schema = json.load(open(sys.argv[1]))
top, muscle = schema["properties"], schema["$defs"]["muscle"]["properties"]
compared = set()

def compare(properties, found, path, given):
    for name, node in properties.items():
        if "default" not in node or name not in found or name in given: continue
        assert found[name] == node["default"], f"{path}.{name}: {found[name]} is not {node['default']}"
        compared.add(f"{path}.{name}")

for plan in sys.argv[2:]:
    scene = json.load(open(plan))["scene"]
    solver = scene["solver"]
    given = {"method", "scheme"} if solver["method"] == "xpbd" else set()
    if solver["scheme"] == "kohout": given |= {"hinges", "collision"}
    compare(top, scene, "", set())
    compare(top["solver"]["properties"], solver, "solver", given)
    compare(top["contact"]["anyOf"][1]["properties"], scene["contact"], "contact", given | ({"collision"}))
    compare(top["externals"]["anyOf"][1]["properties"], scene["externals"], "externals", set())
    compare(muscle, scene["muscles"][0], "muscle", set())
    compare(muscle["stiffness"]["properties"], scene["muscles"][0]["stiffness"], "stiffness", set())
print(len(compared), sorted(compared))
assert len(compared) >= 38, len(compared)
END
}
