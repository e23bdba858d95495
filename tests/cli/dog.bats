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
