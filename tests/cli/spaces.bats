# Anatomical spaces: --space in every tool that reads meshes; what headers of meshes, fibres, sites and landmarks say.

bats_require_minimum_version 1.5.0

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    python3 - << 'END'
corners = [(x, y, z) for x in (0, .02) for y in (0, .02) for z in (0, .2)]
faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
for space in ("RAS", "LPS", "none"):
    word = "SPACE=" + space if space != "none" else "nothing"
    with open(space + ".obj", "w") as out:
        out.write("# %s\n" % word)
        for c in corners: out.write("v %g %g %g\n" % c)
        for f in faces: out.write("f %d %d %d\n" % tuple(i + 1 for i in f))
    with open(space + "-lines.obj", "w") as out:
        out.write("# %s\nv .01 .01 .02\nv .01 .01 .18\nl 1 2\n" % word)
    with open(space + "-lines.vtk", "w") as out:
        out.write("# vtk DataFile Version 3.0\n%s\nASCII\nDATASET POLYDATA\nPOINTS 2 double\n.01 .01 .02 .01 .01 .18\nLINES 1 3\n2 0 1\n" % word)
    with open(space + ".sites", "w") as out:
        out.write("# %s\norigin .01 .01 0\ninsertion .01 .01 .2\n" % word)
    with open(space + ".areas.tsv", "w") as out:
        out.write("# %s\n" % word)
        for x, y in ((0, 0), (.02, 0), (.02, .02), (0, .02)): out.write("b\thead\t%g\t%g\t0\n" % (x, y))
END
    "$BIN/mesh-clean" -q --no-history --units m RAS.obj -o ras.json
    "$BIN/mesh-clean" -q --no-history --units m none.obj -o none.json
}

@test "every tool that reads meshes has --space, with its words in help and completions, and refuses others" {
    for tool in attach-detect build-structure envelope-bind error-time fiber-fill fiber-flow mesh-clean motion-fit rig-view root-select scene-build simulate; do
        "$BIN/$tool" --help | grep -q -e '--space SPACE'
        run -2 "$BIN/$tool" --space RSA
        [[ "$output" == *'--space'*LPS*RAS* ]] || { echo "$tool: $output"; false; }
    done
}

@test "--space says the space of a mesh that does not, goes before what a header says with a warning, and never moves a point" {
    "$BIN/mesh-clean" --no-history --units m --space LPS none.obj -o said.json 2> err
    grep -q '"space": "LPS"' said.json
    [ ! -s err ]
    "$BIN/mesh-clean" --no-history --units m --space LPS RAS.obj -o other.json 2> err
    grep -q 'warning: RAS.obj: its header says the space RAS; LPS is taken' err
    sed 's/"name": "RAS"/"name": "none"/' other.json | cmp - said.json
    diff <(sed '/"space"/d' said.json) none.json
    "$BIN/mesh-clean" --no-history --units m --space RAS RAS.obj -o same.json 2> err
    [ ! -s err ]
    cmp same.json ras.json
}

@test "--space beside a document: the same is fine, another is wrong usage, and one that says none takes it" {
    for tool in root-select mesh-clean build-structure fiber-flow fiber-fill attach-detect; do
        run -2 "$BIN/$tool" ras.json --space LPS --no-history -o x.json $([ $tool = attach-detect ] && echo "--bone a=none.obj")
        [[ "$output" == *ras.json*'its space, here RAS, not LPS'* ]] || { echo "$tool: $output"; false; }
    done
    "$BIN/root-select" -q ras.json --space RAS --no-history -o a.json
    "$BIN/root-select" -q ras.json --no-history -o b.json
    cmp a.json b.json
    "$BIN/root-select" -q none.json --space LPS -o c.json
    grep -q '"space": "LPS"' c.json
}

@test "--space settles what two headers say, where they are mistaken" {
    run -1 "$BIN/attach-detect" ras.json --bone a=LPS.obj -o x.json
    [[ "$output" == *RAS*LPS*--space* ]]
    "$BIN/attach-detect" --no-history ras.json --bone a=LPS.obj --space RAS -o settled.json 2> err
    grep -q 'warning: LPS.obj: its header says the space LPS; RAS is taken' err
    "$BIN/attach-detect" -q --no-history ras.json --bone a=RAS.obj -o right.json
    cmp settled.json right.json
    # a document that says none is in the space that was told, too
    run -1 "$BIN/attach-detect" none.json --glue ras.json --space LPS -o x.json
    [[ "$output" == *RAS*LPS* ]]
}

@test "fibres, sites and landmarks whose headers say another space than the muscle are refused by every option that reads them" {
    for space in LPS RAS none; do
        for lines in lines.obj lines.vtk; do
            tried=("fiber-flow --from-fibers $space-$lines" "fiber-fill --bend-to $space-$lines" "fiber-fill --ends $space-$lines" "root-select --ends $space-$lines" "fiber-flow --field harmonic --ends $space-$lines")
            for words in "${tried[@]}" "root-select --ends $space.sites" "fiber-flow --field harmonic --ends $space.sites" "attach-detect --method area --bone b=none.obj --landmarks $space.areas.tsv"; do
                code=0
                "$BIN/"$words ras.json -o x.json 2> err || code=$?
                if [ $space = LPS ]; then
                    [ "$code" -eq 1 ] || { echo "$words: $code"; cat err; false; }
                    grep -q "in the space RAS, and \"LPS.*\" in LPS" err || { echo "$words"; cat err; false; }
                else
                    refused=$(grep -c 'space' err || true)
                    [ "$refused" -eq 0 ] || { echo "$words"; cat err; false; }
                fi
            done
        done
    done
}

@test "scenes, pictures, motions and envelopes of bones in two spaces are refused; --space settles them" {
    printf '%s\n' '{"format": "sinew-scene", "version": 1, "rate": 24, "frames": [0, 1], "bones": [{"name": "a", "mesh": "LPS.obj"}, {"name": "b", "mesh": "none.obj"}],' \
        '"contact": true, "muscles": [{"name": "m", "rig": "ras.json"}]}' > s.scene.json
    printf '%s\n' '{"format": "sinew-motion", "version": 1, "joints": [{"name": "j", "type": "pose", "keys": [{"time": 0}, {"time": 1}]}],' \
        '"bones": [{"name": "a", "mesh": "LPS.obj", "joint": "j"}, {"name": "b", "mesh": "RAS.obj", "joint": "j"}]}' > m.motion.json
    sed 's/"mesh": "LPS.obj", "joint"/"mesh": "none.obj", "joint"/' m.motion.json > one.motion.json
    tried=("simulate s.scene.json --log x" "rig-view s.scene.json -o x.png" "rig-view m.motion.json -o x.png" "rig-view ras.json --bone a=LPS.obj -o x.png"
        "scene-build ras.json -b a=LPS.obj -o x.scene.json" "envelope-bind none.obj --bones m.motion.json -o x.envelope.json"
        "envelope-bind LPS.obj --bones one.motion.json -o x.envelope.json")
    for words in "${tried[@]}"; do
        run -1 "$BIN/"$words
        [[ "$output" == *'the space RAS'*LPS* ]] || [[ "$output" == *'the space LPS'*RAS* ]] || { echo "$words: $output"; false; }
        code=0
        "$BIN/"$words --space RAS > out 2> err || code=$?
        [ "$code" -ne 1 ] || { echo "$words"; cat err; false; }
        grep -q 'LPS.obj: its header says the space LPS; RAS is taken' err || { echo "$words"; cat err; false; }
    done
    run -1 "$BIN/simulate" s.scene.json --log x --space LPS # the rig's document says the other
    [[ "$output" == *'"m" is in the space RAS, and --space says LPS'* ]]
}
