# simulate --collision voxel: options, plan, refusals, and the same bytes whatever way a run goes.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

# The sample arm with its finished rigs, made once.
setup_file() {
    sh "$BATS_TEST_DIRNAME/../sample-folder" "$BIN" "$EXAMPLES" "$BATS_FILE_TMPDIR/arm"
}

setup() {
    cp -r "$BATS_FILE_TMPDIR/arm" "$BATS_TEST_TMPDIR/arm"
    cd "$BATS_TEST_TMPDIR/arm" || exit 1
    PATH=$BIN:$PATH
}

# plan OPTION...: "collision, cells of each bone, hits"
plan() {
    simulate arm.scene.json -q --plan "$@" | python3 -c 'import json, sys
plan = json.load(sys.stdin)
contact, voxels = plan["scene"]["contact"], plan["plan"]["contact"].get("voxels", [])
for v in voxels:
    x, y, z = v["size"]
    assert v["cells"] == v["bytesPublished"] == x * y * z and v["bytes"] == v["cells"] // 8 + 1
    assert 0 < v["inside"] < v["cells"] - v["boundary"] and 0 < v["boundary"]
assert plan["plan"]["contact"]["collision"] == contact["collision"]
print(contact["collision"], *sorted(set(v["cells"] for v in voxels)), contact.get("boneHits"))'
}

@test "the scheme kohout means voxels, 64 along each axis, and the others fields" {
    [ "$(plan --contact --scheme kohout)" = "voxel 262144 follow" ]
    [ "$(plan --contact --scheme kohout --collision field)" = "field None" ]
    [ "$(plan --contact)" = "field None" ]
    [ "$(plan --contact --solver xpbd)" = "field None" ]
    [ "$(plan --contact --solver xpbd --collision voxel --voxels 10 --bone-hits stop)" = "voxel 1000 stop" ]
    plan --contact --scheme kohout --voxels total:262144 | awk '{ exit !($2 > 240000 && $(NF - 1) <= 262144 && NF >= 3) }'
}

@test "off is absent, and a scene says what options say" {
    simulate arm.scene.json --scheme kohout --frames 0:3 -q --log off.jsonl
    refute grep -q contact off.jsonl
    simulate arm.scene.json --scheme kohout --contact --voxels 20 --bone-hits ignore --frames 0:8 -q --log options.jsonl
    [ "$(grep -c '"contacts":' options.jsonl)" -gt 0 ]
    python3 -c 'import json
s = json.load(open("arm.scene.json"))
s["contact"] = {"collision": "voxel", "voxels": 20, "boneHits": "ignore"}
s["solver"] = {"method": "xpbd", "scheme": "kohout"}
json.dump(s, open("voxel.scene.json", "w"))'
    simulate voxel.scene.json --frames 0:8 -q --log scene.jsonl
    cmp options.jsonl scene.jsonl
    simulate voxel.scene.json --bone-hits follow --frames 0:8 -q --log follow.jsonl
    run -1 cmp -s options.jsonl follow.jsonl
    simulate voxel.scene.json --plan -q | python3 -c 'import json, sys; json.dump(json.load(sys.stdin)["scene"], open("again.scene.json", "w"))'
    simulate again.scene.json --frames 0:8 -q --log again.jsonl
    cmp options.jsonl again.jsonl
}

@test "threads, stopped and continued: the same bytes" {
    options="--scheme kohout --contact --voxels 24 --frames 0:8 -q"
    simulate arm.scene.json $options --threads 1 -o whole --log whole.jsonl
    simulate arm.scene.json $options --threads 3 -o three --log three.jsonl
    simulate arm.scene.json $options --stop-after 5:7:2 --state middle.state --log /dev/null
    simulate arm.scene.json $options --frames 5:8 --from middle.state --state end.state --log /dev/null
    simulate arm.scene.json $options --state whole.state --log /dev/null
    cmp whole.jsonl three.jsonl
    for muscle in biceps brachialis triceps; do cmp whole/$muscle.pc2 three/$muscle.pc2; done
    cmp end.state whole.state
}

@test "penetration is told, and can fail a run" {
    run -3 simulate arm.scene.json --scheme kohout --contact --bone-hits ignore --frames 0:48 --fail-on 'penetration>1e-5' -q --log log.jsonl
    simulate arm.scene.json --scheme kohout --contact --frames 0:48 --fail-on 'penetration>1e-3' -q --log log.jsonl
}

@test "a bone with a hole has no voxels inside, and that is told" {
    mesh-clean -q --no-manifold --no-outward humerus.ply -o whole.obj
    awk '$1 == "v" || $1 != "f" || n++ > 120' whole.obj > humerus.obj
    sed -i 's/humerus.ply/humerus.obj/' arm.scene.json
    simulate arm.scene.json --scheme kohout --contact --frames 0:0 --log /dev/null 2> said
    grep -q 'bone "humerus" encloses no voxel' said
}

@test "what is wrong or idle is told" {
    run -1 simulate arm.scene.json --contact --collision voxel
    [[ "$output" == *"xpbd"* ]]
    for wrong in 0 513 64x total: total:0 total:134217729 all:8 -3; do
        run -2 simulate arm.scene.json --contact --scheme kohout --voxels=$wrong
        [[ "$output" == *"--voxels $wrong"* ]]
    done
    run -2 simulate arm.scene.json --contact --scheme kohout --collision boxes
    run -2 simulate arm.scene.json --contact --scheme kohout --bone-hits bounce
    run -2 simulate arm.scene.json --no-contact --bone-hits stop
    for idle in "--voxels 8" "--bone-hits stop"; do
        run -0 simulate arm.scene.json --contact --frames 0:0 --log /dev/null $idle
        [[ "$output" == *"has no effect: the collision is by distance fields"* ]]
        run -0 simulate arm.scene.json --frames 0:0 --log /dev/null $idle
        [[ "$output" == *"has no effect: contact is off"* ]]
    done
    for idle in "--margin 1mm" "--friction 0.5" "--resolve 1" "--contact-samples 1"; do
        run -0 simulate arm.scene.json --contact --scheme kohout --frames 0:0 --log /dev/null $idle
        [[ "$output" == *"has no effect: the collision is by voxels"* ]]
    done
    run -0 simulate arm.scene.json --contact --scheme romeo --frames 0:0 --log /dev/null
    [[ "$output" == *"romeo has no contact"* ]]
    for wrong in '{"voxels": 0}' '{"voxels": 8, "voxelsTotal": 8}' '{"boneHits": "bounce"}' '{"collision": 3}' '{"voxelsTotal": 1e10}'; do
        python3 -c 'import json, sys
s = json.load(open("arm.scene.json")); s["contact"] = json.loads(sys.argv[1]); json.dump(s, open("wrong.scene.json", "w"))' "$wrong"
        run -1 simulate wrong.scene.json --scheme kohout --frames 0:0
        [[ "$output" == *"contact"* ]]
    done
}
