# VTK files at the command line, what PLY and VTP keep of a muscle, and admesh as a second opinion on our STL.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    clean="$BIN/mesh-clean"
    vtk="$BATS_TEST_DIRNAME/../data/vtk"
}

# A tetrahedron with every section; the first argument is put before its vertices' end.
muscle() {
    printf '{"format":"sinew-muscle","version":1,"metersPerUnit":1,"mesh":{"vertices":[0,0,0,0.1,0,0,0,0.1,0,0,0,0.1%s],' "$1"
    printf '"triangles":[0,2,1,0,1,3,1,2,3,2,0,3]},"roots":{"vertices":[1,2],"rule":"indices"},'
    printf '"structure":{"samples":[{"position":[0,0,0],"parent":-1,"branch":0,"axis":[0,0,1],"vertices":[0,1]},'
    printf '{"position":[0,0,0.1],"parent":0,"branch":0,"axis":[0,0,1],"vertices":[2,3]}],"spacing":0.1},'
    printf '"fibers":{"directions":[0,0,1,0,0,1,0,0,1,1,0,0%s]},' "${1:+,1,0,0}"
    printf '"attachments":[{"bone":"ulna","method":"pin","vertices":[0]},{"bone":"radius","method":"pin","vertices":[3]}]}\n'
}

member() { sed -n "s/^ *\"$2\": \([-0-9.e]*\),*$/\1/p" "$1" | head -1; } # FILE NAME: the first number of that name

@test "files of VTK itself, of every form, are read alike" {
    "$clean" -q "$vtk/text-42.vtk" -o first.off
    for file in "$vtk"/*; do
        "$clean" -q "$file" -o again.off
        cmp first.off again.off
        "$clean" -q < "$file" -o again.off
        cmp first.off again.off
    done
    "$clean" -q "$vtk/raw-zlib.vtp" -o kept.ply
    grep -aq '^property double painted$' kept.ply
    grep -aq '^property uchar part$' kept.ply
}

@test "what VTK is not read is said in one line" {
    printf '# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n' > grid.vtk
    run -1 --separate-stderr "$clean" grid.vtk
    [[ "$stderr" == *"grid.vtk:4: "*"UNSTRUCTURED_GRID, not POLYDATA"* ]]
    printf '<VTKFile type="ImageData">' > image.vtp
    run -1 --separate-stderr "$clean" image.vtp
    [[ "$stderr" == *"image.vtp:1: "*PolyData*ImageData* ]]
    head -c 400 "$vtk/binary-42.vtk" > cut.vtk
    run -1 --separate-stderr "$clean" cut.vtk
    [[ "$stderr" == *"cut.vtk: byte "* ]]
    run -2 --separate-stderr "$clean" "$vtk/raw.vtp" -o x.vtk
    [[ "$stderr" == *.vtp* ]]
    [ ! -e x.vtk ]
}

@test "a muscle's sections are painted on PLY and VTP" {
    muscle "" > a.json
    "$clean" -q a.json -o a.vtp
    for words in 'Float64" Name="fiber" NumberOfComponents="3"' 'Int32" Name="sample"\|UInt8" Name="sample"' 'Int32" Name="attachment"' \
        'UInt8" Name="root"' 'String" Name="attachment_names" NumberOfTuples="2"'; do
        grep -aq "$words" a.vtp
    done
    "$clean" -q a.json -o a.ply
    for words in 'property double fiber_2' 'property uchar sample' 'property int attachment' 'property uchar root' 'comment attachment 1 radius'; do
        grep -aqx "$words" a.ply
    done
    "$clean" -q a.vtp -o b.vtp # they are painted maps now
    grep -aq 'Name="fiber" NumberOfComponents="3"' b.vtp
    "$clean" -q a.vtp -o c.vtp
    cmp b.vtp c.vtp
}

@test "sections that a new mesh makes stale are not painted" {
    muscle ",5,5,5" > unused.json # a vertex that no triangle uses
    "$clean" -q unused.json -o a.ply
    grep -aq '^element vertex 4$' a.ply
    refute grep -aq 'fiber\|sample\|attachment\|root' a.ply
}

@test "what a format cannot hold is said once" {
    muscle "" > a.json
    "$clean" -q a.json -o a.ply
    for format in obj off stl; do
        "$clean" a.ply -o a.$format 2> err
        [ "$(grep -c 'cannot hold vertex attributes' err)" -eq 1 ]
        "$clean" a.json -o b.$format 2> err # nothing is painted where it would be lost
        refute grep -q 'cannot hold' err
    done
    "$clean" a.ply -o again.vtp 2> err
    refute grep -q 'cannot hold' err
}

@test "admesh counts the same facets, edges and parts, and the same volume" {
    command -v admesh > /dev/null || skip "admesh is not installed"
    "$EXAMPLES/arm/arm" --out sample --triangles 1000
    mesh=$(find . -name biceps.ply | head -1)
    "$clean" -q "$mesh" -o clean.obj
    awk '$1 == "v" { print "v", 1000 * $2, 1000 * $3, 1000 * $4; next } { print }' clean.obj > mm.obj # admesh prints six decimals
    "$clean" -q --units mm mm.obj --report report.json -o a.stl
    admesh a.stl > words
    facets=$(awk '/^Number of facets/ { print $5 }' words)
    [ "$facets" -eq "$(member report.json triangles)" ]
    [ "$((3 * facets / 2))" -eq "$(member report.json edges)" ]
    [ "$(awk '/^Total disconnected facets/ { print $5 }' words)" -eq 0 ]
    [ "$(awk '/^Number of parts/ { print $5 }' words)" -eq "$(member report.json components)" ]
    volume=$(awk '/Volume/ { print $NF }' words)
    awk -v a="$volume" -v b="$(member report.json volume)" 'BEGIN { exit !(a > 0 && (a - b) ^ 2 < (1e-5 * b) ^ 2) }'
}

@test "what single precision would move far from the origin is said with how far, in STL and in caches; doubles and what lies near are not" {
    python3 - << 'END'
import math
def write(name, far):
    with open(name, "w") as out:
        n = 12
        for z in range(n):
            for k in range(n):
                out.write("v %.12g %.12g %.12g\n" % (far + 0.05 * math.cos(2 * math.pi * k / n), 0.05 * math.sin(2 * math.pi * k / n), 0.02 * z))
        out.write("v %.12g 0 0\nv %.12g 0 %.12g\n" % (far, far, 0.02 * (n - 1)))
        f = lambda *t: out.write("f %d %d %d\n" % tuple(i + 1 for i in t))
        for z in range(n - 1):
            for k in range(n):
                a, b = z * n + k, z * n + (k + 1) % n
                f(a, b, a + n), f(b, b + n, a + n)
        for k in range(n):
            f(n * n, (k + 1) % n, k), f(n * n + 1, n * (n - 1) + k, n * (n - 1) + (k + 1) % n)
write("near.obj", 1), write("far.obj", 1e6)
END
    for at in near far; do
        "$BIN/mesh-clean" --units m $at.obj -o $at.muscle.json 2> err
        ! grep -q precision err
        for ending in ply obj off vtp; do "$BIN/mesh-clean" --units m $at.obj -o $at.$ending 2>> err; done
        ! grep -q precision err
        "$BIN/mesh-clean" --units m $at.obj -o $at.stl 2> $at.stl.err
        printf '{"format": "sinew-scene", "version": 1, "rate": 24, "frames": [0, 1], "bones": [], "muscles": [{"name": "m", "rig": "%s.muscle.json"}]}\n' \
            $at > $at.scene.json
        "$BIN/simulate" $at.scene.json -o $at.pc2 --log log 2> $at.pc2.err
    done
    [ "$(grep -c 'warning: STL: single precision moves points by up to 0.0[0-9]*, 0.[0-9]* of their extent' far.stl.err)" -eq 1 ]
    [ "$(grep -c 'warning: far.pc2: single precision moves points by up to 0.0[0-9]*' far.pc2.err)" -eq 1 ]
    ! grep -q precision near.stl.err near.pc2.err
}
