# A hip that bends by `hip` degrees and a knee by `knee`, in a second by smoothstep, and half a second of rest: a storage file of the coordinates
# of dog.xml's left hind leg.   awk -f hip.awk -v hip=25 -v knee=-30 > hip.sto
BEGIN {
    rate = 60; rows = 91
    if (hip == "") hip = 25
    if (knee == "") knee = -30
    printf "hip\nversion=1\nnRows=%d\nnColumns=3\ninDegrees=yes\nendheader\ntime\thip_L_extend\tknee_L\n", rows
    for (i = 0; i < rows; i++) {
        t = i / rate; share = t < 1 ? t * t * (3 - 2 * t) : 1
        printf "%.6f\t%.9f\t%.9f\n", t, hip * share, knee * share
    }
}
