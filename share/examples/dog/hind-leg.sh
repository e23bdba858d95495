#!/bin/sh
# Twelve muscles of the dog's left hind leg on its own joints, beside all of its bones: motion, rigs and a scene in OUT, for contact.
# Usage: hind-leg.sh TOOLS DOG OUT [HIP [KNEE]]: the folder of the tools, that of dog.xml and its meshes, degrees (25, -30).
set -eu
tools=$(cd "$1" && pwd) dog=$(cd "$2" && pwd) out=$3 hip=${4:-25} knee=${5:--30} here=$(cd "$(dirname "$0")" && pwd)
PATH=$tools:$PATH
mkdir -p "$out/rigs" "$out/near"
cd "$out"
awk -f "$here/hip.awk" -v hip="$hip" -v knee="$knee" > hip.sto
motion-import -q hip.sto --skeleton "$dog/dog.xml" --bones bones --bone-path "$dog/meshes" -o hip.motion.json
for bone in Pelvis Femoris_L Femoris_fabellae_L_1 Femoris_fabellae_L_2 Fibula_L Patella_L Tibia_L Calcaneal_tuber_L Tibial_tarsal_L; do
    ln -sf "../bones/$bone.ply" near/
done
for muscle in m.gluteus_medius m.gluteus_profundus_minor m.gluteus_superficialis_major m.iliacus m.pectineus m.adductor_magnus \
    m_biceps_femoris m.semimembranosus m.semitendinosus m.rectus_femoris m.vastus_lat m.gracilis; do
    name=${muscle#m[._]}
    mesh-clean -q --units m "$dog/meshes/MUSC${muscle}_L.stl" | root-select -q | build-structure -q | fiber-flow -q |
        attach-detect -q --bones near -o "rigs/$name.muscle.json"
done
scene-build -q rigs --motion hip.motion.json -o hind-leg.scene.json
