#!/bin/sh
# Twelve muscles of the dog's left hind leg on its own joints, beside all of its bones: motion, rigs and a scene in OUT, for contact.
# Usage: hind-leg.sh TOOLS DOG OUT [HIP [KNEE]]: the folder of the tools, that of dog.xml and its meshes, degrees (25, -30).
# shellcheck disable=SC2034
set -eu
here=$(cd "$(dirname "$0")" && pwd)
scene=hind-leg motion=hip first=hip_L_extend by=25 second=knee_L and_by=-30
bones="Pelvis Femoris_L Femoris_fabellae_L_1 Femoris_fabellae_L_2 Fibula_L Patella_L Tibia_L Calcaneal_tuber_L Tibial_tarsal_L"
muscles="m.gluteus_medius m.gluteus_profundus_minor m.gluteus_superficialis_major m.iliacus m.pectineus m.adductor_magnus m_biceps_femoris
    m.semimembranosus m.semitendinosus m.rectus_femoris m.vastus_lat m.gracilis"
. "$here/leg.sh"
