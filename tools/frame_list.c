/* frame_list.c -- which frames to draw, from words and numbers. */
#include "frame_list.h"

#include <stdio.h>
#include <string.h>

frame_list frames_parse(const cli *c, const char *text) {
    frame_list all = {0};
    while (text && *text) {
        char word[64];
        size_t length = strcspn(text, ",");
        int64_t first = 0, last = 0, step = 1;
        snprintf(word, sizeof word, "%.*s", (int)(length < 63 ? length : 63), text);
        char *colon = strchr(word, ':'), *second = colon ? strchr(colon + 1, ':') : NULL;
        if (colon) *colon = 0;
        if (second) *second = 0;
        bool good = sn_parse_integer(word, INT32_MIN, INT32_MAX, &first, NULL) == SN_OK;
        last = first;
        if (colon) good = good && sn_parse_integer(colon + 1, INT32_MIN, INT32_MAX, &last, NULL) == SN_OK;
        if (second) good = good && sn_parse_integer(second + 1, 1, INT32_MAX, &step, NULL) == SN_OK;
        if (!good || last < first) cli_usage_error(c, "--frame: '%.*s' is no frame and no FIRST:LAST:STEP", (int)length, text);
        for (int64_t f = first; f <= last; f += step) {
            if (all.count == FRAMES_MAX) cli_usage_error(c, "--frame: more than %d frames", FRAMES_MAX);
            all.items[all.count++] = f;
        }
        text += length + (text[length] == ',');
    }
    return all;
}

frame_list frames_spread(int64_t count, int64_t first, int64_t last) {
    frame_list all = {0};
    int64_t there = last - first + 1;
    if (count > there) count = there;
    if (count > FRAMES_MAX) count = FRAMES_MAX;
    for (int64_t i = 0; i < count; i++)
        all.items[all.count++] = count > 1 ? first + (2 * i * (last - first) + count - 1) / (2 * (count - 1)) : first;
    return all;
}
