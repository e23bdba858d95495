# Mesh files at the command line: every format from files, pipes and stdin; what is broken is refused in one line, and nothing is written.

bats_require_minimum_version 1.5.0

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    clean="$BIN/mesh-clean"
    # an octahedron of 20 cm; quads and negative numbers would not change what is read
    printf 'v .1 0 0\nv -.1 0 0\nv 0 .1 0\nv 0 -.1 0\nv 0 0 .1\nv 0 0 -.1\n' > eight.obj
    printf 'f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n' >> eight.obj
}

# Run with a status of 1, exactly one line on stderr that matches $1, and neither stdout nor the output file.
refused() {
    local pattern=$1 code=0
    shift
    rm -f refused.ply
    "$@" -o refused.ply > out 2> err || code=$?
    [ "$code" -eq 1 ] || { echo "status $code: $*"; return 1; }
    [ ! -s out ] || { echo "stdout is not empty: $*"; return 1; }
    [ ! -e refused.ply ] || { echo "there is an output: $*"; return 1; }
    [ "$(wc -l < err)" -eq 1 ] || { cat err; return 1; }
    grep -Eq "^mesh-clean: $pattern" err || { cat err; return 1; }
}

@test "the same surface comes out of every format the same" {
    "$clean" eight.obj -o first.ply
    for format in off stl obj ply vtp; do
        "$clean" eight.obj -o eight.$format.$format
        "$clean" eight.$format.$format -o again.ply
        if [ $format = stl ]; then # single precision, vertices in order of appearance
            "$clean" again.ply -o again.stl
            cmp again.stl eight.stl.stl
        else
            cmp first.ply again.ply
        fi
    done
}

@test "the format is found from content: stdin, pipes and wrong extensions" {
    for format in off stl obj ply vtp; do
        "$clean" eight.obj -o a.$format
        "$clean" a.$format -o expected.ply
        "$clean" -o stdin.ply < a.$format
        cmp expected.ply stdin.ply
        cat a.$format | "$clean" - -o pipe.ply
        cmp expected.ply pipe.ply
        cp a.$format misnamed.obj
        "$clean" misnamed.obj -o renamed.ply
        cmp expected.ply renamed.ply
        mkfifo named.$format
        cat a.$format > named.$format &
        "$clean" named.$format -o fifo.result.ply
        cmp expected.ply fifo.result.ply
    done
}

@test "broken text names its line" {
    sed 's/^f 1 3 5/f 1 3 7/' eight.obj > wrong.obj
    refused 'wrong.obj:7: .*vertex 7' "$clean" wrong.obj
    sed '2s/-.1/nan/' eight.obj > nan.obj
    refused 'nan.obj:.* vertex 1 ' "$clean" nan.obj
    sed '3s/.1/x/' eight.obj > word.obj
    refused 'word.obj:3: ' "$clean" word.obj
    refused '<stdin>:3: ' "$clean" - < word.obj
    printf 'OFF\n4000000000 1 0\n0 0 0\n' > false.off
    refused 'false.off:3: .*promises' "$clean" false.off
}

@test "broken binary names its byte" {
    "$clean" eight.obj -o eight.ply
    "$clean" eight.obj -o eight.stl
    head -c -5 eight.ply > short.ply
    refused 'short.ply: .*' "$clean" short.ply
    head -c -5 eight.stl > short.stl
    refused 'short.stl: byte 80: .*promises 8 triangles' "$clean" short.stl
    { head -c 84 eight.stl; head -c 400 /dev/zero | tr '\0' '\377'; } > nan.stl
    refused 'nan.stl: .*vertex 0 ' "$clean" nan.stl
}

@test "no mesh at all is said in so many words" {
    : > empty.obj
    refused 'empty.obj: is empty' "$clean" empty.obj
    refused '<stdin>: is empty' "$clean" < /dev/null
    grep '^v' eight.obj > points.obj
    refused 'points.obj: has no faces' "$clean" points.obj
    printf 'hello\n' > hello.txt
    refused 'hello.txt: .*OBJ, PLY, STL' "$clean" hello.txt
    refused 'none.obj: .*No such file' "$clean" none.obj
    refused '\.: .*directory' "$clean" .
    head -c 3000 "$clean" > noise.stl # any bytes
    refused 'noise.stl: ' "$clean" noise.stl
}

@test "a failure leaves the old output alone, and no other file" {
    printf 'old' > kept.ply
    printf 'v 0 0 0\n' > points.obj
    run -1 "$clean" points.obj -o kept.ply
    [ "$(cat kept.ply)" = old ]
    [ "$(ls -A | sort | tr '\n' ' ')" = "eight.obj kept.ply points.obj " ]
}

@test "an output keeps the mode of the file it replaces" {
    "$clean" eight.obj -o mode.ply
    chmod 604 mode.ply
    "$clean" eight.obj -o mode.ply
    [ "$(stat -c %a mode.ply)" = 604 ]
}

@test "a full disk is an error" {
    ln -s /dev/full full.ply
    run -1 "$clean" eight.obj -o full.ply
    [ -L full.ply ]
    run -1 sh -c "'$clean' eight.obj > /dev/full"
    run -1 "$clean" eight.obj -o no/such/folder/x.ply
    [[ "$output" == *no/such/folder/x.ply* ]]
}

@test "attributes and groups of real files pass through" {
    printf 'ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n' > tetra.ply
    printf 'property float painted\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n' >> tetra.ply
    printf '0 0 0 1 .5\n1 0 0 2 .25\n0 1 0 3 1\n0 0 1 255 0\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n' >> tetra.ply
    "$clean" tetra.ply -o kept.ply
    grep -aq '^property uchar red' kept.ply
    grep -aq '^property double painted' kept.ply
}

@test "a coordinate of Windows is not a finite number, with its line, in every text format" {
    sed '2s/-.1/-1.#IND/' eight.obj > nan.obj
    refused 'nan.obj:2: .*not a finite number' "$clean" nan.obj
    "$clean" -q --repair-nonfinite --repair full nan.obj -o cleaned.ply
    "$clean" -q eight.obj -o plain.ply
    [ "$(grep -ac 'element vertex 5' cleaned.ply)" -eq 1 ] # the five that are left
}

@test "texts are read packed by gzip, with a byte order mark and other line ends, and not as UTF-16" {
    for format in obj off ply; do
        [ $format = obj ] || "$clean" -q eight.obj -o eight.$format
        "$clean" -q eight.$format -o plain.ply
        gzip -c eight.$format > packed.$format.gz
        "$clean" -q packed.$format.gz -o again.ply
        cmp plain.ply again.ply
    done
    { printf '\xef\xbb\xbf'; sed 's/$/\r/' eight.obj; } > marked.obj
    "$clean" -q marked.obj -o again.ply
    "$clean" -q eight.obj -o plain.ply
    cmp plain.ply again.ply
    iconv -f UTF-8 -t UTF-16 eight.obj > wide.obj
    refused 'wide.obj: .*UTF-16' "$clean" wide.obj
    gzip -c eight.obj | head -c 60 > short.obj.gz
    refused 'short.obj.gz: cannot be unpacked' "$clean" short.obj.gz
}

@test "a header that counts less than the file holds is refused with both counts" {
    "$clean" -q eight.obj -o eight.stl
    { head -c 80 eight.stl; printf '\4\0\0\0'; tail -c +85 eight.stl; } > four.stl
    refused 'four.stl: byte [0-9]*: the header counts 4 triangles, but the file has room for 8' "$clean" four.stl
    cat eight.stl eight.stl > two.stl
    refused 'two.stl: .*counts 8 triangles' "$clean" two.stl
    "$clean" -q eight.obj -o eight.off
    cat eight.off eight.off > two.off
    refused 'two.off:.*counts 8 faces, but [0-9]* more lines' "$clean" two.off
    "$clean" -q eight.obj -o eight.ply
    cat eight.ply eight.ply > two.ply
    refused 'two.ply: .*counts 8 faces, but [0-9]* more bytes' "$clean" two.ply
}

@test "devices are refused at once by every tool, as inputs and as standard input; pipes and FIFOs are read" {
    printf 'OFF\n4 4 6\n0 0 0\n.1 0 0\n0 .1 0\n0 0 .1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n' > tetra.off
    for tool in mesh-clean root-select build-structure fiber-flow fiber-fill attach-detect simulate error-time rig-view motion-import scene-build; do
        more=""
        case $tool in attach-detect) more="--bone a=tetra.off" ;; rig-view) more="-o x.png" ;; esac
        for device in /dev/zero /dev/urandom /dev/full; do
            run -1 timeout 20 "$BIN/$tool" $device $more
            [[ "$output" == *"$device: is a device, which may not end; name a file" ]] || { echo "$tool $device: $output"; false; }
            [ "${#lines[@]}" -eq 1 ]
        done
    done
    run -1 bash -c "timeout 20 '$BIN/mesh-clean' < /dev/zero"
    [[ "$output" == *'<stdin>: is a device'* ]]
    run -1 timeout 20 "$BIN/attach-detect" tetra.off --bone a=/dev/zero
    run -1 timeout 20 "$BIN/fiber-flow" tetra.off --from-fibers /dev/zero
    run -1 "$BIN/mesh-clean" /dev/null
    [[ "$output" == *'is empty'* ]]
    "$BIN/mesh-clean" -q --no-history tetra.off -o a.json
    cat tetra.off | "$BIN/mesh-clean" -q --no-history > b.json
    "$BIN/mesh-clean" -q --no-history <(cat tetra.off) > c.json
    mkfifo pipe
    cat tetra.off > pipe &
    "$BIN/mesh-clean" -q --no-history pipe > d.json
    for file in b c d; do diff <(grep -v '"name"' a.json) <(grep -v '"name"' $file.json); done
}
