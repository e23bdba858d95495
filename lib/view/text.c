/*
 * text.c -- a small stroke font, drawn for this project, and text in it.
 *
 * A glyph is a list of pen strokes on a grid where a capital is 8 units high. A stroke is a list of points, each a digit (x), an
 * optional '+' (half a unit further right) and a letter (y: 'a' is 3 below the baseline, 'd' on it, 'i' the x-height, 'l' the height of
 * a capital). A capital letter makes a corner; a small letter is a control point of a quadratic B-spline. '*' closes a stroke.
 */
#include "image.h"

#include <ctype.h>
#include <string.h>

enum { STROKE_POINTS = 24, GLYPH_LINES = 256, CURVE_STEPS = 8 };
static const double UNITS_PER_SIZE = 8.0, LETTER_SPACE = 2.3, WORD_SPACE = 3.4, PEN = 0.56;

static const char *const GLYPHS[95] = {
    [' ' - 32] = "",
    ['!' - 32] = "0L0G 0D0D",
    ['"' - 32] = "0L0J 2L2J",
    ['#' - 32] = "1D2L 4D5L 0F6F 0I6I",
    ['$' - 32] = "5J5k0k0h5h5e0e0F 2+D2+L",
    ['%' - 32] = "1D5L 0i2i2l0l* 4d6d6g4g*",
    ['&' - 32] = "6D1j1l4l4j0g0d4d6G",
    ['\'' - 32] = "0L0J",
    ['(' - 32] = "2L0j0e2C",
    [')' - 32] = "0L2j2e0C",
    ['*' - 32] = "2L2H 0K4I 4K0I",
    ['+' - 32] = "2E2I 0G4G",
    [',' - 32] = "1D0B",
    ['-' - 32] = "0G3G",
    ['.' - 32] = "0D0D",
    ['/' - 32] = "0C4L",
    ['0' - 32] = "0d5d5l0l*",
    ['1' - 32] = "0J2L2D",
    ['2' - 32] = "0J0l5l5i0D5D",
    ['3' - 32] = "0J0l5l5h2H5h5d0d0F",
    ['4' - 32] = "4D4L0F6F",
    ['5' - 32] = "5L0L0I3I5+i5+d3D0D",
    ['6' - 32] = "4L0k0d5d5i0i0G",
    ['7' - 32] = "0L5L2D",
    ['8' - 32] = "0+h4+h4+l0+l* 0d5d5h0h*",
    ['9' - 32] = "1D5e5l0l0g5g5I",
    [':' - 32] = "0D0D 0H0H",
    [';' - 32] = "1H1H 1D0B",
    ['<' - 32] = "4J0G4D",
    ['=' - 32] = "0F4F 0H4H",
    ['>' - 32] = "0J4G0D",
    ['?' - 32] = "0K0l4l4i2H2G 2D2D",
    ['@' - 32] = "4F4I2i2f4f* 4F6f6l0l0d5D",
    ['A' - 32] = "0D3L6D 1F5F",
    ['B' - 32] = "0D0L3L5l5h3H0H 3H5+h5+d3D0D",
    ['C' - 32] = "6J6l0l0d6d6F",
    ['D' - 32] = "0D0L2L6l6d2D0D",
    ['E' - 32] = "5D0D0L5L 0H4H",
    ['F' - 32] = "0D0L5L 0H4H",
    ['G' - 32] = "6J6l0l0d6d6H3+H",
    ['H' - 32] = "0D0L 6D6L 0H6H",
    ['I' - 32] = "0D0L",
    ['J' - 32] = "4L4F4d0d0F",
    ['K' - 32] = "0D0L 5L0G 2I5+D",
    ['L' - 32] = "0L0D5D",
    ['M' - 32] = "0D0L3F6L6D",
    ['N' - 32] = "0D0L6D6L",
    ['O' - 32] = "0d6d6l0l*",
    ['P' - 32] = "0D0L3L5+l5+g3G0G",
    ['Q' - 32] = "0d6d6l0l* 4F6D",
    ['R' - 32] = "0D0L3L5+l5+g3G0G 3G5+D",
    ['S' - 32] = "5J5l0l0h5h5d0d0F",
    ['T' - 32] = "3D3L 0L6L",
    ['U' - 32] = "0L0G0d6d6G6L",
    ['V' - 32] = "0L3D6L",
    ['W' - 32] = "0L2D4L6D8L",
    ['X' - 32] = "0D5L 0L5D",
    ['Y' - 32] = "0L3H6L 3H3D",
    ['Z' - 32] = "0L5L0D5D",
    ['[' - 32] = "2L0L0C2C",
    ['\\' - 32] = "0L4C",
    [']' - 32] = "0L2L2C0C",
    ['^' - 32] = "0I2L4I",
    ['_' - 32] = "0C5C",
    ['`' - 32] = "0L1J",
    ['a' - 32] = "0d4d4i0i* 4I4D",
    ['b' - 32] = "0L0D 0d4d4i0i*",
    ['c' - 32] = "4H4i0i0d4d4E",
    ['d' - 32] = "4L4D 0d4d4i0i*",
    ['e' - 32] = "0G4G4i0i0d4d4E",
    ['f' - 32] = "3L1l1J1D 0I3I",
    ['g' - 32] = "0d4d4i0i* 4I4C4a0a0B",
    ['h' - 32] = "0L0D 0G0i4i4G4D",
    ['i' - 32] = "0I0D 0K0K",
    ['j' - 32] = "1I1C1a0A 1K1K",
    ['k' - 32] = "0L0D 4I0F 1G4D",
    ['l' - 32] = "0L0E0d1D",
    ['m' - 32] = "0I0D 0G0i3i3G3D 3G3i6i6G6D",
    ['n' - 32] = "0I0D 0G0i4i4G4D",
    ['o' - 32] = "0d4d4i0i*",
    ['p' - 32] = "0I0A 0d4d4i0i*",
    ['q' - 32] = "4I4A 0d4d4i0i*",
    ['r' - 32] = "0I0D 0G0i3I",
    ['s' - 32] = "4H4i0i0g4f4d0d0E",
    ['t' - 32] = "1K1E1d3D 0I3I",
    ['u' - 32] = "0I0F0d4d4F 4I4D",
    ['v' - 32] = "0I2D4I",
    ['w' - 32] = "0I1+D3I4+D6I",
    ['x' - 32] = "0D4I 0I4D",
    ['y' - 32] = "0I2D 4I1A",
    ['z' - 32] = "0I4I0D4D",
    ['{' - 32] = "3L1l1J1h0H1h1F1c3C",
    ['|' - 32] = "0L0C",
    ['}' - 32] = "0L2l2J2h3H2h2F2c0C",
    ['~' - 32] = "0G1i3f4H",
};
static const char *const BOX_GLYPH = "0D4D4L0L0D";
/* Letters of Latin-1 from U+00C0 without their accents; a diaeresis is drawn. */
static const char LATIN_BASE[65] = "AAAAAAACEEEEIIIIDNOOOOOxOUUUUYPsaaaaaaaceeeeiiiidnooooo:ouuuuypy";
static const char *const SMALL_DIAERESIS = "1K1K 3K3K", *const CAPITAL_DIAERESIS = "2N2N 4N4N";

typedef struct pen_point {
    double x, y;
    bool corner;
} pen_point;

/* Read one stroke; returns how many points. *next is behind it. */
static int read_stroke(const char *text, const char **next, pen_point *points, bool *closed) {
    int count = 0;
    *closed = false;
    while (*text && *text != ' ' && *text != '*' && count < STROKE_POINTS) {
        pen_point p = {.x = *text++ - '0'};
        if (*text == '+') {
            p.x += 0.5;
            text++;
        }
        p.corner = isupper((unsigned char)*text) != 0;
        p.y = tolower((unsigned char)*text++) - 'd';
        points[count++] = p;
    }
    if (*text == '*') {
        *closed = true;
        text++;
    }
    while (*text == ' ') text++;
    *next = text;
    return count;
}

static pen_point middle(pen_point a, pen_point b) { return (pen_point){0.5 * (a.x + b.x), 0.5 * (a.y + b.y), true}; }

typedef struct glyph {
    int count;
    image_line lines[GLYPH_LINES];
    double width;
} glyph;

static void glyph_line(glyph *g, pen_point a, pen_point b) {
    if (g->count == GLYPH_LINES) return;
    g->lines[g->count++] = (image_line){a.x, a.y, b.x, b.y};
    g->width = fmax(g->width, fmax(a.x, b.x));
}

static void glyph_curve(glyph *g, pen_point a, pen_point control, pen_point b) {
    pen_point last = a;
    for (int i = 1; i <= CURVE_STEPS; i++) {
        double t = (double)i / CURVE_STEPS, s = 1.0 - t;
        pen_point p = {s * s * a.x + 2.0 * s * t * control.x + t * t * b.x, s * s * a.y + 2.0 * s * t * control.y + t * t * b.y, true};
        glyph_line(g, last, p);
        last = p;
    }
}

static void glyph_stroke(glyph *g, int count, const pen_point *points, bool closed) {
    pen_point here = closed ? middle(points[count - 1], points[0]) : points[0];
    for (int i = closed ? 0 : 1; i < count; i++) {
        bool last = i == count - 1 && !closed;
        if (points[i].corner || last) {
            glyph_line(g, here, points[i]);
            here = points[i];
        } else {
            pen_point next = points[(i + 1) % count];
            pen_point end = next.corner || (i + 1 == count - 1 && !closed) ? next : middle(points[i], next);
            glyph_curve(g, here, points[i], end);
            here = end;
        }
    }
}

static void glyph_strokes(glyph *g, const char *strokes) {
    pen_point points[STROKE_POINTS];
    while (*strokes) {
        bool closed;
        int count = read_stroke(strokes, &strokes, points, &closed);
        glyph_stroke(g, count, points, closed);
    }
}

/* U+00C0 to U+00FF. */
static void glyph_latin(glyph *g, int offset) {
    bool diaeresis = offset > 0 && strchr("\x04\x0B\x0F\x16\x1C\x24\x2B\x2F\x36\x3C\x3F", offset) != NULL;
    glyph_strokes(g, GLYPHS[LATIN_BASE[offset] - 32]);
    if (diaeresis) glyph_strokes(g, offset < 32 ? CAPITAL_DIAERESIS : SMALL_DIAERESIS);
}

/* The glyph of the character at *text, which moves on behind it. */
static glyph glyph_of(const char **text) {
    unsigned char c = (unsigned char)*(*text)++, next = (unsigned char)**text;
    glyph g = {0};
    if (c >= 0x80)
        while (((unsigned char)**text & 0xC0) == 0x80) (*text)++;
    if (c == 0xC3 && (next & 0xC0) == 0x80)
        glyph_latin(&g, next & 0x3F);
    else
        glyph_strokes(&g, c >= 32 && c < 127 ? GLYPHS[c - 32] : BOX_GLYPH);
    if (c == ' ') g.width = WORD_SPACE - LETTER_SPACE;
    return g;
}

double sn_text_width(double size, const char *text) {
    double width = 0.0;
    while (*text) width += glyph_of(&text).width + LETTER_SPACE;
    return fmax(width - LETTER_SPACE, 0.0) * size / UNITS_PER_SIZE;
}

void sn_text_draw(sn_image *image, double x, double y, sn_text_style style, const char *text) {
    double scale = style.size / UNITS_PER_SIZE, radius = PEN * style.weight * fmax(scale, 0.9);
    while (*text) {
        glyph g = glyph_of(&text);
        for (int i = 0; i < g.count; i++) {
            image_line *line = &g.lines[i];
            *line = (image_line){x + line->ax * scale, y - line->ay * scale, x + line->bx * scale, y - line->by * scale};
        }
        image_lines(image, (size_t)g.count, g.lines, radius, style.color);
        x += (g.width + LETTER_SPACE) * scale;
    }
}
