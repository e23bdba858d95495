# sinew.mk: from folders of surfaces and a table of options to rigs. What is rebuilt is counted from what make says it does.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

setup_file() {
    command -v make > /dev/null || skip "make is not there"
    "$EXAMPLES/arm/arm" --out "$BATS_FILE_TMPDIR/arm" --triangles 1000 --dirty
}

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    unset MAKEFLAGS MFLAGS MAKELEVEL
    share=$(cd "$BATS_TEST_DIRNAME/../../share" && pwd)
    mkdir muscles bones
    cp "$BATS_FILE_TMPDIR"/arm/{biceps,brachialis,triceps}.ply muscles
    cp "$BATS_FILE_TMPDIR"/arm/{humerus,radius,scapula,ulna}.ply bones
    printf 'muscle\ttool\toptions\n' > options.tsv
    printf 'SINEW_BIN = %s\nSINEW_BONES = bones\nSINEW_TABLE = options.tsv\nSINEW_PIXELS = 64x48\ninclude %s/make/sinew.mk\n' "$BIN" "$share" > Makefile
}

# the stages that ran, a line each as "NAME: TOOL", sorted
build() { make -j2 "$@" > said 2> complaints || return; stages_run; }
stages_run() { sed 's/^\[[^]]*\] //' said | grep -E ': (mesh-clean|attach-detect|root-select|build-structure|fiber-flow|fiber-fill)$' | sort > ran || true; }
row() { printf '%s\t%s\t%s\n' "$@" >> options.tsv; }
refused() { # WORDS [MAKE ARGUMENT...]: one sentence, no work
    words=$1
    shift
    if make "$@" > said 2> complaints; then echo "was not refused"; return 1; fi
    stages_run
    cat complaints
    [ ! -s ran ] && grep -q "^sinew.mk: .*$words" complaints
}

@test "every muscle becomes a rig, the same as by hand; summary and contact sheet come with it" {
    build
    [ "$(wc -l < ran)" -eq 18 ]
    for name in biceps brachialis triceps; do
        [ -s "rigs/$name.muscle.json" ]
    done
    "$BIN/mesh-clean" muscles/biceps.ply |
        "$BIN/attach-detect" --bone humerus=bones/humerus.ply --bone radius=bones/radius.ply --bone scapula=bones/scapula.ply \
            --bone ulna=bones/ulna.ply | "$BIN/root-select" | "$BIN/build-structure" | "$BIN/fiber-flow" --no-history -o hand.muscle.json
    "$BIN/fiber-flow" rigs/biceps.muscle.json --no-history -o rig.muscle.json
    cmp hand.muscle.json rig.muscle.json
    [ "$(wc -l < rigs/summary.tsv)" -eq 4 ]
    awk -F '\t' 'NR == 1 { n = NF; next } NF != n || $3 != "ok" || !($8 > 100) || !($13 > 3) || !($15 > 0) || $16 < 2 || !($NF > 0) { exit 1 }' rigs/summary.tsv
    [ "$(head -c 4 rigs/sheet-1.png | tail -c 3)" = PNG ]
    [ ! -e rigs/sheet-2.png ]
}

@test "fibres through the volume are for who asks: by the table, or for all" {
    row biceps fiber-fill '--fibers 7'
    build
    [ "$(jq '.fibers.polylines | length' rigs/biceps.muscle.json)" = 7 ]
    [ "$(jq '.fibers.polylines | length' rigs/triceps.muscle.json)" = 0 ]
    build SINEW_FIBERS=5
    [ "$(jq '.fibers.polylines | length' rigs/triceps.muscle.json)" = 5 ]
    [ "$(cat ran)" = "$(printf '%s: fiber-fill\n' biceps brachialis triceps)" ]
}

@test "a second run does nothing, and leaves every file alone" {
    build
    find rigs -type f ! -path '*/state/*' -printf '%p %T@\n' | sort > before
    build
    [ ! -s ran ]
    find rigs -type f ! -path '*/state/*' -printf '%p %T@\n' | sort > after
    diff before after
}

@test "a changed surface rebuilds its muscle, a touched one stops after cleaning" {
    build
    touch muscles/biceps.ply
    build
    [ "$(cat ran)" = "biceps: mesh-clean" ]
    "$BIN/mesh-clean" muscles/biceps.ply --triangles 900 -o muscles/new.ply
    mv muscles/new.ply muscles/biceps.ply
    build
    [ "$(wc -l < ran)" -eq 6 ]
    [ "$(cut -d : -f 1 ran | uniq)" = biceps ]
    build
    [ ! -s ran ]
}

@test "a line of the table rebuilds that muscle from that stage; one that changes no byte stops there" {
    build
    row brachialis build-structure "--prune 0.2"
    build
    [ "$(cat ran)" = "$(printf 'brachialis: %s\n' build-structure fiber-fill fiber-flow)" ]
    row "tric*" root-select -v
    build
    [ "$(cat ran)" = "triceps: root-select" ]
    grep -q "closed ring" rigs/logs/triceps.root-select.log
    build
    [ ! -s ran ]
    sed -i '/prune/d' options.tsv
    build
    [ "$(cat ran)" = "$(printf 'brachialis: %s\n' build-structure fiber-fill fiber-flow)" ]
}

@test "options are quoted as in a shell, and nothing in them is run" {
    row biceps attach-detect "--pin 'my bone=near:0,0,0,3' --pin \"other=\$(touch owned)near:0,0,0\""
    if build; then false; fi
    grep -q '^biceps: attach-detect failed: ' complaints
    [ ! -e owned ]
    sed -i 's/ --pin "other.*//' options.tsv
    build
    grep -q '"my bone"' rigs/biceps.muscle.json
    [ ! -e owned ]
}

@test "a file that options name is a dependency" {
    printf 'ulna2\tulna.ply\n' > bones/more.txt
    row biceps attach-detect "--bones bones/more.txt"
    build
    touch bones/more.txt
    build
    [ "$(cat ran)" = "biceps: attach-detect" ]
}

@test "a changed bone rebuilds from the attachments on; a touched one nothing; a chosen one only who chose it" {
    row biceps bones "scapula rad*"
    build
    refute grep -q '"bone": *"ulna"' rigs/biceps.muscle.json
    touch bones/ulna.ply
    build
    [ ! -s ran ]
    "$BIN/mesh-clean" bones/ulna.ply --triangles 200 -o bones/new.ply
    mv bones/new.ply bones/ulna.ply
    build
    [ "$(cat ran)" = "$(for name in brachialis triceps; do printf "$name: %s\n" attach-detect build-structure fiber-fill fiber-flow root-select; done)" ]
    rm bones/ulna.ply
    build
    [ "$(cat ran)" = "$(for name in brachialis triceps; do printf "$name: %s\n" attach-detect build-structure fiber-fill fiber-flow root-select; done)" ]
}

@test "a broken muscle fails alone, is named, leaves no stale rig, and heals" {
    build
    cp muscles/triceps.ply good.ply
    head -c 300 good.ply > muscles/triceps.ply
    if build; then false; fi
    grep -q '^triceps: mesh-clean failed: .*; log: rigs/logs/triceps.mesh-clean.log$' complaints
    grep -q '1 of 3 failed: triceps (mesh-clean)' said
    [ -s rigs/logs/triceps.mesh-clean.log ]
    [ ! -e rigs/triceps.muscle.json ]
    [ -s rigs/biceps.muscle.json ]
    [ "$(awk -F '\t' '$3 == "failed" { print $1, $4 }' rigs/summary.tsv)" = "triceps mesh-clean" ]
    row biceps build-structure "--prune 0.2" # the others are still built beside it
    if build; then false; fi
    stages_run
    grep -q 'biceps: fiber-fill' ran
    cp good.ply muscles/triceps.ply
    build
    [ "$(wc -l < ran)" -eq 6 ]
    [ -s rigs/triceps.muscle.json ]
}

@test "a stage deleted by hand is made again, and nothing after it where it comes out the same" {
    build
    rm rigs/stages/biceps.roots.json
    build
    [ "$(cat ran)" = "$(printf 'biceps: %s\n' build-structure root-select)" ]
    rm rigs/biceps.muscle.json
    build
    [ "$(cat ran)" = "biceps: fiber-fill" ]
    [ -s rigs/biceps.muscle.json ]
}

@test "names with spaces, brackets, umlauts and worse; every format in one folder" {
    mv muscles/biceps.ply "muscles/m. bíceps (links) Ärmel.ply"
    mv muscles/brachialis.ply 'muscles/$(touch owned) & "b"; #1 %x: y.ply'
    for format in stl obj off; do "$BIN/mesh-clean" muscles/triceps.ply -o "muscles/the $format.$format"; done
    mv muscles/triceps.ply "muscles/it's [one].ply"
    mv bones/ulna.ply "bones/ulna (2) .ply"
    row "m. b*Ärmel" build-structure "--prune 0.2"
    row "it's [one].ply" build-structure "--prune 0.1"
    row "it's *" bones "ulna* scapula"
    build
    [ "$(ls rigs/*.muscle.json | wc -l)" -eq 6 ]
    [ -s rigs/the_obj.muscle.json ]
    [ -s "rigs/m._bíceps_links_Ärmel.muscle.json" ]
    [ -s "rigs/it_s_one.muscle.json" ]
    grep -q -e '--prune 0.2' "rigs/state/options/m._bíceps_links_Ärmel.build-structure"
    [ ! -e owned ]
    build
    [ ! -s ran ]
    touch "muscles/it's [one].ply"
    build
    [ "$(cat ran)" = "it_s_one: mesh-clean" ]
}

@test "surfaces by pattern and by list, with names; a moved file is a new one" {
    mkdir mixed
    cp muscles/* bones/* mixed
    build SINEW_SURFACES='mixed/b*.ply'
    [ "$(ls rigs/*.muscle.json | wc -l)" -eq 2 ]
    printf '# chosen\nmixed/triceps.ply\nlong head\tmixed/biceps.ply\n' > list.txt
    build SINEW_SURFACES=list.txt SINEW_OUT=other
    [ "$(ls other/*.muscle.json)" = "$(printf 'other/%s.muscle.json\n' long_head triceps)" ]
    mv mixed/biceps.ply elsewhere.ply
    sed -i 's,mixed/biceps.ply,elsewhere.ply,' list.txt
    build SINEW_SURFACES=list.txt SINEW_OUT=other
    [ "$(cat ran)" = "long_head: mesh-clean" ]
}

@test "without bones the rigs have no attachments" {
    build SINEW_BONES=
    [ -s rigs/biceps.muscle.json ]
    cmp rigs/biceps.muscle.json rigs/stages/biceps.fibers.json
}

@test "what cannot be dealt with is refused in one sentence" {
    cp muscles/biceps.ply "muscles/biceps .ply"
    refused "would both be called 'biceps'; rename one"
    rm "muscles/biceps .ply"
    refused "SINEW_SURFACES = 'nowhere': no surface there" SINEW_SURFACES=nowhere
    refused "SINEW_BONES = 'nowhere/\*.stl': no surface there" SINEW_BONES='nowhere/*.stl'
    refused "SINEW_TABLE = 'none.tsv': no such file" SINEW_TABLE=none.tsv
    refused "letters, digits" SINEW_OUT='my rigs'
    refused "no mesh-clean in /nowhere" SINEW_BIN=/nowhere
    printf 'bicepss\tbuild-structure\t--prune 0.1\n' > t.tsv
    refused "t.tsv:1: there is no muscle 'bicepss'" SINEW_TABLE=t.tsv
    printf 'biceps\tbuild-strukture\t--prune 0.1\n' > t.tsv
    refused "t.tsv:1: 'build-strukture' is none of" SINEW_TABLE=t.tsv
    printf '\nbiceps build-structure --prune 0.1\n' > t.tsv
    refused "t.tsv:2: a line needs a muscle, a tool and options" SINEW_TABLE=t.tsv
    printf 'biceps\tbones\thumeri\n' > t.tsv
    refused "t.tsv:1: there is no bone 'humeri'" SINEW_TABLE=t.tsv
    printf 'biceps\tmesh-clean\t-o x.ply\n' > t.tsv
    refused "given by sinew.mk" SINEW_TABLE=t.tsv
    newline=$(printf 'muscles/a\nb.ply')
    cp muscles/biceps.ply "$newline"
    refused "a tab or a line end"
}

@test "lint: a line of counts for every surface, a sheet of the defective ones, and an exit status" {
    make lint > said
    grep -q '^0 of 7 surfaces have defects' said
    cp "$BATS_FILE_TMPDIR/arm/biceps-dirty.obj" "muscles/biceps (dirty).obj"
    echo nonsense > muscles/empty.stl
    if make lint > said 2> complaints; then false; fi
    grep -q '^2 of 9 surfaces have defects, 1 of them cannot be read' said
    awk -F '\t' 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; n = NF; next }
        NF != n { exit 1 }
        $2 == "biceps_dirty" { if ($4 != "defective" || $at["boundaryEdges"] != 24 || $at["components"] != 3) exit 1; seen++ }
        $2 == "empty" { if ($4 != "unreadable" || $5 == "") exit 1; seen++ }
        $2 == "humerus" { if ($4 != "sound" || $1 != "bone" || $at["genus"] != 0) exit 1; seen++ }
        END { exit seen != 3 }' rigs/lint.tsv
    [ "$(head -c 4 rigs/lint-1.png | tail -c 3)" = PNG ]
    if make lint > said 2>&1; then false; fi
    touch before
    if make lint > said 2>&1; then false; fi
    [ -z "$(find rigs/state/lint rigs/lint-1.png rigs/lint.tsv -newer before)" ]
}

@test "pages of the contact sheet follow the rigs" {
    build SINEW_PAGE=2
    [ -s rigs/sheet-2.png ]
    [ ! -e rigs/sheet-3.png ]
    touch -d '1 hour ago' rigs/*.png rigs/*.json
    row triceps build-structure "--prune 0.2"
    touch before
    build SINEW_PAGE=2
    [ -z "$(find rigs/sheet-1.png -newer before)" ]
    [ -n "$(find rigs/sheet-2.png -newer before)" ]
    build
    [ ! -e rigs/sheet-2.png ]
}

@test "rigs say their units themselves: those of the surfaces are not asked of the sheet" {
    row biceps mesh-clean '--units mm'
    make SINEW_BONES= SINEW_UNITS=cm SINEW_UP=y > said 2> complaints
    refute grep -q 'no picture' complaints
    [ "$(head -c 4 rigs/sheet-1.png | tail -c 3)" = PNG ]
}

@test "the example builds" {
    ARM=$EXAMPLES/arm/arm TOOLS=$BIN sh "$share/examples/assets/generate.sh" x
    cd x
    make -j2 -f "$share/examples/assets/Makefile" SINEW_BIN="$BIN" SINEW_PIXELS=64x48 > said
    grep -q '^11 rigs; see rigs/summary.tsv$' said
    refute grep -q '"bone": *"humerus"' rigs/biceps_fine.muscle.json
}

@test "its shell is clean" {
    command -v shellcheck > /dev/null || skip "shellcheck is not installed"
    shellcheck "$share/make/assets" "$share/examples/assets/generate.sh"
}

@test "what make says in the end tells of rigs on no bone and on one bone alone" {
    row triceps bones radius
    row triceps attach-detect '--method contact'
    row biceps bones radius
    build
    tail -n 1 said
    [ "$(tail -n 1 said)" = "3 rigs, 1 of them short of what was asked, 1 on no bone, 1 on one bone alone; see rigs/summary.tsv" ]
    [ "$(awk -F '\t' '$1 == "triceps" { print $3, $4, $15, $16 }' rigs/summary.tsv)" = "short attach-detect 0 0" ]
    awk -F '\t' '$1 == "triceps" { print $5 }' rigs/summary.tsv | grep -q 'nothing attached; the nearest bone, radius, is'
    grep -q '^triceps: attach-detect fell short: .*nothing attached' complaints
    printf 'muscle\ttool\toptions\n' > options.tsv
    make -s SINEW_BONES= > said 2>&1
    [ "$(tail -n 1 said)" = "3 rigs; see rigs/summary.tsv" ]
}

# the rigs whose candidates were sought
candidates() { make -j2 candidates > said 2> complaints; status=$?; sed 's/^\[[^]]*\] //' said | grep -E ': candidates$' | sed 's/: .*//' | sort | tr '\n' ' ' > ran; return $status; }

@test "candidates for external constraints: in one more target, again only where a mesh near by has changed" {
    row '*' candidates '--reach 8mm'
    candidates
    [ "$(cat ran)" = "biceps brachialis triceps " ]
    grep -Eq '^[1-9][0-9]* rows of 3 rigs.*; see rigs/candidates.tsv' said
    for name in biceps brachialis; do grep -q '"externals"' rigs/candidates/$name.muscle.json; done
    refute grep -q '"externals"' rigs/biceps.muscle.json
    "$BIN/attach-detect" -q --muscles rigs --obstacles bones --reach 8mm --no-history rigs/biceps.muscle.json -o hand.json
    cmp <(grep '"target"' hand.json) <(grep '"target"' rigs/candidates/biceps.muscle.json)
    awk -F '\t' 'NR == 1 { n = NF; next } NF != n || $2 != "ok" || !($4 > 100) { exit 1 }' rigs/candidates.tsv
    candidates
    [ ! -s ran ]
    touch muscles/biceps.ply
    candidates
    [ ! -s ran ]
    row brachialis attach-detect '--distance 4mm' # its attachments are nothing to the others
    candidates
    [ "$(cat ran)" = "brachialis " ]
    row triceps candidates '--targets 1'
    candidates
    [ "$(cat ran)" = "triceps " ]
}

@test "candidates: a rig that fails has none, and is no neighbour of others" {
    row '*' candidates '--reach 8mm'
    candidates
    grep -q '"target": "brachialis"' rigs/candidates/biceps.muscle.json
    head -c 300 muscles/brachialis.ply > cut && mv cut muscles/brachialis.ply
    refute candidates
    [ ! -e rigs/candidates/brachialis.muscle.json ]
    grep -q 'biceps' ran
    refute grep -q '"target": "brachialis"' rigs/candidates/biceps.muscle.json
    grep -q '1 of 3 failed: brachialis' said
    row biceps candidates '--weights painted'
    refute candidates
    grep -q 'biceps: candidates failed: .*none of the painted maps' complaints
    [ ! -e rigs/candidates/biceps.muscle.json ]
}

@test "two makes in one folder: the second says so, waits, and finds everything done" {
    make -j2 > first 2>&1 &
    one=$!
    until [ -e rigs/stages/biceps.clean.json ]; do kill -0 $one && sleep 0.05; done
    make -j2 > said 2> complaints
    grep -q '^sinew.mk: another make (process [0-9]* on .*) works in rigs; waiting' complaints
    [ "$(wc -l < complaints)" -eq 1 ]
    refute kill -0 $one 2> dead # it was over when the second began
    wait $one
    stages_run
    [ ! -s ran ]
    [ "$(tail -n 1 first)" = "3 rigs; see rigs/summary.tsv" ]
    [ "$(tail -n 1 said)" = "3 rigs; see rigs/summary.tsv" ]
}

@test "the lock of a make that was killed, or of what is no make, is nobody's" {
    mkdir -p rigs/state
    sh -c 'exit 0' &
    wait $!
    ln -s "$!@$(uname -n)" rigs/state/lock
    build
    [ ! -s complaints ]
    ln -sfn "$$@$(uname -n)" rigs/state/lock
    build
    [ ! -s complaints ]
    ln -sfn "1@elsewhere" rigs/state/lock # of another machine nothing is known
    make > said 2> complaints &
    one=$!
    until grep -q 'process 1 on elsewhere' complaints; do kill -0 $one && sleep 0.05; done
    rm rigs/state/lock
    wait $one
}

@test "a make that a rule calls works in the folder that its caller has locked" {
    printf 'all: rigs\n\t@$(MAKE) --no-print-directory summary\n.DEFAULT_GOAL := all\n' >> Makefile
    timeout 300 make -j2 > said 2> complaints # against hanging
    [ ! -s complaints ]
    [ "$(tail -n 1 said)" = "3 rigs; see rigs/summary.tsv" ]
}

@test "how far it is: each line counts what is done of what there is to do" {
    make > said 2> complaints
    [ "$(grep -c '^\[[0-9]* of 18 done, [0-9]* %\] ' said)" -eq 18 ]
    grep '^\[' said | sed 's/^\[\([0-9]*\) of 18 done, \([0-9]*\) %.*/\1 \2/' | awk '{ if ($1 != NR - 1 || $2 != int(100 * $1 / 18)) exit 1 }'
    row brachialis build-structure "--prune 0.2"
    make > said 2> complaints
    [ "$(grep -c '^\[[0-2] of 3 done, ' said)" -eq 3 ]
    touch muscles/biceps.ply # cleaned, and nothing after it
    make > said 2> complaints
    [ "$(grep '^\[' said)" = "[0 of 6 done, 0 %] biceps: mesh-clean" ]
    make lint > said 2> complaints
    [ "$(grep -c '^\[[0-6] of 7 done, ' said)" -eq 7 ]
    make lint > said 2> complaints
    refute grep -q '^\[' said
    rm rigs/biceps.muscle.json
    make rigs/biceps.muscle.json > said
    [ "$(cat said)" = "biceps: fiber-fill" ]
}

@test "messages name the files as their user does, not the links and documents that make works on" {
    head -c 300 muscles/triceps.ply > "muscles/m. triceps (left).ply"
    rm muscles/triceps.ply
    head -c 200 bones/ulna.ply > cut
    mv cut "bones/ulna (2).ply"
    row biceps bones 'ulna?(2)'
    row brachialis root-select '--indices 999999'
    row brachialis bones humerus
    if make -k -j2 > said 2> complaints; then false; fi
    cat complaints
    grep -q '^m._triceps_left: mesh-clean failed: muscles/m. triceps (left).ply:' complaints
    grep -q '^biceps: attach-detect failed: bones/ulna (2).ply:' complaints
    grep -q '^brachialis: root-select failed: ' complaints
    refute grep -E 'failed: .*rigs/(state|stages)/.*; log' complaints
    cut -f 5 rigs/summary.tsv > told
    refute grep 'rigs/st' told
    refute grep -h 'rigs/st' rigs/logs/*.log
}

@test "everything that is wrong with the table is said at once" {
    {
        printf 'bicepss\tbuild-structure\t--prune 0.1\n'
        printf 'biceps\tbuild-strukture\t--prune 0.1\n'
        printf 'biceps build-structure\n'
        printf '*\tbones\thumeri scapula\n'
        printf 'biceps\tmesh-clean\t-o x.ply\n'
    } > t.tsv
    refused "t.tsv:1: there is no muscle" SINEW_TABLE=t.tsv
    [ "$(grep -c '^sinew.mk: t.tsv:' complaints)" -eq 5 ] # the bone is missed once, not for every muscle
    for line in 1 2 3 4 5; do grep -q "^sinew.mk: t.tsv:$line: " complaints; done
}

@test "a page's title tells which rigs are on it, and is drawn anew where that changes" {
    build SINEW_PAGE=2
    [ "$(cat rigs/state/sheet.page-1.title)" = "Rigs 1 to 2 of 3, page 1 of 2" ]
    [ "$(cat rigs/state/sheet.page-2.title)" = "Rigs 3 to 3 of 3, page 2 of 2" ]
    cp muscles/triceps.ply muscles/zygomaticus.ply
    cp muscles/triceps.ply muscles/zz.ply
    touch -d '1 hour ago' rigs/*.png rigs/*.json
    touch before
    build SINEW_PAGE=2
    [ "$(cat rigs/state/sheet.page-1.title)" = "Rigs 1 to 2 of 5, page 1 of 3" ]
    [ -n "$(find rigs/sheet-1.png -newer before)" ] # the same rigs, but another count
    [ -s rigs/sheet-3.png ]
    rm muscles/z*.ply
    build
    [ "$(cat rigs/state/sheet.page-1.title)" = "Rigs: 3" ]
    [ ! -e rigs/sheet-2.png ]
    [ ! -e rigs/state/sheet.page-2.title ]
    refused "SINEW_PAGE = '0': a whole number" SINEW_PAGE=0
    refused "SINEW_PAGE = 'ten'" SINEW_PAGE=ten
}

@test "more than a hundred rigs: every one is on a page, in order" {
    mkdir many
    printf 'OFF\n4 4 6\n0 0 0\n.1 0 0\n0 .1 0\n0 0 .1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n' > many/m000.off
    for i in $(seq 101 229); do ln many/m000.off many/m$i.off; done
    # no tool runs: 130 documents are laid where the stages would leave theirs
    make -s SINEW_SURFACES=many SINEW_BONES= -n summary > said 2> complaints
    for i in 000 $(seq 101 229); do cp many/m000.off rigs/m$i.muscle.json; done
    for name in SURFACES=many BONES= TABLE= UNITS= UP= BONE_UNITS= BONE_UP= OUT=rigs BIN="$BIN" THREADS=1 PAGE=100 PIXELS=20x16 LINT=; do
        export "SINEW_$name"
    done
    sh "$share/make/assets" sheets rigs > said 2> complaints
    [ ! -s complaints ]
    [ "$(wc -l < rigs/state/sheet.page-1)" -eq 100 ]
    [ "$(wc -l < rigs/state/sheet.page-2)" -eq 30 ]
    cat rigs/state/sheet.page-1 rigs/state/sheet.page-2 | sort -c
    [ "$(cat rigs/state/sheet.page-2.title)" = "Rigs 101 to 130 of 130, page 2 of 2" ]
    [ -s rigs/sheet-2.png ]
    [ ! -e rigs/sheet-3.png ]
}

# the rigs whose fibres were made
architecture() { make -j2 architecture > said 2> complaints; status=$?; sed 's/^\[[^]]*\] //' said | grep -E ': architecture$' | sed 's/: .*//' | sort | tr '\n' ' ' > ran; return $status; }
cell() { awk -F '\t' -v name="$1" -v column="$2" 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == column) c = i } $1 == name { print $c }' rigs/architecture.tsv; }

@test "architecture: fibres through every rig in one more target, again only where a rig or its options have changed" {
    row '*' architecture '-n 12'
    architecture
    [ "$(cat ran)" = "biceps brachialis triceps " ]
    grep -Eq '^fibres of 3 rigs.*; see rigs/architecture.tsv' said
    [ "$(wc -l < rigs/architecture.tsv)" -eq 4 ]
    awk -F '\t' 'NR == 1 { n = NF; next } NF != n || $2 != "ok" || $7 != 12 || !($8 > 0.05) || !($6 > 1e-6) || !($14 > 0) { exit 1 }' rigs/architecture.tsv
    "$BIN/fiber-fill" -q -n 12 --report hand.json --no-history rigs/biceps.muscle.json -o hand.muscle.json
    grep -q "\"lengthMean\": $(cell biceps lengthMean)," hand.json
    grep -q "\"physiologicalArea\": $(cell biceps physiologicalArea)," hand.json
    cmp <(sed -n '/"polylines"/,/^ *"attachments"/p' hand.muscle.json) <(sed -n '/"polylines"/,/^ *"attachments"/p' rigs/architecture/biceps.muscle.json)
    architecture
    [ ! -s ran ]
    touch muscles/biceps.ply
    architecture
    [ ! -s ran ]
    row triceps architecture '--tendon 0,50%'
    architecture
    [ "$(cat ran)" = "triceps " ]
    awk -v share="$(cell triceps tendonLengthShare)" 'BEGIN { exit !(share > 0.49 && share < 0.51) }'
    [ "$(cell triceps tendon)" = given ]
    row brachialis build-structure '--prune 0.2'
    architecture
    [[ "$(cat ran)" != *biceps* ]]
}

@test "architecture: a rig that fails has no line of figures, and takes what it left before with it" {
    row '*' architecture '-n 4'
    architecture
    head -c 300 muscles/brachialis.ply > cut && mv cut muscles/brachialis.ply
    row biceps architecture '--tendon painted'
    refute architecture
    grep -q 'biceps: architecture failed: .*no painted map "tendon"' complaints
    for name in biceps brachialis; do [ ! -e rigs/architecture/$name.muscle.json ]; done
    grep -q '2 of 3 failed: biceps, brachialis' said
    [ "$(cell brachialis message)" = "there is no rig" ]
    [ "$(cell biceps lengthMean)" = "" ]
}
