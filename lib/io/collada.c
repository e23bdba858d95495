/*
 * collada.c -- what assimp 5.2 loses of a Collada file without a word: shapes that are mixed (morph), and which of two skeletons a skin is
 * on, as it looks for joints by their sid in the whole scene.
 */
#include <stdlib.h>
#include <string.h>

#include "xml_tree.h"

typedef struct spans {
    sn_span *items;
    size_t count, capacity;
} spans;

static bool add(spans *s, sn_span item) {
    if (!sn_grow((void **)&s->items, &s->capacity, s->count + 1, sizeof *s->items)) return false;
    s->items[s->count++] = item;
    return true;
}

static int compare(const void *a, const void *b) {
    const sn_span *s = a, *t = b;
    int order = memcmp(s->text, t->text, s->length < t->length ? s->length : t->length);
    return order != 0 ? order : (s->length > t->length) - (s->length < t->length);
}

/* The sids of all nodes that are joints. */
static bool collect_joints(const sn_xml_tree *tree, spans *out) {
    bool enough = true;
    for (sn_index i = 0; i < tree->count && enough; i++) {
        if (!sn_xml_is(tree, i, "node")) continue;
        sn_span sid = sn_xml_attribute_text(tree, i, "sid"), type = sn_xml_attribute_text(tree, i, "type");
        if (sid.text != NULL && sid.length > 0 && type.text != NULL && sn_span_is(type, "JOINT")) enough = add(out, sid);
    }
    return enough;
}

/* What skins call their joints. */
static bool collect_names(const sn_xml_tree *tree, spans *out) {
    bool enough = true;
    for (sn_index i = 0; i < tree->count && enough; i++) {
        if (!sn_xml_is(tree, i, "Name_array")) continue;
        sn_span text = sn_xml_text(tree, i);
        for (sn_span word = sn_xml_word(&text); word.length > 0 && enough; word = sn_xml_word(&text)) enough = add(out, word);
    }
    return enough;
}

static sn_status refuse_twins(const spans *joints, const spans *names, sn_error *error) {
    for (size_t i = 1; i < joints->count; i++) {
        const sn_span *sid = &joints->items[i];
        if (compare(sid - 1, sid) != 0 || bsearch(sid, names->items, names->count, sizeof *sid, compare) == NULL) continue;
        return sn_fail(
            error, SN_ERROR_INPUT,
            "two joints have the sid '%.*s', and which of them a skin is on is not read; give each skeleton a file, or sids of its own",
            (int)(sid->length < 100 ? sid->length : 100), sid->text);
    }
    return SN_OK;
}

static sn_status check_skins(const sn_xml_tree *tree, sn_error *error) {
    spans joints = {0}, names = {0};
    sn_status status = collect_joints(tree, &joints) && collect_names(tree, &names) ? SN_OK : sn_fail_memory(error, "the joints");
    if (status == SN_OK && joints.count > 1 && names.count > 0) {
        qsort(joints.items, joints.count, sizeof *joints.items, compare);
        qsort(names.items, names.count, sizeof *names.items, compare);
        status = refuse_twins(&joints, &names, error);
    }
    free(joints.items);
    free(names.items);
    return status;
}

sn_status sn_collada_check(const sn_blob *file, bool shapes, sn_error *error) {
    sn_xml_tree tree;
    sn_error detail = {0};
    sn_status status = sn_xml_tree_parse(file, &tree, &detail);
    if (status == SN_ERROR_MEMORY) return sn_fail_memory(error, "the file");
    if (status != SN_OK) return SN_OK; /* the importer's to judge */
    sn_index library = sn_xml_find(&tree, 0, SN_NONE, "library_controllers");
    if (shapes && library != SN_NONE && sn_xml_find(&tree, library, SN_NONE, "morph") != SN_NONE)
        status =
            sn_fail(error, SN_ERROR_INPUT, "mixes shapes (morph of its controllers), which is not read; apply the shapes and export again");
    if (status == SN_OK) status = check_skins(&tree, error);
    sn_xml_tree_free(&tree);
    return status;
}
