/* word.c -- which of the known words a mistyped one was meant to be. */
#include "sinew/base.h"

#include <limits.h>
#include <string.h>

/* A longer word than this is nobody's name of anything. */
enum { LONGEST = 40 };

/* Without case, '_', '-' and blanks, in which styles of names differ; how long that is, or -1 where it is too long. */
static int fold(const char *word, size_t length, char out[LONGEST]) {
    int count = 0;
    for (size_t i = 0; i < length && word[i] != '\0'; i++) {
        char c = word[i];
        if (c == '_' || c == '-' || c == ' ') continue;
        if (count == LONGEST) return -1;
        out[count++] = c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
    }
    return count;
}

static int least(int a, int b) { return a < b ? a : b; }

/* Letters to change, insert, leave out or swap with their neighbour (optimal string alignment; Damerau 1964, Levenshtein 1966). */
static int edits(const char *a, int a_count, const char *b, int b_count) {
    int rows[3][LONGEST + 1], *before = rows[0], *last = rows[1], *row = rows[2];
    for (int j = 0; j <= b_count; j++) last[j] = j;
    for (int i = 1; i <= a_count; i++) {
        row[0] = i;
        for (int j = 1; j <= b_count; j++) {
            row[j] = least(least(last[j], row[j - 1]) + 1, last[j - 1] + (a[i - 1] != b[j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = least(row[j], before[j - 2] + 1);
        }
        int *free_row = before;
        before = last, last = row, row = free_row;
    }
    return last[b_count];
}

int sn_word_distance(const char *word, size_t length, const char *known) {
    char a[LONGEST], b[LONGEST];
    int a_count = fold(word, length, a), b_count = fold(known, SIZE_MAX, b);
    if (a_count < 1 || b_count < 1) return INT_MAX;
    int bound = (a_count > b_count ? a_count : b_count) / 3;
    if (a_count - b_count > bound || b_count - a_count > bound) return INT_MAX;
    int distance = edits(a, a_count, b, b_count);
    return distance <= bound ? distance : INT_MAX;
}

const char *sn_nearest_word(const char *word, size_t length, const char *const *known) {
    const char *nearest = NULL;
    int best = INT_MAX;
    for (; *known != NULL; known++) {
        int distance = sn_word_distance(word, length, *known);
        if (distance >= best) continue;
        best = distance;
        nearest = *known;
    }
    return nearest;
}
