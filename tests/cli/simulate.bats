# simulate: frames and log, overrides, stops, limits, refusals; then two real muscles.

bats_require_minimum_version 1.5.0

# a && b and ! a do not end a test under bats: state every condition by itself, and what must not hold with `refute`
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

# one enabled muscle: a cache needs no folder
one_muscle() { python3 -c 'import json,sys; s=json.load(open("arm.scene.json")); s["muscles"]=s["muscles"][:1]; s["muscles"][0]["law"]="isochoric"; json.dump(s,open("one.scene.json","w"))'; }
values() { python3 -c 'import json,sys
for line in open(sys.argv[1]): print(json.loads(line)[sys.argv[2]])' "$1" "$2"; }

@test "one log line per frame and muscle, finite, with the volume at its goal" {
    simulate arm.scene.json --frames 0:4 > log.jsonl
    [ "$(wc -l < log.jsonl)" -eq 15 ]
    python3 - log.jsonl <<'END'
import json, sys
lines = [json.loads(line) for line in open(sys.argv[1])]
assert [l["frame"] for l in lines] == [f for f in range(5) for _ in range(3)]
assert [l["muscle"] for l in lines[:3]] == ["biceps", "brachialis", "triceps"]
for l in lines:
    assert abs(l["time"] - l["frame"] / 24) < 1e-12
    assert abs(l["volume_error"]) < 0.01 and l["nan"] == 0 and l["smallest_triangle"] > 0.2
    assert set(l["errors"]) == {"internal", "radial", "mesh", "dihedral", "area"}
END
}

@test "a cache holds a sample per frame, and the first is the rest pose in the document's unit" {
    one_muscle
    simulate one.scene.json --frames 0:4 -o biceps.pc2 --log log.jsonl
    python3 - <<'END'
import json, struct
rest = json.load(open("biceps.muscle.json"))["mesh"]["vertices"]
data = open("biceps.pc2", "rb").read()
signature, version, points, start, rate, samples = struct.unpack("<12siiffi", data[:32])
assert signature == b"POINTCACHE2\0" and version == 1 and samples == 5 and start == 0 and rate == 1
assert 3 * points == len(rest) and len(data) == 32 + 12 * points * samples
first = struct.unpack("<%df" % len(rest), data[32:32 + 4 * len(rest)])
assert first == struct.unpack("<%df" % len(rest), struct.pack("<%df" % len(rest), *rest))
END
}

@test "a folder gets a cache per muscle; ply a file per frame and muscle, with the same positions" {
    simulate arm.scene.json --frames 0:2 -o caches --log log.jsonl
    simulate arm.scene.json --frames 0:2 -o meshes --format ply --log log2.jsonl
    cmp log.jsonl log2.jsonl
    [ "$(ls caches | tr '\n' ' ')" = "biceps.pc2 brachialis.pc2 triceps.pc2 " ]
    [ "$(ls meshes | wc -l)" -eq 9 ]
    [ -s meshes/triceps.0002.ply ]
    mesh-clean meshes/biceps.0002.ply -o again.ply
}

@test "the same bytes on 1 and 2 threads, with a trace, from a pipe" {
    simulate arm.scene.json --frames 0:3 --threads 1 -o a --log a.jsonl
    simulate arm.scene.json --frames 0:3 --threads 2 -o b --log b.jsonl --trace steps.jsonl
    simulate --frames 0:3 -o c < arm.scene.json > c.jsonl
    for other in b c; do
        cmp a.jsonl $other.jsonl
        for muscle in biceps brachialis triceps; do cmp a/$muscle.pc2 $other/$muscle.pc2; done
    done
    [ "$(grep -c '"stage":"iteration"' steps.jsonl)" -eq "$(wc -l < steps.jsonl)" ]
    each=$(simulate --plan arm.scene.json | python3 -c 'import json,sys; s=json.load(sys.stdin)["scene"]["solver"]; print(s["iterations"] * (1 if s["substeps"] == "auto" else s["substeps"]))')
    [ "$(wc -l < steps.jsonl)" -eq $((3 * 3 * each)) ]
}

@test "the overrides do what they say" {
    one_muscle
    simulate one.scene.json --frames 10:12 > range.jsonl
    [ "$(values range.jsonl frame | tr '\n' ' ')" = "10 11 12 " ]
    simulate one.scene.json --frames 0:2 --rate 48 > rate.jsonl
    [ "$(values rate.jsonl time | tail -n 1)" = "0.041666666666666664" ]
    simulate one.scene.json --frames 36:37 > cold.jsonl
    simulate one.scene.json --frames 36:37 --preroll 1 > warm.jsonl
    python3 - <<'END'
import json
cold, warm = (json.loads(open(name).readline()) for name in ("cold.jsonl", "warm.jsonl"))
assert warm["errors"]["mesh"]["rms"] < 0.5 * cold["errors"]["mesh"]["rms"]
END
    for option in "--law projected" "--law paper" "--substeps 7" "--iterations 3" "--solver xpbd" "--stretch membrane" "--preconditioner corotated" "--scheme romeo" "--scheme kohout" "--scheme kohout --hinges printed" "--anisotropy pbd" "--anisotropy xpbd"; do
        simulate one.scene.json --frames 36:38 $option > other.jsonl
        simulate one.scene.json --frames 36:38 > plain.jsonl
        refute cmp -s other.jsonl plain.jsonl
    done
}

@test "--plan is a scene with every default and what runs; it runs nothing, and simulates alike" {
    simulate --plan arm.scene.json > plan.json
    python3 - <<'END'
import json
document = json.load(open("plan.json"))
plan = document["plan"]
assert [m["name"] for m in plan["muscles"]] == ["biceps", "brachialis", "triceps"]
for m in plan["muscles"]:
    rows = {g["kind"]: g["rows"] for g in m["groups"]}
    assert rows["internal"] == m["samples"] - 1 and rows["volume"] == 1 and rows["mesh"] > m["vertices"]
json.dump(document["scene"], open("full.scene.json", "w"))
END
    simulate full.scene.json --frames 0:2 > full.jsonl
    simulate arm.scene.json --frames 0:2 > plain.jsonl
    cmp full.jsonl plain.jsonl
    python3 -c 'import json; s=json.load(open("full.scene.json")); m=s["muscles"]; m[0]["stiffness"]["internal"]=0; m[1]["enabled"]=False; m[2]["stiffness"]["dihedral"]=0; json.dump(s,open("less.scene.json","w"))'
    simulate --plan less.scene.json > less.json
    [ "$(grep -c leftOut less.json)" -eq 10 ] # no membrane, no external constraints, no contact
}

@test "--stop-after ends at a frame, a substep, an iteration, with what there is" {
    one_muscle
    for stop in 2 2:3 2:3:1; do
        simulate one.scene.json --solver xpbd --iterations 2 --stop-after $stop -o stop-$stop.pc2 > log.jsonl
        [ "$(wc -l < log.jsonl)" -eq 3 ]
        [ "$(($(wc -c < stop-$stop.pc2) - 32))" -eq $((3 * 12 * $(simulate --plan one.scene.json | grep -o '"vertices": *[0-9]*' | grep -o '[0-9]*$'))) ]
    done
    grep -q '"substep":3,"iteration":1' log.jsonl
    refute cmp -s stop-2.pc2 stop-2:3.pc2
    refute cmp -s stop-2:3.pc2 stop-2:3:1.pc2
    simulate one.scene.json --solver xpbd --iterations 2 --frames 0:2 -o whole.pc2 > log.jsonl
    cmp whole.pc2 stop-2.pc2
    for bad in x 1:0 0:1 1:9999 1:2:3:4 -1; do
        run -2 simulate one.scene.json --stop-after $bad
    done
}

@test "a run that stops, in a frame or between two, goes on to the same bytes; damage and other scenes are told" {
    one_muscle
    for solver in xpbd qn; do
        run="simulate one.scene.json --solver $solver --iterations 3"
        $run --frames 0:4 --state whole.state -o whole.pc2 > whole.jsonl
        tail -n 1 whole.jsonl > wanted
        if [ $solver = xpbd ]; then stops="1 2 2:3 3:16 4:16:1"; else stops="1 2 2:1:1 4:1:2"; fi
        for stop in $stops; do
            $run --stop-after $stop --state stop.state > log.jsonl
            rm -f end.pc2
            $run --frames ${stop%%:*}:4 --from stop.state --state end.state -o end.pc2 > end.jsonl
            cmp end.state whole.state
            tail -n 1 end.jsonl | cmp - wanted
            python3 -c 'a=open("whole.pc2","rb").read(); b=open("end.pc2","rb").read(); n=len(b)-32; assert n>0 and a[-n:]==b[32:]'
        done
    done
    [ "$(wc -l < end.jsonl)" -eq 1 ]
    simulate one.scene.json --iterations 3 --frames 0:3 --save-every 2 --state saved.state --stop-after 3:1 > log.jsonl
    simulate one.scene.json --iterations 3 --frames 3:4 --from saved.state --state end.state > log.jsonl
    cmp end.state whole.state
    run -2 simulate one.scene.json --iterations 3 --frames 0:4 --from whole.state
    run -2 simulate one.scene.json --save-every 2
    head -c 3000 whole.state > short.state
    run -1 simulate one.scene.json --frames 0:9 --from short.state
    [[ "$output" == *short.state*checksum* ]]
    run -1 simulate arm.scene.json --frames 0:9 --from whole.state
    [[ "$output" == *"another scene"* ]]
    run -1 simulate one.scene.json --frames 0:9 --from biceps.ply
    [[ "$output" == *"not a state"* ]]
}

# two frames, and the third stopped in the middle: whole.state, half.state, part.state; all six of them in six.jsonl and six.pc2
make_states() {
    one_muscle
    run="simulate one.scene.json --solver xpbd --substeps 6"
    $run --frames 0:2 --state whole.state > log.jsonl
    $run --frames 0:6 --stop-after 3:4 --state half.state > log.jsonl
    $run --frames 0:6 --stop-after 3:4:1 --state part.state > log.jsonl
    $run --frames 0:6 -o six.pc2 > six.jsonl
}

# refused WORDS ARGUMENT...: wrong usage, in one sentence that has the words; nothing is written
refused() {
    words=$1 code=0
    shift
    rm -f out.pc2
    simulate one.scene.json --solver xpbd --substeps 6 "$@" -o out.pc2 > out.jsonl 2> err || code=$?
    [ "$code" -eq 2 ] || { echo "$*: $code"; cat err; return 1; }
    [ "$(wc -l < err)" -eq 1 ] || { echo "$*"; cat err; return 1; }
    grep -q -e "$words" err || { echo "$*"; cat err; return 1; }
    [ ! -s out.jsonl ]
    [ ! -e out.pc2 ]
}

# goes_on FIRST LAST ARGUMENT...: log and cache hold these frames, with the bytes of the run that did not stop
goes_on() {
    first=$1 last=$2
    shift 2
    simulate one.scene.json --solver xpbd --substeps 6 "$@" -o out.pc2 > out.jsonl
    sed -n "$((first + 1)),$((last + 1))p" six.jsonl | cmp - out.jsonl
    python3 - "$first" "$last" <<'END'
import struct, sys
first, last = int(sys.argv[1]), int(sys.argv[2])
six, out = open("six.pc2", "rb").read(), open("out.pc2", "rb").read()
points, start, rate, samples = struct.unpack("<iffi", out[16:32])
assert (start, samples) == (first, last - first + 1), (start, samples)
assert out[32:] == six[32 + 12 * points * first:32 + 12 * points * (last + 1)]
END
}

@test "--frames with --from: from the state's frame or the one that comes next, or refused with what to write" {
    make_states
    # before, at, next, after; one frame; the end at or before the state
    for range in 2:6 3:6; do goes_on 3 6 --frames $range --from whole.state; done
    for range in 2:3 3:3; do goes_on 3 3 --frames $range --from whole.state; done
    for range in 0:6 1:6 4:6 -3:6 1:3 6:6; do refused "write --frames 3:${range#*:};" --frames $range --from whole.state; done
    for range in 90:90 90:92; do refused "is at frame 2; .*write --frames 3:" --frames $range --from whole.state; done
    for range in 2:2 0:2 0:1 1:1 -5:-5; do refused "the run ends at ${range#*:}; write --frames 3:B" --frames $range --from whole.state; done
    for state in half part; do
        goes_on 3 6 --frames 3:6 --from $state.state
        goes_on 3 3 --frames 3:3 --from $state.state
        for range in 0:6 2:6 4:6 1:3 4:4 90:90 90:92; do
            refused "stopped in the middle of frame 3; .*write --frames 3:${range#*:};" --frames $range --from $state.state
        done
        for range in 2:2 0:2 0:0; do refused "the run ends at ${range#*:}; write --frames 3:B" --frames $range --from $state.state; done
    done
    # the scene's own frames
    for frames in 0,6 2,6 3,6 3,3 4,6 0,2; do
        python3 -c 'import json,sys; s=json.load(open("one.scene.json")); s["frames"]=[int(f) for f in sys.argv[1].split(",")]; json.dump(s,open("one.scene.json","w"))' $frames
        case $frames in
            0,6 | 2,6 | 3,6) goes_on 3 6 --from whole.state && goes_on 3 6 --from half.state ;;
            3,3) goes_on 3 3 --from whole.state && goes_on 3 3 --from part.state ;;
            4,6) refused "before the scene's first, 4; .*write --frames 3:6;" --from whole.state ;;
            0,2) refused "the run ends at 2; write --frames 3:B" --from whole.state ;;
        esac
    done
}

@test "automatic substeps are the solver qn's, in a scene and on the command line" {
    one_muscle
    run -2 simulate one.scene.json --solver xpbd --substeps auto
    [[ "$output" == *"--substeps auto is for the solver qn"* ]]
    python3 -c 'import json; s=json.load(open("one.scene.json")); s["solver"]={"method": "xpbd", "substeps": "auto"}; json.dump(s,open("auto.scene.json","w"))'
    run -1 simulate auto.scene.json
    [[ "$output" == *"solver.substeps auto is for the method qn"* ]]
    simulate -q one.scene.json --frames 0:2 --substeps auto > auto.jsonl
    simulate -q one.scene.json --frames 0:2 > default.jsonl
    cmp auto.jsonl default.jsonl
}

@test "frames beyond all bounds are wrong usage, or a scene that is wrong" {
    make_states
    for range in -2147483647:2147483647 0:2147483647 -2147483647:0 0:100000001 -100000001:0; do
        refused 'frames go from -100000000 to 100000000' --frames $range
        refused 'frames go from -100000000 to 100000000' --frames $range --from whole.state
    done
    refused 'A:B' --frames 0:2147483648
    # as long as it may be: memory grows with the frames that are done, not with those that are asked for
    goes_on 0 6 --frames 0:100000000 --stop-after 6
    (ulimit -v 2000000 && simulate one.scene.json --frames -1:100000000 --stop-after 0 -o long.pc2 > long.jsonl) || [ "$CONFIG" = sanitize ]
    python3 -c 'import json; s=json.load(open("one.scene.json")); s["frames"]=[-2147483647, 2147483647]; json.dump(s,open("one.scene.json","w"))'
    run -1 simulate one.scene.json
    [[ "$output" == *"whole frame numbers"* ]]
}

@test "going on with lengths, a folder, states on the way, and stopping again" {
    make_states
    fiber-fill -q biceps.muscle.json -o filled.muscle.json
    sed -i 's/biceps.muscle.json/filled.muscle.json/' one.scene.json
    run="simulate -q one.scene.json --solver xpbd --substeps 6"
    for lengths in tsv sto; do
        $run --frames 0:6 --lengths all.$lengths -o all --fibers > all.jsonl
        for state in whole half part; do
            rm -rf out
            $run --frames 3:6 --from $state.state --lengths out.$lengths -o out --fibers --save-every 2 --state again.state --stop-after 5:2 > out.jsonl
            [ "$(wc -l < out.jsonl)" -eq 3 ]
            [ "$(grep -c '^[0-9]' out.$lengths)" -eq 3 ]
            if [ $lengths = sto ]; then grep -q '^nRows=3$' out.sto; fi
            python3 -c 'import struct, glob
for path in ("out/biceps.pc2", "out/biceps-fibers.pc2"): assert struct.unpack("<ffi", open(path, "rb").read()[20:32]) == (3, 1, 3), path
assert len(glob.glob("out/biceps-fibers.*.vtp")) == 3'
            $run --frames 5:6 --from again.state --lengths rest.$lengths -o out --fibers > rest.jsonl
            tail -n 2 all.jsonl | cmp - rest.jsonl
            [ "$(tail -n 2 rest.$lengths)" = "$(tail -n 2 all.$lengths)" ]
            [ "$(grep '^[0-9]' out.$lengths | head -n 2)" = "$(grep '^[0-9]' all.$lengths | sed -n 4,5p)" ]
        done
    done
    # what cannot be: a stop before the state, or beyond what is left
    refused 'the run starts at frame 3' --frames 3:6 --from whole.state --stop-after 2
    run -2 $run --frames 3:6 --from half.state --stop-after 3:2
    [[ "$output" == *"beyond it already"* ]]
}

# forge IN OUT OFFSET,FORMAT,VALUE...: a state with other numbers and a right checksum
forge() {
    python3 - "$@" <<'END'
import hashlib, struct, sys
state = bytearray(open(sys.argv[1], "rb").read())
for change in sys.argv[3:]:
    offset, kind, value = change.split(",")
    struct.pack_into("<" + kind, state, int(offset), float(value) if kind == "d" else int(value))
state[16:88] = b"sha256:" + hashlib.sha256(state[88:]).hexdigest().encode() + b"\0"
open(sys.argv[2], "wb").write(state)
END
}

@test "a forged state with a right checksum is refused by simulate and rig-view, or drawn and gone on from" {
    one_muscle
    python3 -c 'import json; s=json.load(open("one.scene.json")); s["frames"]=[0, 4]; s["solver"]={"method": "qn", "substeps": 1}; json.dump(s,open("one.scene.json","w"))'
    simulate one.scene.json --stop-after 2 --state good.state > log.jsonl
    forge good.state same.state 160,i,2
    cmp good.state same.state # the offsets are those of restart.c
    told() { # WORD CHANGE...
        word=$1
        shift
        forge good.state forged.state "$@"
        for tool in "simulate one.scene.json --from" "rig-view one.scene.json -o forged.png --state"; do
            run -1 $tool forged.state
            [ "$(echo "$output" | wc -l)" -eq 1 ]
            [[ "$output" == *"forged.state: this state "*"$word"* ]] || { echo "$output"; return 1; }
        done
    }
    for frame in 2147483647 -2147483648 100000001; do told "frame $frame" 160,i,$frame; done
    for substep in -1 1 2147483647; do told substep 164,i,$substep; done
    for iteration in -1 110 2147483647; do told iteration 168,i,$iteration; done
    for muscles in 0 2 -1; do told muscles 172,i,$muscles; done
    for parts in -1 9 3; do told progress 176,i,$parts; done
    for size in -1 3 128; do told progress 180,i,$size; done
    told progress 184,i,10
    told still 192,i,-1
    told statistics.skipped_edges 196,q,9223372036854775807
    told statistics.residual 300,d,-1
    told activation 308,d,7
    told stiffness 324,d,-1
    told bones 340,d,inf
    told bones 412,d,-1
    told resolve_begin 420,d,inf
    told parted 428,d,2
    told stretch_before 444,d,nan
    told abrupt 452,B,7
    for count in -1 9 2147483647; do told pair_count 453,i,$count; done
    told pair_next 453,i,8 457,i,-2147483648
    told stopped 461,i,77
    told turned 465,B,2
    told torn 466,B,200
    told points 467,d,nan
    told points 491,d,12345
    told factor_stiffness -16,d,inf
    refute [ -e forged.png ]
    for far in 1e3 1e38 1e160 1e300; do # a place that no muscle comes to, and still a place
        forge good.state forged.state "$(((467 + 32 * 200))),d,$far"
        for tool in "simulate -q one.scene.json --from" "rig-view -q one.scene.json -o forged.png --state"; do
            code=0
            $tool forged.state > out 2> err || code=$?
            case $code in
            0 | 1) [ "$(wc -l < err)" -eq "$code" ] ;;
            3) grep -q exploded err ;; # it goes on from there, and says so
            *) false ;;
            esac
        done
    done
}

@test "maps, curves, forms and schemes come back from --plan, are checked, and change the result" {
    one_muscle
    python3 - <<'END'
import json
rig = json.load(open("biceps.muscle.json"))
count = len(rig["mesh"]["vertices"]) // 3
height = rig["mesh"]["vertices"][2::3]
middle = sum(height) / count
rig["mesh"]["attributes"] = {"share": {"values": [0 if z > middle else 1 for z in height]}, "firm": {"values": [2] * count}}
json.dump(rig, open("painted.muscle.json", "w"))
scene = json.load(open("one.scene.json"))
m = scene["muscles"][0]
m.update(rig="painted.muscle.json", activation=1.0)
json.dump(scene, open("plain.scene.json", "w"))
m.update(maps={"activation": "share", "stiffness": "firm"}, anisotropy="xpbd", leastArea=0.3, mass="unit", name="biceps")
m["stiffness"] = {"areaScaled": False, "curve": [[0, 1e5], [0.5, 1e6], [1, 1e7]]}
json.dump(scene, open("painted.scene.json", "w"))
m["maps"]["activation"] = "shares"
json.dump(scene, open("wrong.scene.json", "w"))
END
    simulate --plan painted.scene.json | python3 -c 'import json,sys
scene = json.load(sys.stdin)["scene"]; m = scene["muscles"][0]
assert m["maps"] == {"activation": "share", "stiffness": "firm"} and m["stiffness"]["curve"][1] == [0.5, 1e6] and m["stiffness"]["areaScaled"] is False
assert m["anisotropy"] == "xpbd" and m["leastArea"] == 0.3 and m["mass"] == "unit" and scene["solver"]["scheme"] == "guarded"
json.dump(scene, open("again.scene.json", "w"))'
    for scene in plain painted again; do simulate $scene.scene.json --frames 0:2 --log $scene.jsonl -o $scene.pc2; done
    cmp painted.pc2 again.pc2
    refute cmp -s plain.pc2 painted.pc2
    run -1 simulate wrong.scene.json
    [[ "$output" == *'no attribute "shares"'* ]]
}

@test "a muscle whose inputs keep still sleeps, unless it may not" {
    one_muscle
    python3 -c 'import json; s=json.load(open("one.scene.json")); s["muscles"][0]["activation"]=0; s.pop("motion"); [b.pop("joint", None) for b in s["bones"]]; json.dump(s,open("still.scene.json","w"))'
    simulate still.scene.json --frames 0:4 > still.jsonl
    [ "$(values still.jsonl asleep | tail -n 1)" = True ]
    simulate still.scene.json --frames 0:4 --no-sleep > awake.jsonl
    [ "$(values awake.jsonl asleep | sort -u)" = False ]
    simulate one.scene.json --frames 20:24 > moving.jsonl
    [ "$(values moving.jsonl asleep | sort -u)" = False ]
}

@test "--fail-on names the first frame that breaks a limit: status 3, and everything is written" {
    one_muscle
    run -3 simulate -q one.scene.json --frames 0:4 -o out.pc2 --log log.jsonl --fail-on 'volume>0.01,mesh>1e-6,nan>0'
    [ "$(echo "$output" | wc -l)" -eq 1 ]
    [[ "$output" == *'frame 1, muscle "biceps": mesh is '* ]]
    [ -s out.pc2 ]
    [ "$(wc -l < log.jsonl)" -eq 5 ]
    run -0 simulate one.scene.json --frames 0:1 --log log.jsonl --fail-on 'volume>0.01,triangle<0.01'
    run -0 simulate one.scene.json --frames 0:1 --log log.jsonl --fail-on 'internal>9,radial>9,area>0.4,energy>9,elastic>1e9,skipped>0,clamped>1e9'
    run -3 simulate -q one.scene.json --frames 0:1 --log log.jsonl --fail-on 'elastic>0,residual>0,energy>0'
    [ "$(echo "$output" | wc -l)" -eq 3 ]
    for bad in 'volume' 'volume>' 'size>1' 'volume>x' 'volume>0.1,,nan>0'; do
        run -2 simulate one.scene.json --frames 0:1 --fail-on "$bad"
    done
}

@test "a muscle without attachments is warned of and rests; a scene without muscles has an empty log" {
    mesh-clean -q biceps.ply -o loose.muscle.json
    printf '{"format":"sinew-scene","version":1,"muscles":[{"rig":"loose.muscle.json"}]}' > loose.scene.json
    simulate loose.scene.json --frames 0:3 -o loose.pc2 > log.jsonl 2> err
    grep -q 'attached to no bone' err
    [ "$(grep -c warning err)" -eq 1 ]
    python3 -c 'import json
for line in open("log.jsonl"): assert abs(json.loads(line)["kinetic_energy"]) < 1e-12'
    printf '{"format":"sinew-scene","version":1}' > none.scene.json
    simulate none.scene.json > log.jsonl 2> err
    [ ! -s log.jsonl ]
    [ "$(wc -l < err)" -eq 1 ] # a warning, and no summary of nothing
}

@test "outputs that make no sense are wrong usage" {
    one_muscle
    run -2 simulate arm.scene.json -o arm.pc2
    run -2 simulate one.scene.json -o frames.mdd
    run -2 simulate one.scene.json -o frames.ply
    run -2 simulate one.scene.json -o -
    run -2 simulate one.scene.json --frames 5:2
    run -2 simulate one.scene.json --frames 5
    run -2 simulate one.scene.json --substeps 0
    run -2 simulate one.scene.json --law none
}

@test "a run that fails writes no cache and leaves the old one alone" {
    one_muscle
    echo old > out.pc2
    sed 's/"scapula"/"shoulder"/g' one.scene.json > lost.scene.json
    run -1 simulate lost.scene.json -o out.pc2 --log log.jsonl
    [[ "$output" == *scapula* ]]
    [ "$(cat out.pc2)" = old ]
    run -1 simulate one.scene.json --frames 0:1 -o missing/folder/out.pc2 --log log.jsonl
    run -1 sh -c "simulate one.scene.json --frames 0:1 > /dev/full"
}

# The sample arm's biceps, its forearm moved by a pose joint: keys "TIME WAY", WAY along -z in metres.
moved() { python3 -c 'import json, sys
s = json.load(open("arm.scene.json")); s["muscles"] = s["muscles"][:1]
keys = [dict(time=float(k.split()[0]), translation=[0, 0, -float(k.split()[1])]) for k in sys.argv[2:]]
s["motion"]["joints"] = [dict(name="elbow", type="pose", keys=keys)]
json.dump(s, open(sys.argv[1], "w"))' "$@"; }
samples() { python3 -c 'import struct, sys; print(struct.unpack("<i", open(sys.argv[1], "rb").read()[28:32])[0])' "$1"; }

@test "a run that exploded ends with status 3 and says who, when and what may help; all of its frames are written" {
    moved jump.scene.json "0.2 0" "0.21 0.3" # a length of the muscle in a hundredth of a second
    for options in "--solver xpbd" "--scheme romeo --substeps 1 --iterations 1" "--scheme kohout --substeps 1 --iterations 1"; do
        run -3 --separate-stderr simulate jump.scene.json --frames 0:12 $options -o out.pc2 --log log.jsonl
        [[ "$stderr" == *'frame 5: muscle "biceps" has exploded, its edge between vertices '*' times its goal length; '*" may help"* ]]
        [ "$(grep -c 'has exploded, its edge' <<< "$stderr")" -eq 1 ] # not in frame 6 again
        [ "$(samples out.pc2)" -eq 13 ]
        [ "$(wc -l < log.jsonl)" -eq 13 ]
    done
    sed 's/"name": "biceps",/& "stiffness": {"relaxed": 30, "active": 30, "volume": 0},/; s/^{/& "gravity": [0, 0, -300],/' jump.scene.json > soft.scene.json
    run -3 --separate-stderr simulate soft.scene.json --frames 0:12 --solver xpbd --log log.jsonl
    [[ "$stderr" == *'has exploded, its volume is '*" times its goal; nothing keeps its volume"* ]]
    simulate jump.scene.json --frames 0:12 > qn.jsonl # the default survives it
    moved far.scene.json "0.2 0" "0.21 20"
    run -3 --separate-stderr simulate -q far.scene.json --frames 0:6
    [[ "$stderr" == *"its bones have gone far apart"* ]]
    simulate far.scene.json --frames 0:4 > log.jsonl # before it
}

@test "a solver that fails on a muscle is told of, status 3" {
    for stiffness in '{"relaxed": 1e303, "active": 1e303}' '{"volume": 1e300}'; do # no energy is finite: the muscle stays where it was
        sed "s/\"contraction\": 0.26,/&\"stiffness\": $stiffness,/" arm.scene.json > stiff.scene.json
        run -3 --separate-stderr simulate stiff.scene.json --frames 0:2 --log log.jsonl --report report.json
        [[ "$stderr" == *'frame 1: the solver has failed on muscle "biceps", '*"a lower stiffness"* ]]
        [ "$(grep -c 'the solver has failed' <<< "$stderr")" -eq 1 ]
        python3 -c 'import json; assert json.load(open("report.json"))["outcome"]["exploded"] == [dict(muscle="biceps", signs=["solver"])]'
    done
}

@test "points that are not finite end the run, and what was done is kept; where nothing was, status 1" {
    moved nan.scene.json "0 0" "0.2 0" "0.21 -1.7e308" "0.5 1.7e308" # between the last two no number is finite
    for options in "--solver qn" "--solver xpbd" "--scheme romeo"; do
        rm -f out.pc2 end.state
        run -3 --separate-stderr simulate nan.scene.json --frames 0:12 $options -o out.pc2 --log log.jsonl --state end.state --report report.json
        [[ "$stderr" == *'frame 5: muscle "biceps" is farther away than the single precision of a point cache can tell'*"the run ends with frame 4, and writes no state"* ]]
        [ "$(samples out.pc2)" -eq 5 ]
        [ "$(values log.jsonl frame | tr '\n' ' ')" = "0 1 2 3 4 5 " ]
        refute [ -e end.state ]
        python3 -c 'import json
r = json.load(open("report.json")); assert r["frames"] == 5 and r["steppedFrames"] == 4 and "points" in r["outcome"]["exploded"][0]["signs"], r["outcome"]'
        simulate nan.scene.json --frames 0:4 $options -o whole.pc2 --log log.jsonl
        head -c $((32 + 5 * 12 * 521)) out.pc2 | tail -c +33 > a
        tail -c +33 whole.pc2 | cmp - a
        run -3 --separate-stderr simulate nan.scene.json --frames 0:12 $options -o far --format ply --log log.jsonl --state end.state
        [[ "$stderr" == *'frame 6: muscle "biceps" has exploded, '*"not finite"*"the run ends with frame 5, and writes no state; "* ]]
        [ "$(ls far | wc -l)" -eq 6 ]
        [ "$(values log.jsonl frame | tr '\n' ' ')" = "0 1 2 3 4 5 6 " ]
    done
    run -3 simulate nan.scene.json --frames 0:12 --save-every 2 --state end.state --log log.jsonl
    [ -e end.state ] # of frame 4
    run -1 simulate nan.scene.json --frames 5:5 --from end.state -o rest.pc2 --log rest.jsonl # its bones are 1e308 m apart
    refute [ -e rest.pc2 ]
    run -1 --separate-stderr simulate nan.scene.json --frames 6:8 -o none.pc2 --log log.jsonl
    [[ "$stderr" == *'frame 6: muscle "biceps" has '*" points that are not finite"* ]]
    refute [ -e none.pc2 ]
}

@test "the summary names the worst, the report holds it, the log says what is torn, and -q none of it" {
    run -0 --separate-stderr simulate arm.scene.json --frames 0:12 --log log.jsonl --report report.json
    [[ "$stderr" == *"13 frames, "*" ms each (median)"*"volume farthest"*"longest edge"*"smallest triangle"*"most iterations"* ]]
    refute grep -q -e warning -e torn <<< "$stderr"
    python3 - <<'END'
import json
lines = [json.loads(line) for line in open("log.jsonl")]
outcome = json.load(open("report.json"))["outcome"]
def worst(name, key):
    w = max(lines, key=key); w = (w["muscle"], w["frame"])
    assert (outcome[name]["muscle"], outcome[name]["frame"]) == w, (name, outcome[name], w)
worst("volumeError", lambda l: abs(l["volume_error"]))
worst("largestEdgeRatio", lambda l: l["largest_edge_ratio"])
worst("smallestTriangle", lambda l: -l["smallest_triangle"])
worst("mostIterations", lambda l: l["iterations"])
assert outcome["torn"] == [] and outcome["exploded"] == [] and not any(l["torn"] for l in lines)
END
    run -0 --separate-stderr simulate -q arm.scene.json --frames 0:12 --log log.jsonl
    [ -z "$stderr" ]
    moved jump.scene.json "0.2 0" "0.21 0.3" "0.29 0.3" "0.3 0"
    run -0 --separate-stderr simulate jump.scene.json --frames 0:12 --log log.jsonl --report report.json
    python3 - "$stderr" <<'END'
import json, sys
torn = [l["frame"] for l in map(json.loads, open("log.jsonl")) if l["torn"]]
assert 5 in torn and 4 not in torn, torn
told = json.load(open("report.json"))["outcome"]["torn"]
assert [f for a, b in told[0]["frames"] for f in range(a, b + 1)] == torn, (told, torn)
text = ", ".join("%d" % a if a == b else "%d-%d" % (a, b) for a, b in told[0]["frames"])
assert 'muscle "biceps" was torn in frame%s %s' % ("s" if len(torn) > 1 else "", text) in sys.argv[1], sys.argv[1]
END
    run -3 simulate arm.scene.json --frames 0:12 --log log.jsonl --fail-on 'edge>1.001,torn>0'
    [[ "$output" == *"edge is 1."*", above the limit of 1.001"* ]]
}

@test "a muscle on one bone and a grip of speckles are warned of, and nothing else is" {
    python3 - <<'END'
import json
s = json.load(open("arm.scene.json")); s["muscles"] = s["muscles"][:1]
rig = json.load(open("biceps.muscle.json"))
parts = rig["attachments"]
for a in parts: [a.pop(k, None) for k in ("distances", "reasons", "confidence")]
def save(name, attachments):
    rig["attachments"] = attachments
    json.dump(rig, open(name + ".muscle.json", "w"))
    s["muscles"][0]["rig"] = name + ".muscle.json"
    json.dump(s, open(name + ".scene.json", "w"))
held = {v for a in parts for v in a["vertices"]}
t = rig["mesh"]["triangles"]
near = {}
for i in range(0, len(t), 3):
    for v in t[i:i + 3]: near.setdefault(v, set()).update(t[i:i + 3])
lone, used = [], set(held)
for v in sorted(near): # none beside another
    if v not in used and len(lone) < 30:
        lone.append(v); used |= near[v]
save("one", parts[:1])
save("speckled", parts + [dict(bone="humerus", method="pin", vertices=lone)])
save("good", parts)
END
    for kind in one speckled good; do
        run -0 --separate-stderr simulate $kind.scene.json --frames 0:1 --log log.jsonl
        warnings=$(grep warning <<< "$stderr" || true)
        echo "$kind: $warnings"
        [ "$(grep -c . <<< "$warnings")" -eq "$([ $kind = good ] && echo 0 || echo 1)" ]
        case $kind in
        one) [[ "$warnings" == *'muscle "biceps" is held by one bone only, '*"--bone"* ]] ;;
        speckled) [[ "$warnings" == *'muscle "biceps": humerus holds scattered vertices'*"--landmarks"* ]] ;;
        esac
        run -0 --separate-stderr simulate -q $kind.scene.json --frames 0:1 --log log.jsonl
        [ -z "$stderr" ]
    done
}

@test "--report holds timings and --plan measured costs; the log none" {
    simulate arm.scene.json --frames 0:3 --report report.json > log.jsonl
    grep -q '"medianFrameSeconds"' report.json
    python3 -c 'import json; r = json.load(open("report.json")); assert (r["frames"], r["steppedFrames"]) == (4, 3), r' # the first is none
    simulate --plan arm.scene.json | python3 -c 'import json,sys
for m in json.load(sys.stdin)["plan"]["muscles"]:
    for g in m["groups"]: assert ("millisecondsPerFrame" in g) == (g["rows"] > 0) and g.get("millisecondsPerFrame", 1) > 0'
    refute grep -qi second log.jsonl
}

# ---- real muscles: 90 frames, activation 0 to 1 with contraction 0.3, the joint 0 to -30 degrees ------------------------------

# check CACHE LOG DOCUMENT BONES POINT AXIS: no NaN, volume within 1 %, and the vertices on BONES exactly where the hinge puts them
# (to the last bit of the cache's single precision), those on other bones where they were
check_run() {
    python3 - "$@" <<'END'
import json, math, struct, sys
cache, log, document, moving = sys.argv[1:5]
point, axis = ([float(x) for x in word.split(",")] for word in sys.argv[5:7])
length = math.sqrt(sum(x * x for x in axis))
axis = [x / length for x in axis]
for line in open(log):
    l = json.loads(line)
    assert l["nan"] == 0 and abs(l["volume_error"]) < 0.01, line
muscle = json.load(open(document))
rest = muscle["mesh"]["vertices"]
data = open(cache, "rb").read()
count, samples = struct.unpack("<i8xi", data[16:32])
assert samples == len(open(log).readlines()) and samples >= 10
def turn(p, angle):
    d = [a - b for a, b in zip(p, point)]
    c, s = math.cos(angle), math.sin(angle)
    along = sum(a * b for a, b in zip(axis, d))
    cross = [axis[1] * d[2] - axis[2] * d[1], axis[2] * d[0] - axis[0] * d[2], axis[0] * d[1] - axis[1] * d[0]]
    return [point[i] + c * d[i] + s * cross[i] + (1 - c) * along * axis[i] for i in range(3)]
checked = 0
for frame in range(samples):
    frames = struct.unpack_from("<%df" % (3 * count), data, 32 + 12 * count * frame)
    for a in muscle["attachments"]:
        for v in a["vertices"]:
            p = rest[3 * v:3 * v + 3]
            if a["bone"] in moving.split(","): p = turn(p, math.radians(-30 * frame / 90))
            for i in range(3):
                exact = struct.unpack("<f", struct.pack("<f", p[i]))[0]
                assert abs(frames[3 * v + i] - exact) <= 1.2e-7 * max(abs(exact), abs(point[i])), (frame, v)
                checked += 1
assert checked > 1000
# and the rest of it is a muscle still: between the bones, not crumpled into a point
assert min(json.loads(line)["smallest_triangle"] for line in open(log)) > 1e-3
END
}
frames() { if [ "${CONFIG:-release}" = release ]; then echo 0:90; else echo 0:12; fi; } # the slow builds look at the beginning only
scene() { # NAME UNIT BONES-JSON JOINT-JSON
    printf '{"format":"sinew-scene","version":1,"metersPerUnit":%s,"rate":24,"frames":[0,90],"motion":{"joints":[%s]},"bones":[%s],
"muscles":[{"name":"%s","rig":"%s.muscle.json","contraction":0.3,"activation":{"keys":[[0,0],[3.75,1]]}}]}' "$2" "$4" "$3" "$1" "$1" > "$1.scene.json"
}

@test "single precision gives the same muscle to rounding, the same bytes on any threads, and goes on from its states only" {
    one_muscle
    simulate one.scene.json --solver xpbd --frames 0:12 --log double.jsonl -o double.pc2
    simulate one.scene.json --precision single --threads 1 --frames 0:12 --log single.jsonl -o single.pc2
    refute cmp -s double.pc2 single.pc2
    python3 - <<'END'
import struct
def points(name):
    data = open(name, "rb").read()
    count, samples = struct.unpack("<i", data[16:20])[0], struct.unpack("<i", data[28:32])[0]
    return struct.unpack("<%df" % (3 * count * samples), data[32:])
a, b, = points("double.pc2"), points("single.pc2")
size = max(a) - min(a)
assert max(abs(x - y) for x, y in zip(a, b)) < 1e-4 * size, max(abs(x - y) for x, y in zip(a, b)) / size
END
    # in the scene, and back from --plan
    python3 -c 'import json; s=json.load(open("one.scene.json")); s["solver"]={"precision": "single"}; json.dump(s, open("float.scene.json", "w"))'
    simulate float.scene.json --threads 3 --frames 0:12 --log again.jsonl -o again.pc2
    cmp single.pc2 again.pc2
    cmp single.jsonl again.jsonl
    simulate float.scene.json --plan | grep -q '"precision": "single"'
    simulate one.scene.json --solver xpbd --plan | grep -q '"precision": "double"'
    # stopped in the middle of a substep
    simulate float.scene.json --frames 0:12 --stop-after 6:3:1 --state half.state --log half.jsonl -o half.pc2
    simulate float.scene.json --frames 6:12 --from half.state --log rest.jsonl -o rest.pc2
    [ "$(tail -n 1 rest.jsonl)" = "$(tail -n 1 single.jsonl)" ]
    run -1 simulate one.scene.json --frames 6:12 --from half.state
    [[ "$output" == *half.state* ]]
    # not under qn
    run -1 simulate float.scene.json --solver qn --precision single --frames 0:1
    [[ "$output" == *"solver.precision single is for xpbd"* ]]
    run -2 simulate one.scene.json --precision half
}

@test "the hinges of the scheme kohout are published or printed, in both precisions; no other scheme has a choice" {
    one_muscle
    run_kohout() { simulate one.scene.json --scheme kohout --substeps 1 --iterations 3 --frames 0:12 "$@" > log.jsonl; }
    run_kohout -o plain.pc2
    run_kohout --hinges scheme -o scheme.pc2
    run_kohout --hinges published -o published.pc2
    run_kohout --hinges printed --threads 1 -o printed.pc2
    run_kohout --hinges printed --precision single -o single.pc2
    cmp plain.pc2 scheme.pc2
    cmp plain.pc2 published.pc2
    refute cmp -s plain.pc2 printed.pc2
    refute cmp -s single.pc2 printed.pc2
    # in the scene, and back from --plan
    python3 -c 'import json; s=json.load(open("one.scene.json")); s["solver"]={"scheme": "kohout", "hinges": "printed", "substeps": 1, "iterations": 3}; json.dump(s, open("printed.scene.json", "w"))'
    simulate printed.scene.json --threads 3 --frames 0:12 -o again.pc2 > log.jsonl
    cmp printed.pc2 again.pc2
    simulate --plan printed.scene.json | grep -q '"hinges": "printed"'
    simulate --plan one.scene.json --scheme kohout | grep -q '"hinges": "published"'
    simulate --plan one.scene.json > plan.json
    refute grep -q hinges plan.json
    for words in "--hinges published" "--hinges printed --scheme romeo" "--hinges published --solver xpbd" "--hinges printed --solver qn"; do
        run -1 simulate one.scene.json $words
        [[ "$output" == *"solver.hinges is a choice of the scheme kohout; leave it out or choose that scheme"* ]]
    done
    run -2 simulate one.scene.json --scheme kohout --hinges paper
}

@test "the quasi-Newton solver holds the volume in a few iterations a frame and stops where it says" {
    one_muscle
    simulate one.scene.json --solver qn --frames 0:12 --log qn.jsonl -o qn.pc2
    python3 - <<'END'
import json
lines = [json.loads(line) for line in open("qn.jsonl")]
assert len(lines) == 13
for line in lines[1:]:
    assert 1 <= line["iterations"] <= 10 and line["nan"] == 0 and line["restarts"] == 0, line
    assert abs(line["volume_error"]) < 0.01, line
    assert line["stopped_by"] in ("iterations", "tolerance", "stalled"), line
END
    simulate one.scene.json --solver qn --iterations 400 --tolerance 1e-9 --frames 0:12 --log exact.jsonl -o exact.pc2
    tail -n 1 exact.jsonl | grep -q '"stopped_by":"\(tolerance\|stalled\)"'
    refute cmp -s qn.pc2 exact.pc2
}

@test "the tibialis anterior between tibia and a talus that turns" {
    leg=$DATA/leg-vhf/meshes/VHF_Left
    [ -e "${leg}_Bone_Talus_smooth.ply" ] || skip "no real anatomy at $DATA"
    # upper attachment on the tibia; the lowest 10 mm on the talus, whose box has its centre at 510.8, 425.2, 143.2 mm
    mesh-clean --units mm "${leg}_Muscle_TibialisAnterior_smooth.ply" | root-select | build-structure | fiber-flow |
        attach-detect --bone tibia="${leg}_Bone_Tibia_smooth.ply" --pin talus=half:0,0,221.415,0,0,-1 -o tibialis.muscle.json
    scene tibialis 0.001 '{"name":"tibia","mesh":"tibia.ply"},{"name":"talus","mesh":"talus.ply","joint":"ankle"}' \
        '{"name":"ankle","type":"hinge","axis":[1,0,0],"point":[510.8,425.2,143.2],"keys":[[0,0],[3.75,-30]]}'
    simulate tibialis.scene.json --frames "$(frames)" -o tibialis.pc2 --fail-on 'volume>0.01,nan>0' > tibialis.jsonl
    check_run tibialis.pc2 tibialis.jsonl tibialis.muscle.json talus 510.8,425.2,143.2 1,0,0
}

@test "the dog's left biceps brachii over a bending elbow" {
    dog=$DATA/dog-dmcontrol/meshes
    [ -e "$dog/BONEUlna_L.stl" ] || skip "no real anatomy at $DATA"
    # the elbow's place and axis are dog.xml's: joint elbow_L
    mesh-clean "$dog/MUSCm.biceps_brachii_L.stl" | root-select | build-structure | fiber-flow |
        attach-detect --bone scapula="$dog/BONEScapula_L.stl" --bone humerus="$dog/BONEhumerus_L.stl" --bone radius="$dog/BONERadius_L.stl" \
            --bone ulna="$dog/BONEUlna_L.stl" -o biceps.muscle.json
    scene biceps 1 '{"name":"scapula","mesh":"s.stl"},{"name":"humerus","mesh":"h.stl"},{"name":"radius","mesh":"r.stl","joint":"elbow"},{"name":"ulna","mesh":"u.stl","joint":"elbow"}' \
        '{"name":"elbow","type":"hinge","axis":[0,1,0.2],"point":[0.1454,0.068,0.28022],"keys":[[0,0],[3.75,-30]]}'
    simulate biceps.scene.json --frames "$(frames)" -o biceps.pc2 --fail-on 'volume>0.01,nan>0' > biceps.jsonl
    check_run biceps.pc2 biceps.jsonl biceps.muscle.json radius,ulna 0.1454,0.068,0.28022 0,1,0.2
}

@test "tone and restLength that are not felt are told" {
    one_muscle
    python3 -c 'import json
s = json.load(open("one.scene.json")); s["muscles"][0].update(restLength=0.9, tone=0.2); json.dump(s, open("toned.scene.json", "w"))
m = json.load(open("biceps.muscle.json")); del m["fibers"]; json.dump(m, open("bare.muscle.json", "w"))
s["muscles"][0].update(rig="bare.muscle.json", tone=0); json.dump(s, open("bare.scene.json", "w"))'
    simulate toned.scene.json --frames 0:0 --log log.jsonl 2> err
    refute grep -q restLength err
    simulate toned.scene.json --scheme kohout --frames 0:0 --log log.jsonl 2> err
    grep -q 'muscle "biceps": restLength and tone have no effect under the scheme kohout' err
    simulate bare.scene.json --frames 0:0 --log log.jsonl 2> err
    grep -q 'muscle "biceps": restLength shortens nothing on its surface' err
}

@test "--stop-after takes frames before 0" {
    one_muscle
    simulate one.scene.json --frames=-3:2 --stop-after -2 --log log.jsonl
    [ "$(values log.jsonl frame | tr '\n' ' ')" = "-3 -2 " ]
    run -2 simulate one.scene.json --frames 0:2 --stop-after=-1 --log log.jsonl
    [[ "$output" == *"--stop-after -1: the run starts at frame 0"* ]]
}

@test "a state of another rate is refused, and says which" {
    one_muscle
    simulate -q one.scene.json --frames 0:2 --state s.state > /dev/null
    run -2 simulate -q one.scene.json --rate 48 --frames 3:4 --from s.state
    [[ "$output" == *"made at 24 frames a second, and the scene has 48"* ]]
    simulate -q one.scene.json --rate 48 --frames 0:2 --state t.state > /dev/null
    simulate -q one.scene.json --rate 48 --frames 3:4 --from t.state > /dev/null
}

# The arm's muscles tied to each other by candidates, in glued/, with weights given.
glue() {
    mkdir -p glued
    for m in biceps brachialis triceps; do
        local others=() o
        for o in biceps brachialis triceps; do [ $o = $m ] || others+=(--glue $o=$o.muscle.json); done
        "$BIN/attach-detect" -q $m.muscle.json "${others[@]}" --reach 12mm "$@" -o glued/$m.muscle.json
    done
    /usr/bin/python3 - << 'END'
import json
s = json.load(open("arm.scene.json"))
for m in s["muscles"]: m["rig"] = "glued/" + m["rig"]
json.dump(s, open("tied.scene.json", "w"))
s["muscles"].reverse()
json.dump(s, open("turned.scene.json", "w"))
END
}

@test "external constraints: off is absent; groups in the plan; any order, threads and stopping give the same bytes; they hold" {
    glue
    mkdir a b c
    "$BIN/simulate" -q arm.scene.json --frames 0:30 -o a --log a.jsonl
    "$BIN/simulate" -q tied.scene.json --frames 0:30 -o b --log b.jsonl
    cmp a.jsonl b.jsonl; cmp a/biceps.pc2 b/biceps.pc2
    "$BIN/simulate" --plan --externals tied.scene.json > plan.json
    /usr/bin/python3 -c 'import json
d = json.load(open("plan.json"))
assert len(d["plan"]["coupled"]) == 1 and len(d["plan"]["coupled"][0]["muscles"]) >= 2 and d["plan"]["coupled"][0]["rows"] > 20, d["plan"]["coupled"]
m = d["plan"]["coupled"][0]["matrix"]
assert m["entries"] > 1000 and m["solveMilliseconds"] > 0 and m["factorMilliseconds"] > 0, m
assert m["bytes"] > 12 * m["entries"], m  # a number and its row each, and the matrix itself
tied = d["plan"]["coupled"][0]["muscles"]
assert all(("matrix" in m) == (m["name"] not in tied) for m in d["plan"]["muscles"]), d["plan"]["muscles"]
assert d["scene"]["externals"] == {"stiffness": 10, "slide": True, "soft": True, "hard": True, "minimum": True, "resolve": 0}'
    "$BIN/simulate" -q tied.scene.json --externals --frames 0:30 -o a --log a.jsonl --threads 1
    "$BIN/simulate" -q turned.scene.json --externals --frames 0:30 -o b --log b.jsonl --threads 4
    for m in biceps brachialis triceps; do cmp a/$m.pc2 b/$m.pc2; done
    /usr/bin/python3 -c 'import json
rows = [json.loads(line) for line in open("a.jsonl")]
tied = [r for r in rows if r["errors"].get("external") and r["residual"] is not None]
for r in tied:
    now = {o["muscle"]: o["residual"] for o in tied if o["frame"] == r["frame"]}
    assert r["group_residual"] == max(now.values()) == now[r["group_worst"]], r
assert tied and all(("group_worst" in r) == ("external" in r["errors"]) for r in rows)'
    sort a.jsonl > a.sorted; sort b.jsonl | cmp - a.sorted
    "$BIN/simulate" -q tied.scene.json --externals --frames 0:12 -o c --log c1.jsonl --state s.state
    "$BIN/simulate" -q tied.scene.json --externals --from s.state --frames 13:30 -o c --log c2.jsonl
    cat c1.jsonl c2.jsonl | cmp - a.jsonl
    "$BIN/simulate" -q tied.scene.json --externals --external-stiffness 1e-6 --frames 0:30 -o b --log loose.jsonl
    /usr/bin/python3 -c 'import json
def rms(name): return max(d["errors"]["external"]["rms"] for d in map(json.loads, open(name)) if "external" in d["errors"])
assert rms("a.jsonl") < 0.3 * rms("loose.jsonl"), (rms("a.jsonl"), rms("loose.jsonl"))'
}

@test "external constraints to what is not there, or is another mesh, are refused; what does nothing is said" {
    glue
    sed 's/"biceps"/"bizeps"/g' glued/brachialis.muscle.json > other.json && mv other.json glued/brachialis.muscle.json
    run -1 "$BIN/simulate" -q tied.scene.json --externals --frames 0:1
    [[ $output == *'muscle "brachialis"'*'"bizeps"'* ]]
    "$BIN/simulate" -q tied.scene.json --frames 0:1
    glue
    "$BIN/simulate" tied.scene.json --external-stiffness 5 --frames 0:1 > log 2> err
    grep -q 'external-stiffness has no effect' err
    "$BIN/simulate" tied.scene.json --externals --solver xpbd --precision single --frames 0:1 > log 2> err
    grep -q 'external constraints are left out' err
    run -2 "$BIN/simulate" tied.scene.json --externals --no-externals
}

@test "a target that is listed twice is refused, but for another fascia" {
    glue
    /usr/bin/python3 - << 'END'
import json
d = json.load(open("glued/biceps.muscle.json"))
d["externals"].append(dict(d["externals"][0]))
json.dump(d, open("glued/biceps.muscle.json", "w"))
d["externals"][-1] = dict(d["externals"][0], fascia="superficial", weights=[0, 0, 1] * len(d["externals"][0]["vertices"]))
json.dump(d, open("other.json", "w"))
END
    run -1 "$BIN/simulate" -q tied.scene.json --externals --frames 0:1
    [[ $output == *'externals: has the target '*' twice'* ]]
    mv other.json glued/biceps.muscle.json
    "$BIN/simulate" -q tied.scene.json --externals --frames 0:1
}

@test "muscles whose frames would be one file are refused before any work, and none becomes a hidden file" {
    "$EXAMPLES/tip/tip" --triangles 200 tip > /dev/null
    name_two() {
        python3 - "$@" << 'END'
import json, sys
scene = json.load(open("tip/tip.scene.json"))
scene["muscles"] = [dict(scene["muscles"][0], name=name) for name in sys.argv[1:]]
json.dump(scene, open("tip/two.scene.json", "w"))
END
    }
    for names in "a/b a_b" ".a _a" "/a .a"; do
        # shellcheck disable=SC2086
        name_two $names
        run -1 "$BIN/simulate" -q tip/two.scene.json --frames 0:1 -o nowhere
        for name in $names; do [[ "$output" == *"\"$name\""* ]] || { echo "$output"; false; }; done
        [ ! -e nowhere ]
    done
    name_two x x-fibers
    "$BIN/simulate" -q tip/two.scene.json --frames 0:1 -o apart --log log
    [ "$(ls apart)" = "x-fibers.pc2
x.pc2" ]
    run -1 "$BIN/simulate" -q tip/two.scene.json --frames 0:1 --fibers -o nowhere
    name_two .hidden a.b
    "$BIN/simulate" -q tip/two.scene.json --frames 0:1 -o shown --log log
    [ "$(ls -A shown)" = "_hidden.pc2
a.b.pc2" ]
}

@test "a limit that names nothing and a stop beyond the run are wrong usage" {
    "$EXAMPLES/tip/tip" --triangles 200 tip > /dev/null
    run -2 "$BIN/simulate" -q tip/tip.scene.json --frames 0:2 --fail-on '' --log log
    [[ "$output" == *--fail-on*"names no limit"* ]]
    run -2 "$BIN/simulate" -q tip/tip.scene.json --frames 0:2 --stop-after 3 --log log
    [[ "$output" == *"--stop-after 3: the run ends with frame 2"* ]]
    "$BIN/simulate" -q tip/tip.scene.json --frames 0:2 --stop-after 2 --log log
}

@test "external constraints: a muscle slides along a bone farther than it was at rest" {
    python3 - <<'PY'
import json

def box(name, low, high, counts):
    n, points, faces = counts, {}, []
    def at(*i):
        return points.setdefault(i, len(points) + 1)
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, n[axis]):
            for a in range(n[u]):
                for b in range(n[v]):
                    corners = []
                    for da, db in ((0, 0), (1, 0), (1, 1), (0, 1)) if end else ((0, 0), (0, 1), (1, 1), (1, 0)):
                        i = [0, 0, 0]
                        i[axis], i[u], i[v] = end, a + da, b + db
                        corners.append(at(*i))
                    faces.append(corners)
    with open(name, "w") as out:
        for i in points:
            out.write("v %.9g %.9g %.9g\n" % tuple(low[k] + (high[k] - low[k]) * i[k] / n[k] for k in range(3)))
        for f in faces:
            out.write("f %d %d %d\nf %d %d %d\n" % (f[0], f[1], f[2], f[0], f[2], f[3]))

box("strap.obj", (-.05, -.01, .001), (.05, .01, .007), (20, 4, 2))
box("plate.obj", (-.8, -.6, -.02), (.8, .2, 0), (80, 40, 1))
json.dump({"format": "sinew-scene", "version": 1, "rate": 24, "frames": [0, 48], "externals": {},
           "motion": {"joints": [{"name": "car", "type": "hinge", "axis": [0, 0, 1], "point": [0, -1, 0],
                                  "keys": [[0, 0], [1, 4]], "interpolation": "smooth"}]},
           "bones": [{"name": "plate", "mesh": "plate.obj"}],
           "muscles": [{"name": "strap", "rig": "strap.muscle.json"}]}, open("slide.scene.json", "w"))
PY
    mesh-clean -q strap.obj | root-select -q | build-structure -q | fiber-flow -q |
        attach-detect -q --method none --pin car=half:-.045,0,0,-1,0,0 --pin car=half:.045,0,0,1,0,0 |
        attach-detect -q --glue plate.obj --reach 5mm -o strap.muscle.json
    simulate -q slide.scene.json -o slid --format ply > slide.jsonl
    # 70 mm along the plate it lies on it as at rest: z from 1 to 7 mm
    python3 -c 'import struct
lines = open("slid/strap.0048.ply", "rb").read()
head, body = lines.split(b"end_header\n", 1)
count = int(head.split(b"element vertex ")[1].split()[0])
size = {b"float": 4, b"double": 8}[head.split(b"property ")[1].split()[0]]
z = [struct.unpack_from("<d" if size == 8 else "<f", body, size * (3 * i + 2))[0] for i in range(count)]
assert abs(min(z) - 0.001) < 2e-5 and abs(max(z) - 0.007) < 2e-5, (min(z), max(z))'
}

# filled.scene.json: the biceps alone, with fibres
filled_scene() {
    one_muscle
    fiber-fill -q biceps.muscle.json -o filled.muscle.json
    sed 's/biceps.muscle.json/filled.muscle.json/' one.scene.json > filled.scene.json
}
# everything that a run can write frame by frame, into the folder $1; and what comes of it without the reports of runs
everything() { local to=$1; shift; mkdir -p $to; simulate -q "$@" -o $to/frames --fibers --lengths $to/lengths.sto --bone-frames $to/bones.pvd --log $to/log.jsonl; }

@test "--from goes on with the outputs of the run before: the bytes of one that did not stop" {
    filled_scene
    run="filled.scene.json --solver xpbd --substeps 4"
    everything all $run --frames 0:8 --blend 1
    simulate -q $run --frames 0:8 --format ply -o all/meshes --bone-frames all/bones --log all/log2.jsonl
    simulate -q $run --frames 0:8 -o all/caches --bone-frames all/caches/bones --lengths all/lengths.tsv --log all/log3.jsonl
    for stop in 4 4:2 4:2:1; do # at the end of a frame, in it, in a substep
        rm -rf out
        everything out $run --frames 0:8 --blend 1 --stop-after $stop --state s.state
        everything out $run --blend 1 --frames 4:8 --from s.state
        simulate -q $run --frames 0:8 --format ply -o out/meshes --bone-frames out/bones --log out/log2.jsonl --stop-after $stop
        simulate -q $run --frames 4:8 --format ply -o out/meshes --bone-frames out/bones --log out/log2.jsonl --from s.state
        simulate -q $run --frames 0:8 -o out/caches --bone-frames out/caches/bones --lengths out/lengths.tsv --log out/log3.jsonl --stop-after $stop
        simulate -q $run --frames 4:8 -o out/caches --bone-frames out/caches/bones --lengths out/lengths.tsv --log out/log3.jsonl --from s.state
        diff -r all out
    done
    # into new ones from the state on, and there again: as any other run writes anew what is there
    for again in 1 2; do
        everything new $run --blend 1 --frames 4:8 --from s.state
        [ "$(samples new/frames/biceps.pc2)" -eq 5 ]
    done
    # a head of another number of digits
    simulate -q $run --frames 0:8 --lengths few.sto --state nine.state > few.jsonl
    simulate -q $run --frames 0:10 --lengths many.sto > many.jsonl
    simulate -q $run --frames 9:10 --lengths few.sto --from nine.state --log few.jsonl
    cmp few.sto many.sto
    cmp few.jsonl many.jsonl
}

# went_on TEXT OPTION...: going on is refused with status 2, and nothing in out changes
went_on() {
    local text=$1; shift
    rm -rf before; cp -r out before
    run -2 --separate-stderr simulate -q filled.scene.json --solver xpbd --substeps 4 --from s.state "$@"
    [[ "$stderr" == *"$text"* ]] || { echo "$stderr"; return 1; }
    [ "$(wc -l <<< "$stderr")" -eq 1 ]
    diff -r before out
}

@test "--from refuses outputs that are not of its run, before any work" {
    filled_scene
    run="filled.scene.json --solver xpbd --substeps 4"
    everything out $run --frames 0:8 --stop-after 4 --state s.state
    simulate -q $run --frames 0:8 --format ply -o out/meshes --log out/log2.jsonl --stop-after 4
    simulate -q $run --frames 0:8 --stop-after 1 --state one.state > /dev/null
    everything later $run --frames 2:8 --from one.state
    simulate -q $run --frames 0:2 -o out/short.pc2 --lengths out/short.tsv --log out/short.jsonl
    simulate -q filled.scene.json --solver xpbd --substeps 5 --frames 0:6 -o out/near.pc2 --lengths out/near.tsv --log out/near.jsonl
    cp -r later out/later
    went_on "ends with frame 2, before the state's frame 4" -o out/short.pc2
    went_on "ends with frame 2, before the state's frame 4" --lengths out/short.tsv
    went_on "ends with frame 2, before the state's frame 4" --log out/short.jsonl
    went_on "its frame 4 is not that of the state" -o out/near.pc2
    went_on "its frame 4 is not that of the state" --lengths out/near.tsv
    went_on "begins with frame 0, but out/later/frames/biceps.pc2 with frame 2" -o out/later/frames --log out/log.jsonl
    # smoothed lengths depend on what comes after them
    simulate -q $run --frames 0:8 --stop-after 4 --lengths out/smooth.tsv --smooth-lengths > /dev/null
    went_on "smoothed lengths cannot be gone on with" --lengths out/smooth.tsv --smooth-lengths
    # other columns, other points, nothing of the kind
    went_on "has other columns" --lengths out/lengths.sto --blend 1
    python3 -c 'import struct
d = bytearray(open("out/frames/biceps.pc2", "rb").read()); struct.pack_into("<i", d, 16, 100); open("out/points.pc2", "wb").write(d)
d = bytearray(open("out/frames/biceps.pc2", "rb").read()); struct.pack_into("<f", d, 24, 2); open("out/rate.pc2", "wb").write(d)'
    went_on "has 100 points, and the run has 521" -o out/points.pc2
    went_on "has frames 2 apart from frame 0 on" -o out/rate.pc2
    echo "{}" > out/no.jsonl
    went_on "is not the log of an earlier run" --log out/no.jsonl
    sed 2d out/log.jsonl > out/gap.jsonl
    went_on "does not hold every frame" --log out/gap.jsonl
    rm out/frames/biceps-fibers.pvd
    went_on "holds 1 of 2 outputs of the earlier run" -o out/frames --fibers
    cp out/meshes/biceps.0003.ply out/meshes/biceps.0004.ply
    went_on "its frame 4 is not that of the state" --format ply -o out/meshes
    rm out/meshes/biceps.0002.ply
    went_on "some are missing" --format ply -o out/meshes
    # what goes beyond the state is cut off, which is said
    cp out/near.pc2 beyond.pc2
    simulate -q $run --frames 0:7 -o beyond.pc2 --log beyond.jsonl
    run -0 --separate-stderr simulate $run --frames 5:6 --from s.state -o beyond.pc2 --log beyond.jsonl
    [[ "$stderr" == *"beyond.pc2 and what belongs to it go to frame 7, beyond the state's, 4: what is behind that is cut off"* ]]
    [ "$(samples beyond.pc2)" -eq 7 ]
    [ "$(stat -c %s beyond.pc2)" -eq $((32 + 7 * 12 * 521)) ]
    [ "$(wc -l < beyond.jsonl)" -eq 7 ]
}

@test "a run that was killed at any moment is gone on with to the bytes of one that was not" {
    filled_scene
    cat > killed.py <<'END2'
import filecmp, os, random, shutil, signal, subprocess, struct, time
random.seed(7)
base = ["simulate", "-q", "filled.scene.json", "--solver", "xpbd", "--substeps", "2"]
def outputs(to): return ["-o", to, "--fibers", "--lengths", to + "/lengths.sto", "--bone-frames", to + "/bones.pvd", "--log", to + "/log.jsonl"]
def launch(to, *more):
    os.makedirs(to, exist_ok=True)
    return subprocess.Popen(base + outputs(to) + list(more))
def run(to, *more): assert launch(to, *more).wait() == 0
began = time.monotonic()
run("all", "--frames", "0:59", "--save-every", "3", "--state", "all.state")
whole = time.monotonic() - began
names = sorted(os.listdir("all"))
mid_run = 0
for k in range(20):
    shutil.rmtree("out", ignore_errors=True)
    if os.path.exists("s.state"): os.unlink("s.state")
    p = launch("out", "--frames", "0:59", "--save-every", "3", "--state", "s.state")
    time.sleep(whole * random.uniform(0.02, 0.95))
    p.send_signal(signal.SIGKILL)
    p.wait()
    # a new content gets a name beside the old one, and then that one's: two calls, between which a kill may fall; no more than one is left
    leftovers = [n for n in os.listdir("out") if n.startswith(".sinew-") and n.endswith("~")] if os.path.isdir("out") else []
    assert len(leftovers) <= 1, leftovers
    for name in leftovers: os.unlink("out/" + name)
    if os.path.exists("out/biceps.pc2"): # no moment at which it counts more than it holds
        data = open("out/biceps.pc2", "rb").read()
        points, count = struct.unpack("<i", data[16:20])[0], struct.unpack("<i", data[28:32])[0]
        assert count >= 0 and 32 + 12 * points * count <= len(data)
    frame = struct.unpack("<i", open("s.state", "rb").read()[160:164])[0] if os.path.exists("s.state") else -1
    if 0 <= frame < 59:
        mid_run += 1
        run("out", "--from", "s.state")
    elif frame < 0:
        run("out", "--frames", "0:59")
    assert sorted(os.listdir("out")) == names, k
    same = filecmp.cmpfiles("all", "out", names, shallow=False)
    assert len(same[0]) == len(names), (k, same[1:])
print(mid_run, "of 20 had a state")
assert mid_run > 0
END2
    python3 -c 'import json
s = json.load(open("filled.scene.json")); s["frames"] = [0, 59]; json.dump(s, open("filled.scene.json", "w"))'
    python3 killed.py
}

@test "an older sequence that would mix with the run's frames is refused before any work" {
    filled_scene
    simulate -q filled.scene.json --frames 0:3 -o out --format ply --bone-frames bones --log log.jsonl
    simulate -q filled.scene.json --frames 0:3 -o fibres --fibers --bone-frames bones.pvd --log log.jsonl
    for options in "-o out --format ply" "--bone-frames bones --format ply" "-o fibres --fibers" "--bone-frames bones.pvd"; do
        run -2 --separate-stderr simulate -q filled.scene.json --frames 0:2 $options --log other.jsonl
        [[ "$stderr" == *".0003."*"is of an older sequence, whose frames 0 to 3 would mix with the run's, 0 to 2"* ]]
        run -2 simulate -q filled.scene.json --frames 1:4 $options --log other.jsonl
        simulate -q filled.scene.json --frames 0:4 $options --log other.jsonl
        rm other.jsonl
        run -2 simulate -q filled.scene.json --frames 0:3 $options --log other.jsonl
        refute [ -e other.jsonl ]
    done
}

@test "documents that name pipes, devices or nothing are refused at once" {
    mkfifo pipe
    ln -s /dev/zero zero.json
    for file in pipe /dev/zero zero.json; do
        for change in "s['muscles'][0]['rig']=f" "s['bones'][0]['mesh']=f" "s['motion']={'uri':f}"; do
            python3 -c "import json,sys; s=json.load(open('arm.scene.json')); f=sys.argv[1]; $change; json.dump(s,open('odd.scene.json','w'))" $file
            for option in --plan "--frames 0:0" "--contact --frames 0:0"; do
                run -1 --separate-stderr timeout 20 simulate odd.scene.json $option
                [[ "$stderr" == *"${file##*/}"*"is a device or a pipe"* ]] || { echo "$change $option: $stderr"; return 1; }
                [ -z "$output" ]
            done
        done
    done
    sed 's/"ulna.ply"/"nowhere.ply"/' arm.scene.json > odd.scene.json # also where no run looks at it
    for option in --plan "--frames 0:0"; do
        run -0 --separate-stderr simulate odd.scene.json $option
        [[ "$stderr" == *'warning: '*'nowhere.ply: bone "ulna": cannot be opened'*"this run does without its surface"* ]]
    done
    run -1 simulate odd.scene.json --contact --frames 0:0
}

@test "outputs that cannot be written are told before any work; one file twice is wrong usage" {
    one_muscle
    mkdir shut
    for option in --state --report --trace --lengths; do
        run -1 --separate-stderr simulate one.scene.json --frames 0:1 $option nowhere/file --log log.jsonl
        [[ "$stderr" == *"nowhere/file: cannot be written"* ]]
        run -1 simulate one.scene.json --frames 0:1 $option shut --log log.jsonl
        [[ "$output" == *"shut: is a directory"* ]]
    done
    refute [ -e log.jsonl ]
    ln one.scene.json linked
    ln -s log.jsonl again
    simulate -q one.scene.json --frames 0:1 --log log.jsonl --state s.state -o out.pc2
    sum=$(cat one.scene.json log.jsonl s.state out.pc2 | sha256sum)
    while read -r options; do
        run -2 --separate-stderr simulate -q $options
        [[ "$stderr" == *"are one file"* ]] || { echo "$options: $stderr"; return 1; }
        [ "$(wc -l <<< "$stderr")" -eq 1 ]
        [ "$(cat one.scene.json log.jsonl s.state out.pc2 | sha256sum)" = "$sum" ]
    done << 'END'
one.scene.json --log new --report new
one.scene.json --log new --state ./new
one.scene.json --log log.jsonl --report again
one.scene.json --log one.scene.json
one.scene.json --report linked
one.scene.json --from s.state --frames 2:3 --log s.state
one.scene.json -o out.pc2 --log out.pc2
END
    simulate -q one.scene.json --from s.state --frames 2:3 --state s.state --log log.jsonl -o out.pc2
    simulate -q one.scene.json --frames 0:1 --log /dev/null --trace /dev/null
    simulate -q one.scene.json --frames 0:1 -o moved --report moved/report.json --state moved/end.state > /dev/null
    [ -s moved/report.json ]
    [ -s moved/end.state ]
}

@test "the folders of caches are tried before any work, and made where they are missing" {
    one_muscle
    touch file
    for option in --grid-cache --embedding-cache; do
        more="--contact"
        [ $option = --grid-cache ] || more="--lengths l.tsv"
        run -1 --separate-stderr simulate one.scene.json --frames 0:1 $more $option nowhere/cache --log log.jsonl
        [[ "$stderr" == *"nowhere/cache: cannot be written"* ]] || { echo "$stderr"; false; }
        run -1 --separate-stderr simulate one.scene.json --frames 0:1 $more $option file --log log.jsonl
        [[ "$stderr" == *"file: is not a folder, which a cache is"* ]] || { echo "$stderr"; false; }
        refute [ -e log.jsonl ]
        refute [ -e l.tsv ]
    done
    simulate -q one.scene.json --frames 0:1 --contact --grid-cache cache --log log.jsonl
    [ -d cache ]
}

@test "a muscle whose externals name itself is told of" {
    python3 - << 'END'
import json
tetra = {"vertices": [0, 0, 0, .1, 0, 0, 0, .1, 0, 0, 0, .1], "triangles": [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]}
external = {"target": "m", "fascia": "deep", "vertices": [0], "triangles": [0], "barycentric": [1, 0, 0], "distances": [0], "minimumDistances": [0], "weights": [1, 0, 0]}
for name, target in ("self", "m"), ("other", "n"):
    external["target"] = target
    json.dump({"format": "sinew-muscle", "version": 1, "name": "m", "metersPerUnit": 1, "mesh": tetra, "externals": [external]}, open(name + ".json", "w"))
    json.dump({"format": "sinew-scene", "version": 1, "rate": 24, "frames": [0, 1], "externals": True,
               "muscles": [{"name": "m", "rig": name + ".json"}, {"name": "n", "rig": "other.json", "externals": False}]}, open(name + ".scene.json", "w"))
END
    run --separate-stderr simulate self.scene.json --log log
    [[ "$stderr" == *'warning: muscle "m": its externals name itself as a target, which binds nothing'* ]] || { echo "$stderr"; false; }
    run --separate-stderr simulate other.scene.json --log log
    [[ "$stderr" != *'name itself'* ]]
}
