# A coordinate that goes from 0 to TO degrees and back again by STEP a frame: a storage file for motion-import, with a row a frame.
#   awk -f flexion.awk -v coordinate=hip_L_extend -v to=-90 [-v step=2] [-v rate=10] > flexion.sto
BEGIN {
    if (step == "") step = 2
    if (rate == "") rate = 10
    size = to < 0 ? -to : to
    steps = int(size / step + 0.5)
    if (coordinate == "" || !(step > 0) || !(rate > 0) || steps < 1) {
        print "flexion.awk: say coordinate, to (degrees, not 0), step and rate (above 0)" > "/dev/stderr"
        exit 1
    }
    printf "flexion\nversion=1\nnRows=%d\nnColumns=2\ninDegrees=yes\nendheader\ntime\t%s\n", 2 * steps + 1, coordinate
    for (i = 0; i <= 2 * steps; i++) printf "%.6f\t%.9f\n", i / rate, to * (i < steps ? i : 2 * steps - i) / steps
}
