# arms.awk -- a motion document of our own for the body's arms, on the joints and bones of a table for motion-fit(1).
#
#   awk -v motion=bend|torsion|shake [-v rate=HZ] -f arms.awk JOINTS TABLE BONES > NAME.motion.json
#
# JOINTS: what motion-fit --list prints of TABLE; BONES: the bones' files in millimetres, one a line. Each motion begins at rest:
#   bend     the elbows by 130 degrees in 1.2 s, about the line through the epicondyles; then held for 0.8 s
#   torsion  the forearms by 150 degrees in 1.2 s, thumbs to the front and inwards, about the line from the head of the radius to that of
#            the ulna; then held for 0.8 s
#   shake    the upper arms to and fro by 25 degrees, 2.5 times a second, for 1.6 s, the elbows with them; then rest for 1.4 s
# A joint that does not move is a hinge without keys.

BEGIN {
    FS = "\t"
    if (rate == "") rate = 60
    if (motion != "bend" && motion != "torsion" && motion != "shake") { print "arms.awk: motion is bend, torsion or shake" > "/dev/stderr"; failed = 1; exit 1 }
    seconds = motion == "shake" ? 3 : 2
    pi = atan2(0, -1)
}
FNR == 1 { file++ }

file == 1 && ($1 == "joint" || $1 == "place") {
    where[$2] = $6 " " $7 " " $8
    if ($1 == "joint") { joint[++joints] = $2; parent[$2] = $3 }
}

# a row with sides stands for two
file == 2 && $1 == "bone" {
    if ($0 ~ /\{[Ss]ide\}/) { row(sided($2, "left", "Left"), sided($3, "left", "Left")); row(sided($2, "right", "Right"), sided($3, "right", "Right")) }
    else row($2, $3)
}
file == 3 && NF {
    name = $1
    sub(/.*\//, "", name)
    sub(/\.[^.]*$/, "", name)
    for (k = 1; k <= rows; k++) if (name ~ pattern[k]) break
    if (k > rows) { print "arms.awk: no row binds the bone " name > "/dev/stderr"; failed = 1; exit 1 }
    bone[++bones] = sprintf("{\"name\": \"%s\", \"mesh\": \"%s\", \"units\": \"mm\", \"joint\": \"%s\"}", name, $1, on[k])
}

function sided(text, small, large) {
    gsub(/\{side\}/, small, text)
    gsub(/\{Side\}/, large, text)
    return text
}

function row(glob, name) {
    gsub(/\./, "[.]", glob)
    gsub(/\*/, ".*", glob)
    gsub(/\?/, ".", glob)
    pattern[++rows] = "^" glob "$"
    on[rows] = name
}

function smooth(t) { t = t < 0 ? 0 : t > 1 ? 1 : t; return t * t * (3 - 2 * t) }

# from 0 over 1 back to 0, both ends without a jerk
function shaken(t) { return smooth(t / 0.3) * smooth((1.6 - t) / 0.3) }

function degrees(name, t) {
    if (motion == "bend" && name ~ /^elbow_/) return 130 * smooth(t / 1.2)
    if (motion == "torsion" && name ~ /^forearm_/) return 150 * smooth(t / 1.2)
    if (motion == "shake" && name ~ /^shoulder_/) return 25 * shaken(t) * sin(2 * pi * 2.5 * t)
    if (motion == "shake" && name ~ /^elbow_/) return 15 * shaken(t) * (1 - cos(2 * pi * 2.5 * t))
    return 0
}

# the direction about which positive angles bend the elbow forwards, lift the arm to the front, or turn the thumb to the front
function axis(name,    side, a, b, sign, from, to, k, d) {
    side = name
    sub(/.*_/, "", side)
    from = name ~ /^forearm_/ ? name : "epicondyle_medial_" side
    to = name ~ /^forearm_/ ? "ulna_head_" side : "epicondyle_lateral_" side
    if (!(from in where) || !(to in where)) { print "arms.awk: the table has no " from " or no " to > "/dev/stderr"; failed = 1; exit 1 }
    split(where[from], a, " ")
    split(where[to], b, " ")
    sign = name ~ /^forearm_/ ? (side == "left" ? 1 : -1) : (side == "left" ? -1 : 1)
    for (k = 1; k <= 3; k++) d = d (k > 1 ? ", " : "") sprintf("%.17g", sign * (b[k] - a[k]))
    return "[" d "]"
}

function hinge(name,    moves, line, f, p) {
    moves = name ~ (motion == "torsion" ? "^forearm_" : motion == "bend" ? "^elbow_" : "^(shoulder|elbow)_")
    split(where[name], p, " ")
    line = sprintf("{\"name\": \"%s\", %s\"type\": \"hinge\", \"axis\": %s, \"point\": [%s, %s, %s]", name,
                   parent[name] == "-" ? "" : "\"parent\": \"" parent[name] "\", ", moves ? axis(name) : "[0, 0, 1]", p[1], p[2], p[3])
    if (moves) {
        line = line ", \"keys\": ["
        for (f = 0; f <= seconds * rate; f++) line = line (f ? ", " : "") sprintf("[%.17g, %.17g]", f / rate, degrees(name, f / rate))
        line = line "]"
    }
    return line "}"
}

END {
    if (failed) exit 1
    if (!joints || !bones) { print "arms.awk: no joints or no bones" > "/dev/stderr"; exit 1 }
    printf "{\"format\": \"sinew-motion\", \"version\": 1, \"name\": \"%s\", \"metersPerUnit\": 1, \"rate\": %s,\n \"joints\": [\n", motion, rate
    for (k = 1; k <= joints; k++) printf "  %s%s\n", hinge(joint[k]), k < joints ? "," : "],"
    print " \"bones\": ["
    for (k = 1; k <= bones; k++) printf "  %s%s\n", bone[k], k < bones ? "," : "]}"
}
