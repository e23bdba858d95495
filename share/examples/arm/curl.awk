# A curl of the sample arm, as a motion capture would deliver it: a BVH file, centimetres, y up.
#
#   awk -f curl.awk [-v rate=60] > curl.bvh
#
# The elbow bends to 120 degrees in 1.25 s, holds for 0.25 s and is let down to 5 degrees in 0.75 s; a quarter of a second before and half a second
# after it rests. Each way is that of minimum jerk, 10 s^3 - 15 s^4 + 6 s^5 (Flash and Hogan 1985).

function way(from, to, start, seconds, t,    s) {
    s = (t - start) / seconds
    s = s < 0 ? 0 : s > 1 ? 1 : s
    return (to - from) * s * s * s * (10 - s * (15 - 6 * s))
}

BEGIN {
    if (rate == "") rate = 60
    if (rate + 0 <= 0) { print "curl.awk: the rate is above 0" > "/dev/stderr"; exit 2 }
    frames = int(3 * rate + 1.5)
    print "HIERARCHY\nROOT shoulder\n{\n  OFFSET 0 30 0\n  CHANNELS 0"
    print "  JOINT elbow\n  {\n    OFFSET 0 -30 0\n    CHANNELS 1 Zrotation\n    End Site\n    {\n      OFFSET 0 -25 0\n    }\n  }\n}"
    printf "MOTION\nFrames: %d\nFrame Time: %.9f\n", frames, 1 / rate
    for (f = 0; f < frames; f++) printf "%.4f\n", way(0, 120, 0.25, 1.25, f / rate) + way(120, 5, 1.75, 0.75, f / rate)
}
