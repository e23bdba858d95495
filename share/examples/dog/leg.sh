# For hind-leg.sh and fore-leg.sh, which say which leg: rigs of its muscles, a motion of two of its joints, and a scene. Usage: TOOLS DOG OUT
# [DEGREES [DEGREES]]. They set scene, motion, first, second, by, and_by, bones and muscles.
tools=$(cd "$1" && pwd) dog=$(cd "$2" && pwd) out=$3 by=${4:-$by} and_by=${5:-$and_by}
PATH=$tools:$PATH
mkdir -p "$out/rigs" "$out/near"
cd "$out"
awk -f "$here/bend.awk" -v first="$first" -v by="$by" -v second="$second" -v and_by="$and_by" > "$motion.sto"
motion-import -q "$motion.sto" --skeleton "$dog/dog.xml" --bones bones --bone-path "$dog/meshes" -o "$motion.motion.json"
for bone in $bones; do
    ln -sf "../bones/$bone.ply" near/
done
for muscle in $muscles; do
    name=${muscle#m[._]}
    mesh-clean -q --units m "$dog/meshes/MUSC${muscle}_L.stl" | attach-detect -q --bones near |
        root-select -q | build-structure -q | fiber-flow -q -o "rigs/$name.muscle.json"
done
scene-build -q rigs --motion "$motion.motion.json" -o "$scene.scene.json"
