#!/bin/sh
# Twelve muscles of the dog's left fore leg on its own joints, beside its bones: motion, rigs and a scene in OUT.
# Usage: fore-leg.sh TOOLS DOG OUT [SHOULDER [ELBOW]]: the folder of the tools, that of dog.xml and its meshes, degrees (25, -30).
# shellcheck disable=SC2034
set -eu
here=$(cd "$(dirname "$0")" && pwd)
scene=fore-leg motion=shoulder first=shoulder_L_extend by=25 second=elbow_L and_by=-30
bones="Scapula_L humerus_L Radius_L Ulna_L Carpal_L"
muscles="m.supraspinatus m.infraspinatus m.subscapularis m.teres_major m.deltoideus_scapularis m.deltoideus_acromialis m.biceps_brachii
    m.brachialis m.triceps_brachii_long m.triceps_brachii_lateral m.triceps_brachii_medial m.triceps_brachii_accessory"
. "$here/leg.sh"
