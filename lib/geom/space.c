/*
 * space.c -- anatomical spaces of scans, LPS and RAS: what headers say of them, and that a command's inputs are in one.
 */
#include "sinew/mesh.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

static const char *const NAMES[] = {NULL, "LPS", "RAS"};
enum { NAME_COUNT = sizeof NAMES / sizeof *NAMES };

const char *sn_space_name(sn_space space) { return NAMES[space]; }

sn_space sn_space_from_name(const char *name) {
    for (int i = 1; i < NAME_COUNT; i++)
        if (strcmp(name, NAMES[i]) == 0) return (sn_space)i;
    return SN_SPACE_UNKNOWN;
}

sn_space sn_space_find(const char *text, size_t size) {
    static const char word[] = "SPACE=";
    const size_t length = sizeof word - 1, name = 3;
    for (size_t i = 0; i + length + name <= size; i++) {
        const char *at = text + i + length;
        if (memcmp(text + i, word, length) != 0 || (i > 0 && isalnum((unsigned char)text[i - 1]))) continue;
        if (i + length + name < size && isalnum((unsigned char)at[name])) continue;
        const char value[4] = {at[0], at[1], at[2], '\0'};
        if (sn_space_from_name(value) != SN_SPACE_UNKNOWN) return sn_space_from_name(value);
    }
    return SN_SPACE_UNKNOWN;
}

/* What the user told: one word for the whole command, before its files are read by any thread. */
static sn_space told_space = SN_SPACE_UNKNOWN;

void sn_space_tell(sn_space space) { told_space = space; }

sn_space sn_space_told(void) { return told_space; }

sn_space sn_space_settle(const char *name, sn_space header) {
    if (told_space == SN_SPACE_UNKNOWN || header == told_space) return header;
    if (header != SN_SPACE_UNKNOWN)
        sn_log(SN_LOG_WARNING, "%s: its header says the space %s; %s is taken, as was told", name, sn_space_name(header),
               sn_space_name(told_space));
    return told_space;
}

static sn_status refuse(const sn_space_seen *seen, sn_space space, const char *name, sn_error *error) {
    static const char help[] = "bring them into one, by negating x and y; where one is known to be mistaken, --space goes before headers";
    if (seen->name[0] == '\0')
        return sn_fail(error, SN_ERROR_INPUT, "\"%s\" is in the space %s, and --space says %s: %s", name, sn_space_name(space),
                       sn_space_name(seen->space), help);
    return sn_fail(error, SN_ERROR_INPUT, "\"%s\" is in the space %s, and \"%s\" in %s: %s", seen->name, sn_space_name(seen->space), name,
                   sn_space_name(space), help);
}

sn_status sn_space_take(sn_space_seen *seen, sn_space space, const char *name, sn_error *error) {
    if (space == SN_SPACE_UNKNOWN || space == seen->space) return SN_OK;
    if (seen->space != SN_SPACE_UNKNOWN) return refuse(seen, space, name, error);
    seen->space = space;
    snprintf(seen->name, sizeof seen->name, "%s", name);
    return SN_OK;
}
