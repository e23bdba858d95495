# share/examples/dog: a trot, as columns of coordinates for dog.xml's joints.

bats_require_minimum_version 1.5.0

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    trot=$BATS_TEST_DIRNAME/../../share/examples/dog/trot.awk
    dog="$DATA/dog-dmcontrol/dog.xml"
}

@test "the trot is a storage file of as many rows as it says, at the rate asked for" {
    awk -f "$trot" > trot.sto
    [ "$(sed -n '/endheader/,$p' trot.sto | tail -n +3 | wc -l)" -eq 101 ]
    grep -qx nRows=101 trot.sto
    awk -f "$trot" -v strides=1 -v rate=40 > short.sto
    grep -qx nRows=21 short.sto
    [ "$(tail -1 short.sto | cut -f1,2)" = "$(printf '0.500000\t0.600000')" ]
    # a stride later all but the way is the same
    [ "$(tail -1 short.sto | cut -f3-)" = "$(sed -n '/^time/{n;p}' short.sto | cut -f3-)" ]
    run -2 awk -f "$trot" -v rate=0
}

@test "the dog trots on its own joints: in their ranges, diagonals together, feet in turn, with its own bones" {
    [ -f "$dog" ] || skip "no dog-dmcontrol in DATA"
    awk -f "$trot" > trot.sto
    python3 "$BATS_TEST_DIRNAME/../model-fk.py" trot "$dog" trot.sto
    "$BIN/motion-import" trot.sto --skeleton "$dog" --bones bones --bone-path "$DATA/dog-dmcontrol/meshes" -o trot.motion.json 2> err
    [ "$(wc -l < err)" -eq 1 ] && grep -q 'includes are not read' err
    python3 "$BATS_TEST_DIRNAME/../model-fk.py" bones "$dog" trot.sto trot.motion.json "$DATA/dog-dmcontrol/meshes"
}

@test "sites become pins of their own muscles: not those of other muscles, of bones that are not there, or of a muscle with one alone" {
    sites=$BATS_TEST_DIRNAME/../../share/examples/dog/sites.awk
    {
        printf 'muscle\tbone\tx_m\ty_m\tz_m\tsite_radius_m\tmuscle_file\tbone_file\tdist_to_muscle_vertex_m\tdist_to_bone_vertex_m\n'
        printf 'a\tL-1\t1\t2\t3\t0.001\tMUSCa.stl\tBONEL_1.stl\t0.002\t0.001\n' # the name of the file, not of the site
        printf 'a\tRib_L_4\t4\t5\t6\t0.001\tMUSCa.stl\t\t0.020\t\n'             # merged; farther than 10 mm
        printf 'a\tL-2\t7\t8\t9\t0.001\tMUSCa.stl\tBONEL_2.stl\t0.500\t0.001\n' # another muscle's
        printf 'a\tTooth\t7\t8\t9\t0.001\tMUSCa.stl\tBONETooth.stl\t0.001\t0.001\n'
        printf 'b\tL-1\t1\t2\t3\t0.001\tMUSCb.stl\tBONEL_1.stl\t0.002\t0.001\n'
        printf 'c\tL-1\t1\t2\t3\t0.001\t\tBONEL_1.stl\t\t0.001\n'
    } > attachments.tsv
    printf 'L_1.ply\nL_2.ply\nRibcage.ply\n' | awk -f "$sites" - attachments.tsv > options.tsv
    printf 'MUSCa\tattach-detect\t--method none --pin L_1=sphere:1,2,3,0.01 --pin Ribcage=sphere:4,5,6,0.022\n' | cmp - options.tsv
}

@test "the muscles of the fore leg hold on to each other: nothing is torn, none enters another by a millimetre" {
    [ -f "$dog" ] || skip "no dog-dmcontrol in DATA"
    share=$BATS_TEST_DIRNAME/../../share/examples/dog
    "$share/fore-leg.sh" "$BIN" "$DATA/dog-dmcontrol" leg 2> err
    "$share/tie.sh" "$BIN" leg shoulder
    "$BIN/simulate" -q leg/tied.scene.json -o frames --log tied.jsonl --fail-on 'entered>0.001' --fail-on 'torn>0'
    "$BIN/simulate" -q leg/tied.scene.json --no-externals --log apart.jsonl
    python3 -c 'import json
def moments(name): return [json.loads(line) for line in open(name)]
tied, apart = moments("tied.jsonl"), moments("apart.jsonl")
assert len(tied) == 12 * 91 and sum("external" in r["errors"] for r in tied if r["frame"] == 0) == 12
worst = {r["errors"]["external"]["rms"] for r in tied if r["frame"] == 60}
assert max(worst) < 0.05, worst # mean edges
assert all("entered" not in r for r in apart)'
}

@test "all of the dog's muscles have rigs, candidates and a scene whose targets are there" {
    [ -f "$dog" ] || skip "no dog-dmcontrol in DATA"
    [ -n "${ALL_OF_THE_DOG:-}" ] || skip "takes minutes; set ALL_OF_THE_DOG"
    make -s -f "$BATS_TEST_DIRNAME/../../share/examples/dog/Makefile" -j2 DATA="$DATA" TOOLS="$BIN" scene 2> err
    [ "$(find rigs/candidates -name '*.muscle.json' | wc -l)" -eq 253 ]
    "$BIN/simulate" -q trot.scene.json --externals --plan | grep -q '"coupled"'
}
