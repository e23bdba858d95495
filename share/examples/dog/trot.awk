# A trot of a dog, as columns of coordinates for the model of dm_control's dog (dog.xml): angles in degrees, lengths in metres, x forwards, z up.
#
#   awk -f trot.awk [-v strides=2] [-v rate=100] > trot.sto
#
# A stride takes 0.5 s and 0.6 m. Diagonal legs move together: left hind and right fore first, the other two half a stride later. A foot stands
# for the first half of its stride, going back at the speed of the trunk, and swings for the second. Each angle is a Fourier series of the stride:
# its mean, then a cosine and a sine for each harmonic. They were fitted to angles that lead the paws along such a path.

function joint(leg, name, series) {
    count++
    is_hind[count] = leg == "hind"
    called[count] = name
    terms[count] = split(series, number, " ")
    for (k = 1; k <= terms[count]; k++) term[count, k] = number[k]
}

# The angle of a joint at a phase of its leg's stride.
function angle(j, phase,    k, sum) {
    sum = term[j, 1]
    for (k = 1; 2 * k < terms[j]; k++)
        sum += term[j, 2 * k] * cos(2 * PI * k * phase) + term[j, 2 * k + 1] * sin(2 * PI * k * phase)
    return sum
}

BEGIN {
    PI = 3.14159265358979
    SECONDS = 0.5; METRES = 0.6
    if (strides == "") strides = 2
    if (rate == "") rate = 100
    if (strides + 0 <= 0 || rate + 0 <= 0) { print "trot.awk: strides and rate are above 0" > "/dev/stderr"; exit 2 }

    joint("hind", "hip_SIDE_extend", "-36.89 -28.31 -0.01 1.36 9.42 3.07 -2.82 -0.09 -0.54 -0.23 -0.54 -0.41 0.28 0.14 -0.2")
    joint("hind", "knee_SIDE", "-39.57 -13.5 6.29 12.21 5.57 1.95 -5.6 -0.16 -0.47 -0.22 -0.6 -0.13 0.15 0.08 -0.36")
    joint("hind", "ankle_SIDE", "-24.46 -4.97 12.87 19.74 -4.12 -4.21 -0.77 1.38 0.99 -0.21 -0.15 0.88 -0.18 -0.36 0.04")
    joint("hind", "toe_SIDE", "18.92 17.79 -1.4 -5.14 2.78 4.56 -4.02 -2.05 -0.99 0.8 -0.03 -0.84 -0.35 0.26 -0.09")
    joint("fore", "shoulder_SIDE_extend", "19.06 -10.29 -10.02 -13.63 2.78 -1.35 2.27 -1.48 0.87 -0.57 0.79 -0.18 0.5 -0.31 0.26")
    joint("fore", "elbow_SIDE", "-31.66 1.21 20.06 25.95 1.99 2.47 -4.78 2.35 -0.99 0.67 -1.26 0.46 -0.51 0.5 -0.52")
    joint("fore", "wrist_SIDE", "-21.61 6.4 41.22 16.56 -6.62 -3.04 -4.63 -0.65 0.82 -0.07 0.13 0.28 0.04 0.01 -0.11")
    joint("fore", "scapula_SIDE_extend", "-1 -9.55 2.96 0 0 0 0 0 0 0 0 0 0 0 0")
    joint("fore", "finger_SIDE", "10.92 12.89 -1.68 -9.89 2.15 2.66 1.6 -0.22 -0.43 -0.37 -0.62 -0.46 0.28 -0.33 0.12")

    rows = int(strides * SECONDS * rate + 0.5) + 1
    print "trot\nnRows=" rows "\nnColumns=" 3 + 2 * count "\ninDegrees=yes\nendheader"
    printf "time\troot_tx\troot_tz"
    for (j = 1; j <= count; j++)
        for (side = 0; side < 2; side++) {
            name = called[j]
            sub("SIDE", side == 0 ? "L" : "R", name)
            printf "\t%s", name
        }
    print ""
    for (row = 0; row < rows; row++) {
        stride = row / rate / SECONDS
        # the trunk is lowest in the middle of each stance
        printf "%.6f\t%.6f\t%.6f", row / rate, METRES * stride, -0.03 + 0.008 * cos(4 * PI * stride)
        for (j = 1; j <= count; j++)
            for (side = 0; side < 2; side++) printf "\t%.4f", angle(j, stride + (is_hind[j] == side ? 0.5 : 0))
        print ""
    }
}
