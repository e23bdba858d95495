/*
 * attach_name.c -- which end of the muscle an area is at, by what it is called.
 */
#include "sinew/rig.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

/* The words of the table mean the end whose place in it they share; two of each. */
static const char *const words[] = {"origin", "origins", "insertion", "insertions", NULL};
static const char *const denials[] = {"no", "non", "not", "without", NULL};
static const char *const beginnings[] = {"orig", "insert", NULL};

static bool is_letter(char c) { return isalpha((unsigned char)c) || (unsigned char)c >= 0x80; }

/* The next word of a name: letters, up to where a capital follows a small one; *length 0 = there is none. */
static const char *next_word(const char *at, size_t *length) {
    *length = 0;
    while (*at != '\0' && !is_letter(*at)) at++;
    while (is_letter(at[*length])) {
        bool turns = *length > 0 && islower((unsigned char)at[*length - 1]) && isupper((unsigned char)at[*length]);
        if (turns) break;
        ++*length;
    }
    return at;
}

/* The place of a word in a list, whatever the case; -1 = it is not there. */
static int place_of(const char *word, size_t length, const char *const *list) {
    for (int i = 0; list[i] != NULL; i++)
        if (strlen(list[i]) == length && strncasecmp(word, list[i], length) == 0) return i;
    return -1;
}

/* Does it begin as the words do, or may it be one of them mistyped? */
static bool resembles(const char *word, size_t length) {
    for (int i = 0; beginnings[i] != NULL; i++)
        if (length >= strlen(beginnings[i]) && strncasecmp(word, beginnings[i], strlen(beginnings[i])) == 0) return true;
    return sn_nearest_word(word, length, words) != NULL;
}

sn_attachment_end sn_area_end(const char *name, bool *doubtful) {
    bool there[2] = {false, false}, denied = false, near = false;
    size_t length;
    for (const char *word = next_word(name != NULL ? name : "", &length); length > 0; word = next_word(word + length, &length)) {
        int place = place_of(word, length, words);
        if (place >= 0)
            there[place / 2] = true;
        else
            near = near || resembles(word, length);
        denied = denied || place_of(word, length, denials) >= 0;
    }
    bool told = there[0] != there[1] && !denied;
    *doubtful = !told && (there[0] || there[1] || near);
    if (!told) return SN_END_UNKNOWN;
    return there[1] ? SN_END_INSERTION : SN_END_ORIGIN;
}
