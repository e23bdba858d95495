# bridge.awk -- join the two heads of the sample biceps by a bridge, as a careless sculptor or a scan of touching muscles does.
# Usage: awk -f bridge.awk biceps.obj > biceps-bridged.obj
# One triangle of each head, two that face each other well away from where the heads part, give way to a prism between them: the
# surface stays closed and oriented, but has a handle now. The last line of the output holds the height of the bridge as a comment.

function height(t) { return (x[corner[t, 1], 3] + x[corner[t, 2], 3] + x[corner[t, 3], 3]) / 3 }

function find(v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]]
    return v
}

# the pieces of 20 triangles or more into which the surface above a level falls
function pieces_above(level,    t, v, piece, size, count) {
    for (v = 1; v <= vertices; v++) parent[v] = v
    for (t = 1; t <= triangles; t++) {
        if (height(t) <= level) continue
        parent[find(corner[t, 2])] = find(corner[t, 1])
        parent[find(corner[t, 3])] = find(corner[t, 1])
    }
    for (t = 1; t <= triangles; t++)
        if (height(t) > level && ++size[find(corner[t, 1])] == 20) count++
    return count
}

# centre and unit normal of a triangle
function measure(t,    a, b, c, k, length_) {
    a = corner[t, 1]; b = corner[t, 2]; c = corner[t, 3]
    for (k = 1; k <= 3; k++) {
        centre[t, k] = (x[a, k] + x[b, k] + x[c, k]) / 3
        u[k] = x[b, k] - x[a, k]
        w[k] = x[c, k] - x[a, k]
    }
    normal[t, 1] = u[2] * w[3] - u[3] * w[2]
    normal[t, 2] = u[3] * w[1] - u[1] * w[3]
    normal[t, 3] = u[1] * w[2] - u[2] * w[1]
    length_ = sqrt(normal[t, 1] ^ 2 + normal[t, 2] ^ 2 + normal[t, 3] ^ 2)
    for (k = 1; k <= 3; k++) normal[t, k] /= length_
}

# how far apart two triangles are, more where they look past each other
function misfit(s, t,    k, d, length_, facing) {
    for (k = 1; k <= 3; k++) {
        d[k] = centre[t, k] - centre[s, k]
        length_ += d[k] ^ 2
    }
    length_ = sqrt(length_)
    for (k = 1; k <= 3; k++) facing += d[k] * (normal[s, k] - normal[t, k])
    return facing > 0 ? length_ * 2 * length_ / facing : 1e9
}

$1 == "v" {
    vertices++
    for (k = 1; k <= 3; k++) x[vertices, k] = $(k + 1) + 0
    if (vertices == 1 || $4 > top) top = $4 + 0
    if (vertices == 1 || $4 < bottom) bottom = $4 + 0
}

$1 == "f" {
    triangles++
    for (k = 1; k <= 3; k++) corner[triangles, k] = $(k + 1) + 0
}

$1 != "f"

function print_face(a, b, c) { print "f", a, b, c }

# a prism between triangle s and triangle t, whose corners run the other way round, turned so that its edges are short
function print_prism(s, t,    turn, k, d, length_, least, best) {
    for (turn = 0; turn < 3; turn++) {
        length_ = 0
        for (k = 0; k < 3; k++)
            for (d = 1; d <= 3; d++) length_ += (x[corner[s, k + 1], d] - x[corner[t, (turn - k + 3) % 3 + 1], d]) ^ 2
        if (turn == 0 || length_ < least) { least = length_; best = turn }
    }
    for (k = 0; k < 3; k++) {
        print_face(corner[s, k + 1], corner[s, (k + 1) % 3 + 1], corner[t, (best - k + 2) % 3 + 1])
        print_face(corner[s, k + 1], corner[t, (best - k + 2) % 3 + 1], corner[t, (best - k + 3) % 3 + 1])
    }
}

END {
    for (step = 8; step > 0 && pieces_above(top - step / 20 * (top - bottom)) != 2; step--) continue
    level = top - step / 20 * (top - bottom)
    pieces_above(level)
    level += 0.3 * (top - level)
    for (t = 1; t <= triangles; t++) if (height(t) > level - 0.01 && height(t) < level + 0.01) { band[++bands] = t; measure(t) }
    least = 1e9
    for (i = 1; i <= bands; i++)
        for (k = i + 1; k <= bands; k++) {
            if (find(corner[band[i], 1]) == find(corner[band[k], 1])) continue
            distance = misfit(band[i], band[k])
            if (distance < least) { least = distance; s = band[i]; t = band[k] }
        }
    for (i = 1; i <= triangles; i++) if (i != s && i != t) print_face(corner[i, 1], corner[i, 2], corner[i, 3])
    print_prism(s, t)
    print "# bridge at height", (height(s) + height(t)) / 2
}
