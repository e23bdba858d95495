#!/bin/sh
# Soleus, tibialis anterior and peroneus longus of a left leg (leg-vhf) beside tibia, fibula and a foot of seven bones that turns as one body
# about the ankle: rigs, a motion and a scene in OUT, for contact. The ankle goes to DOWN degrees (toes down) in 1 s, to UP in another 1.5 s,
# and stays for 0.5 s. The lowest END mm of each muscle move with the foot; the uppermost ORIGIN mm stand. All between is free.
# Usage: ankle.sh TOOLS LEG OUT [END [ORIGIN [DOWN [UP]]]]: the folder of the tools, that of the leg's meshes, mm (3, 30), degrees (-30, 20).
set -eu
tools=$(cd "$1" && pwd) leg=$(cd "$2" && pwd)/VHF_Left out=$3 end=${4:-3} origin=${5:-30} down=${6:--30} up=${7:-20}
PATH=$tools:$PATH
mkdir -p "$out/rigs"
cd "$out"

plus() { echo "$1 $2" | awk '{ print $1 + $2 }'; }

# rig NAME SURFACE LOWEST HIGHEST BONE: heights of the surface in mm; the bone above it
rig() {
    mesh-clean -q --units mm "${leg}_Muscle_$2_smooth.ply" |
        attach-detect -q --pin "$5=half:0,0,$(plus "$4" "-$origin"),0,0,1" --pin "talus=half:0,0,$(plus "$3" "$end"),0,0,-1" |
        root-select -q | build-structure -q | fiber-flow -q -o "rigs/$1.muscle.json"
}
rig soleus Soleus 190.145 471.702 tibia
rig tibialis-anterior TibialisAnterior 211.415 456.263 tibia
rig peroneus-longus PeroneusLongus 152.104 469.402 fibula

cat > ankle.motion.json <<END
{"format": "sinew-motion", "version": 1, "metersPerUnit": 0.001, "rate": 24,
 "joints": [{"name": "ankle", "type": "hinge", "point": [510.8, 425.2, 143.2], "axis": [1, 0, 0],
   "keys": [[0, 0], [1, $down], [2.5, $up], [3, $up]], "interpolation": "smooth"}]}
END
set --
for bone in talus=Talus calcaneus=Calcaneous navicular=Navicular cuboid=Cuboid medial-cuneiform=MedialCuneiform \
    intermediate-cuneiform=IntermediateCuneiform lateral-cuneiform=LateralCuneiform; do
    set -- "$@" -b "${bone%=*}=${leg}_Bone_${bone#*=}_smooth.ply" --bind "${bone%=*}=ankle"
done
scene-build -q rigs --motion ankle.motion.json --units mm -b "tibia=${leg}_Bone_Tibia_smooth.ply" -b "fibula=${leg}_Bone_Fibula_smooth.ply" \
    "$@" -o ankle.scene.json
