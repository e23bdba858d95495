/* pattern.c -- names by patterns. */
#include "sinew/base.h"

/* After a mismatch the last '*' takes one character more: no recursion, at most length of pattern x length of text steps. */
bool sn_pattern_matches(const char *pattern, const char *text) {
    const char *star = NULL, *taken = text;
    while (*text != '\0') {
        if (*pattern == '*') {
            star = ++pattern;
            taken = text;
        } else if (*pattern == *text || *pattern == '?') {
            pattern++;
            text++;
        } else if (star != NULL) {
            pattern = star;
            text = ++taken;
        } else {
            return false;
        }
    }
    while (*pattern == '*') pattern++;
    return *pattern == '\0';
}
