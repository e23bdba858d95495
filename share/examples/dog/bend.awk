# Two coordinates of dog.xml that turn by so many degrees each, in a second by smoothstep, and half a second of rest: a storage file.
#   awk -f bend.awk -v first=hip_L_extend -v by=25 -v second=knee_L -v and_by=-30 > hip.sto
BEGIN {
    rate = 60; rows = 91
    printf "bend\nversion=1\nnRows=%d\nnColumns=3\ninDegrees=yes\nendheader\ntime\t%s\t%s\n", rows, first, second
    for (i = 0; i < rows; i++) {
        t = i / rate; share = t < 1 ? t * t * (3 - 2 * t) : 1
        printf "%.6f\t%.9f\t%.9f\n", t, by * share, and_by * share
    }
}
