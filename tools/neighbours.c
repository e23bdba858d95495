/*
 * neighbours.c -- where a muscle rubs on its neighbours: which files they are, their weights, and what is said of them.
 */
#include "neighbours.h"
#include "sinew/thread.h"

#include <stdlib.h>
#include <string.h>

const char *const weight_source_names[] = {"uniform", "painted", "rule", NULL};
const char *const weight_names[3] = {"slide", "soft", "hard"};
/* Two meshes are the same where no vertex is farther from its like than this share of the box's diagonal: units round. */
static const double SAME = 1e-9;

void neighbours_free(neighbour_result *result) {
    for (size_t i = 0; i < result->target_count; i++) {
        sn_muscle_free(&result->targets[i].muscle);
        free(result->targets[i].name);
    }
    free(result->targets);
    free(result->twin);
    bones_free(&result->muscles);
    bones_free(&result->obstacles);
    *result = (neighbour_result){0};
}

bool neighbours_wanted(const neighbour_request *request) {
    return request->glue.count > 0 || request->lists.count > 0 || request->envelope != NULL;
}

sn_status neighbours_name(const cli *c, const neighbour_request *request, neighbour_result *out, sn_error *error) {
    static const cli_list none = {0};
    out->muscles.rigs = true;
    out->nearest = INFINITY;
    sn_status status = bones_name(c, &none, &request->lists, &out->muscles, error);
    out->listed = (int)out->muscles.count;
    return status == SN_OK ? bones_name(c, &none, &request->obstacles, &out->obstacles, error) : status;
}

/* ---- reading one ------------------------------------------------------------------------------------------------------- */

/* How files are read: one with a unit of its own keeps it, a bare mesh is read like the muscle, or in its unit where that is a document. */
typedef struct reading {
    sn_read_options options;
    double meters_per_unit; /* of the muscle */
} reading;

/* The muscle in a file, in the unit of the muscle at hand. */
static sn_status read_muscle(const reading *r, const char *file, sn_muscle *out, sn_error *error) {
    sn_document *document = NULL;
    sn_blob blob = {0};
    sn_status status = sn_blob_read(file, &blob, error);
    if (status == SN_OK) status = sn_muscle_parse(&blob, &r->options, out, &document, error);
    if (status != SN_OK) sn_error_set_file(error, file);
    sn_blob_free(&blob);
    sn_document_free(document);
    double scale = status == SN_OK ? out->meters_per_unit / r->meters_per_unit : 1.0;
    for (sn_index v = 0; v < out->mesh.vertex_count && scale != 1.0; v++) out->mesh.positions[v] = sn_scale(out->mesh.positions[v], scale);
    return status;
}

static reading reading_for(const cli *c, const sn_muscle *muscle) {
    reading r = {c->read, muscle->meters_per_unit};
    r.options.mesh = NULL;
    r.options.asked = false; /* what was asked for is the muscle's */
    if (r.options.meters_per_unit == 0.0) r.options.meters_per_unit = muscle->meters_per_unit;
    return r;
}

static sn_status load_named(const reading *r, const char *text, neighbour_target *out, sn_error *error) {
    const char *file = text;
    if (strchr(text, '=') == NULL || !cli_split(text, &out->name, &file)) file = text;
    sn_status status = read_muscle(r, file, &out->muscle, error);
    if (status == SN_OK && out->name == NULL) out->name = sn_strdup(out->muscle.name != NULL ? out->muscle.name : file);
    return status == SN_OK && out->name == NULL ? sn_fail_memory(error, "the neighbours") : status;
}

/* ---- the muscles of a list: those near by box --------------------------------------------------------------------------- */

typedef struct listing {
    const reading *reading;
    const sn_muscle *muscle;
    bone_list *files;
    double reach;
    neighbour_target *targets; /* (files->count) those near, others empty */
    double *gaps;              /* (files->count) of the boxes */
    bool *itself;              /* (files->count) */
} listing;

static bool same_mesh(const sn_mesh *a, const sn_mesh *b) {
    if (a->vertex_count != b->vertex_count || a->triangle_count != b->triangle_count) return false;
    if (memcmp(a->triangles, b->triangles, (size_t)a->triangle_count * sizeof *a->triangles) != 0) return false;
    double most = SAME * sn_box_diagonal(sn_mesh_box(a));
    for (sn_index v = 0; v < a->vertex_count; v++)
        if (!(sn_distance(a->positions[v], b->positions[v]) <= most)) return false;
    return true;
}

/* As a scene calls it: by its document, else by its file without ".muscle.json". */
static char *name_of(const bone *file, const sn_muscle *muscle) {
    if (file->named || muscle->name == NULL) {
        const char *middle = file->named ? NULL : strstr(file->name, ".muscle");
        return middle != NULL && middle > file->name ? sn_strndup(file->name, (size_t)(middle - file->name)) : sn_strdup(file->name);
    }
    return sn_strdup(muscle->name);
}

/* A muscle that has the name of the one at hand but another mesh is an older state of it, or one that could not be told from it. */
static sn_status judge(const listing *l, sn_index i, sn_error *error) {
    bone *file = &l->files->items[i];
    neighbour_target *t = &l->targets[i];
    t->list = file->list;
    t->name = name_of(file, &t->muscle);
    if (t->name == NULL) return sn_fail_memory(error, "the neighbours");
    l->itself[i] = same_mesh(&l->muscle->mesh, &t->muscle.mesh);
    if (!l->itself[i] && l->muscle->name != NULL && strcmp(t->name, l->muscle->name) == 0)
        return sn_fail_at(
            error, SN_ERROR_INPUT, file->file, 0,
            "it has the name of the muscle at hand, \"%s\", but another mesh; make it anew, or give one of the two another name", t->name);
    l->gaps[i] = sn_box_gap(sn_mesh_box(&l->muscle->mesh), sn_mesh_box(&t->muscle.mesh));
    file->used = !l->itself[i] && l->gaps[i] <= l->reach;
    return SN_OK;
}

static void load_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    listing *l = user;
    for (sn_index i = begin; i < end; i++) {
        bone *file = &l->files->items[i];
        file->status = read_muscle(l->reading, file->file, &l->targets[i].muscle, &file->error);
        if (file->status == SN_OK) file->status = judge(l, i, &file->error);
        if (file->status == SN_OK && file->used) continue;
        sn_muscle_free(&l->targets[i].muscle);
        if (file->status == SN_OK && l->itself[i]) continue; /* its name may be another */
        free(l->targets[i].name);
        l->targets[i].name = NULL;
    }
}

/* Those near, behind the targets that are there. */
static sn_status take_near(const listing *l, neighbour_result *out, sn_error *error) {
    for (size_t i = 0; i < l->files->count; i++) {
        if (l->files->items[i].status != SN_OK) {
            *error = l->files->items[i].error;
            return l->files->items[i].status;
        }
        out->itself += l->itself[i];
        if (l->itself[i] && out->twin == NULL && l->muscle->name != NULL && strcmp(l->targets[i].name, l->muscle->name) != 0) {
            out->twin = l->targets[i].name;
            l->targets[i].name = NULL;
        }
        if (l->files->items[i].used) {
            out->targets[out->target_count++] = l->targets[i];
            l->targets[i] = (neighbour_target){0};
        } else if (!l->itself[i]) {
            out->passed_over++;
            out->nearest = fmin(out->nearest, l->gaps[i]);
        }
    }
    return SN_OK;
}

static sn_status load_listed(const cli *c, const reading *r, const sn_muscle *muscle, neighbour_result *out, sn_error *error) {
    size_t count = out->muscles.count;
    listing l = {.reading = r, .muscle = muscle, .files = &out->muscles, .reach = out->reach};
    l.targets = SN_NEW(neighbour_target, count);
    l.gaps = SN_NEW(double, count);
    l.itself = SN_NEW(bool, count);
    sn_status status = l.targets && l.gaps && l.itself ? SN_OK : sn_fail_memory(error, "the neighbours");
    if (status == SN_OK) {
        sn_pool *pool = sn_pool_create(c->threads);
        sn_parallel_for(pool, (sn_index)count, 1, load_range, &l);
        sn_pool_destroy(pool);
        status = take_near(&l, out, error);
    }
    for (size_t i = 0; i < count && l.targets != NULL; i++) {
        sn_muscle_free(&l.targets[i].muscle);
        free(l.targets[i].name);
    }
    free(l.targets);
    free(l.gaps);
    free(l.itself);
    return status;
}

/* The named targets first, those of lists, the envelope last. */
static sn_status load_targets(const cli *c, const neighbour_request *request, const sn_muscle *muscle, neighbour_result *out,
                              sn_error *error) {
    reading r = reading_for(c, muscle);
    out->targets = SN_NEW(neighbour_target, (size_t)request->glue.count + out->muscles.count + 1);
    if (out->targets == NULL) return sn_fail_memory(error, "the neighbours");
    sn_status status = SN_OK;
    for (int i = 0; i < request->glue.count && status == SN_OK; i++)
        status = load_named(&r, request->glue.items[i], &out->targets[out->target_count++], error);
    if (status == SN_OK && out->muscles.count > 0) status = load_listed(c, &r, muscle, out, error);
    if (status == SN_OK && request->envelope != NULL) status = load_named(&r, request->envelope, &out->targets[out->target_count++], error);
    return status;
}

static sn_status load_obstacles(const cli *c, const sn_muscle *muscle, const bone_list *bones, neighbour_result *out, sn_error *error) {
    out->obstacles.meters_per_unit = muscle->meters_per_unit;
    out->obstacles.given_unit = bones->given_unit;
    out->obstacles.up_given = bones->up_given;
    out->obstacles.up_y = bones->up_y;
    sn_status status = bones_load(&out->obstacles, c->threads, error);
    for (size_t i = 0; i < out->obstacles.count && status == SN_OK; i++)
        out->obstacles.items[i].used = sn_box_gap(sn_mesh_box(&out->obstacles.items[i].mesh), sn_mesh_box(&muscle->mesh)) <= out->reach;
    return status;
}

/* ---- weights -------------------------------------------------------------------------------------------------------------- */

static sn_status find_map(const sn_muscle *muscle, const char *name, const double **out, sn_error *error) {
    const sn_attribute *map = sn_mesh_attribute(&muscle->mesh, name);
    if (map == NULL || map->components != 1)
        return sn_fail(error, SN_ERROR_INPUT, "the muscle has no painted map of that name, %s; give a number within 0 to 1", name);
    *out = map->values;
    return SN_OK;
}

static sn_status read_uniform(const neighbour_request *request, const sn_muscle *muscle, sn_neighbours_params *params, sn_error *error) {
    sn_status status = SN_OK;
    for (int k = 0; k < 3 && status == SN_OK; k++) {
        const char *text = request->weights[k];
        if (text == NULL || sn_parse_number(text, &params->weights[k], NULL) == SN_OK) continue;
        status = find_map(muscle, text, &params->maps[k], error);
    }
    return status;
}

/* A map that is not there is 0 everywhere. */
static sn_status read_painted(const sn_muscle *muscle, sn_neighbours_params *params, sn_error *error) {
    bool any = false;
    for (int k = 0; k < 3; k++) {
        const sn_attribute *map = sn_mesh_attribute(&muscle->mesh, weight_names[k]);
        params->weights[k] = 0.0;
        if (map == NULL) continue;
        if (map->components != 1)
            return sn_fail(error, SN_ERROR_INPUT, "the painted map %s has %d numbers a vertex; a weight is one", weight_names[k],
                           map->components);
        params->maps[k] = map->values;
        any = true;
    }
    return any ? SN_OK : sn_fail(error, SN_ERROR_INPUT, "the muscle has none of the painted maps slide, soft and hard");
}

/* slide (vertex_count) is the caller's. */
static sn_status read_rule(const neighbour_request *request, const sn_muscle *muscle, double tendon, double *slide,
                           sn_neighbours_params *params, sn_error *error) {
    sn_status status = sn_tendon_slide(muscle, tendon, slide, error);
    params->maps[0] = slide;
    params->weights[1] = request->hold == 1;
    params->weights[2] = request->hold == 2;
    return status;
}

/* ---- the search ------------------------------------------------------------------------------------------------------------ */

/* What the library sees of the targets and obstacles; owned, but for what they point to. */
typedef struct sights {
    sn_neighbour *targets;
    const sn_mesh **obstacles;
    double *slide;
} sights;

static sn_status see(const neighbour_request *request, const bone_list *bones, const neighbour_result *result, sights *out,
                     sn_neighbours_params *params, sn_error *error) {
    const bone_list *lists[2] = {bones, &result->obstacles};
    out->targets = SN_NEW(sn_neighbour, result->target_count);
    out->obstacles = SN_NEW(const sn_mesh *, bones->count + result->obstacles.count);
    if (!out->targets || !out->obstacles) return sn_fail_memory(error, "the neighbours");
    for (size_t i = 0; i < result->target_count; i++)
        out->targets[i] = (sn_neighbour){result->targets[i].name, &result->targets[i].muscle.mesh,
                                         request->envelope != NULL && i == result->target_count - 1};
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < lists[k]->count; i++)
            if (lists[k]->items[i].mesh.triangle_count > 0) out->obstacles[params->obstacle_count++] = &lists[k]->items[i].mesh;
    params->target_count = (sn_index)result->target_count;
    params->targets = out->targets;
    params->obstacles = out->obstacles;
    return SN_OK;
}

static void take_found(sn_muscle *muscle, sn_neighbours_found *found) {
    sn_externals_free(muscle->externals, muscle->external_count);
    muscle->externals = found->items;
    muscle->external_count = found->count;
    muscle->has_externals = true;
    found->items = NULL;
    found->count = 0;
}

/* Bones are checked where they are loaded. */
static sn_status check_spaces(const sn_muscle *muscle, const neighbour_result *found, sn_error *error) {
    sn_space_seen seen = sn_space_begin();
    sn_status status = sn_space_take(&seen, muscle->space, muscle->name != NULL ? muscle->name : "the muscle", error);
    for (size_t i = 0; i < found->target_count && status == SN_OK; i++)
        status = sn_space_take(&seen, found->targets[i].muscle.space, found->targets[i].name, error);
    return status == SN_OK ? bones_check_spaces(&found->obstacles, muscle, error) : status;
}

static sn_status search(cli *c, const neighbour_request *request, const bone_list *bones, sn_muscle *muscle, neighbour_result *out,
                        sn_error *error) {
    sights s = {.slide = SN_NEW(double, muscle->mesh.vertex_count)};
    sn_neighbours_params params = sn_neighbours_defaults();
    params.reach = out->reach;
    params.most = (sn_index)request->targets;
    params.hidden = request->hidden;
    params.minimum = fmax(cli_length(request->minimum, muscle->meters_per_unit), 0.0);
    params.threads = c->threads;
    sn_status status = s.slide != NULL ? see(request, bones, out, &s, &params, error) : sn_fail_memory(error, "the weights");
    if (status == SN_OK && request->source == WEIGHTS_UNIFORM) status = read_uniform(request, muscle, &params, error);
    if (status == SN_OK && request->source == WEIGHTS_PAINTED) status = read_painted(muscle, &params, error);
    if (status == SN_OK && request->source == WEIGHTS_RULE) status = read_rule(request, muscle, out->tendon, s.slide, &params, error);
    if (status == SN_OK) status = check_spaces(muscle, out, error);
    if (status == SN_OK) status = sn_find_neighbours(muscle, &params, &c->trace, &out->found, error);
    if (status == SN_OK || status == SN_STOPPED) take_found(muscle, &out->found);
    free(s.targets);
    free(s.obstacles);
    free(s.slide);
    return status;
}

sn_status neighbours_find(cli *c, const neighbour_request *request, const bone_list *bones, sn_muscle *muscle, neighbour_result *out,
                          sn_error *error) {
    double reach = cli_length(request->reach, muscle->meters_per_unit), tendon = cli_length(request->tendon, muscle->meters_per_unit);
    out->reach = reach >= 0.0 ? reach : 0.005 / muscle->meters_per_unit;
    if (request->source == WEIGHTS_RULE) out->tendon = tendon >= 0.0 ? tendon : sn_tendon_default(muscle);
    sn_status status = load_targets(c, request, muscle, out, error);
    if (status == SN_OK) status = load_obstacles(c, muscle, bones, out, error);
    return status == SN_OK ? search(c, request, bones, muscle, out, error) : status;
}

/* ---- what it came to -------------------------------------------------------------------------------------------------------- */

typedef struct tally {
    sn_index rows, types[3]; /* rows in which slide, soft, hard act after sn_external_blend */
    sn_index idle;           /* rows in which none does */
    sn_index entered;        /* rows that begin in the target */
    double least, sum, greatest;
} tally;

static void count_external(const sn_external *e, tally *t) {
    for (sn_index k = 0; k < e->count; k++) {
        double acts[3], d = e->distances[k];
        sn_external_blend(&e->weights[3 * (size_t)k], acts);
        for (int w = 0; w < 3; w++) t->types[w] += acts[w] > 0.0;
        t->idle += acts[0] == 0.0 && acts[1] == 0.0 && acts[2] == 0.0;
        t->entered += d < 0.0;
        t->least = t->rows == 0 ? d : fmin(t->least, d);
        t->greatest = t->rows == 0 ? d : fmax(t->greatest, d);
        t->sum += d;
        t->rows++;
    }
}

static tally count_all(const sn_muscle *muscle) {
    tally t = {0};
    for (sn_index i = 0; i < muscle->external_count; i++) count_external(&muscle->externals[i], &t);
    return t;
}

static void warn_nothing(const cli *c, const neighbour_result *result, const sn_muscle *muscle) {
    const char *name = muscle->name != NULL ? muscle->name : "(no name)";
    double millimetres = result->nearest * muscle->meters_per_unit * 1e3;
    if (result->target_count == 0 && result->passed_over > 0)
        cli_warn(
            c,
            "muscle \"%s\": none of the %d muscles listed is within reach; the nearest is at least %.3g mm away: check their units, or "
            "raise --reach",
            name, result->passed_over, millimetres);
    else if (result->target_count == 0)
        cli_warn(c, "muscle \"%s\": the lists name no other muscle", name);
    else
        cli_warn(c, "muscle \"%s\": it faces no neighbour within %.3g mm; a larger --reach might find one", name,
                 result->reach * muscle->meters_per_unit * 1e3);
}

void neighbours_say(const cli *c, const neighbour_result *result, const sn_muscle *muscle) {
    tally all = count_all(muscle);
    double mm = muscle->meters_per_unit * 1e3;
    for (sn_index i = 0; i < muscle->external_count; i++)
        cli_say(c, "%s: %ld vertices by %s fascia", muscle->externals[i].target, (long)muscle->externals[i].count,
                muscle->externals[i].fascia);
    if (result->listed > 0)
        cli_say(c, "%d muscles listed: %d searched, %d passed over as their boxes are out of reach, %d the muscle itself", result->listed,
                result->listed - result->passed_over - result->itself, result->passed_over, result->itself);
    cli_say(c,
            "%ld rows: %ld slide, %ld soft, %ld hard; %ld vertices have none; left out: %ld behind another surface, %ld beyond --targets",
            (long)all.rows, (long)all.types[0], (long)all.types[1], (long)all.types[2], (long)result->found.without,
            (long)result->found.hidden, (long)result->found.surplus);
    if (all.entered > 0)
        cli_say(c, "%ld rows begin in their target, the deepest at %.3g mm: the muscles overlap at rest", (long)all.entered,
                -all.least * mm);
    if (all.rows == 0) warn_nothing(c, result, muscle);
    if (result->twin != NULL)
        cli_warn(c, "muscle \"%s\": \"%s\" of the lists has the same mesh, and was taken for it", muscle->name, result->twin);
    if (all.idle > 0) cli_warn(c, "%ld of %ld rows have no weight: they do nothing", (long)all.idle, (long)all.rows);
    if (result->found.clamped > 0)
        cli_warn(c, "%ld painted weights are not within 0 to 1 and were cut to it; maps of 0 to 255 must be divided by 255",
                 (long)result->found.clamped);
}

static void write_tally(sn_json *json, const tally *t) {
    for (int w = 0; w < 3; w++) sn_json_integer(json, weight_names[w], t->types[w]);
    sn_json_integer(json, "idle", t->idle);
    sn_json_integer(json, "entered", t->entered);
    if (t->rows == 0) return;
    sn_json_number(json, "leastDistance", t->least);
    sn_json_number(json, "meanDistance", t->sum / t->rows);
    sn_json_number(json, "greatestDistance", t->greatest);
}

static sn_index count_deep(const sn_muscle *muscle, bool deep) {
    sn_index rows = 0;
    for (sn_index i = 0; i < muscle->external_count; i++)
        if ((strcmp(muscle->externals[i].fascia, "deep") == 0) == deep) rows += muscle->externals[i].count;
    return rows;
}

void neighbours_write(sn_json *json, const neighbour_result *result, const sn_muscle *muscle) {
    tally all = count_all(muscle);
    sn_json_array(json, "externals");
    for (sn_index i = 0; i < muscle->external_count; i++) {
        const sn_external *e = &muscle->externals[i];
        tally t = {0};
        count_external(e, &t);
        sn_json_object(json, NULL);
        sn_json_text(json, "target", e->target);
        sn_json_text(json, "fascia", e->fascia);
        sn_json_integer(json, "vertices", e->count);
        write_tally(json, &t);
        sn_json_close(json);
    }
    sn_json_close(json);
    sn_json_object(json, "neighbours");
    sn_json_number(json, "reach", result->reach);
    if (result->tendon > 0.0) sn_json_number(json, "tendon", result->tendon);
    sn_json_integer(json, "listed", result->listed);
    sn_json_integer(json, "passedOver", result->passed_over);
    sn_json_integer(json, "searched", (int64_t)result->target_count);
    sn_json_integer(json, "rows", all.rows);
    sn_json_integer(json, "deep", count_deep(muscle, true));
    sn_json_integer(json, "superficial", count_deep(muscle, false));
    write_tally(json, &all);
    sn_json_integer(json, "without", result->found.without);
    sn_json_integer(json, "hidden", result->found.hidden);
    sn_json_integer(json, "surplus", result->found.surplus);
    sn_json_close(json);
}

/* ---- the history -------------------------------------------------------------------------------------------------------------- */

static bool names_list(const bone_list *list, const char *value) {
    for (size_t i = 0; i < list->count; i++)
        if (list->items[i].list != NULL && strcmp(list->items[i].list, value) == 0) return true;
    return false;
}

bool neighbours_listed(const neighbour_result *result, const char *value) {
    return names_list(&result->muscles, value) || names_list(&result->obstacles, value);
}

typedef struct text {
    size_t size, capacity;
    char *data;
} text;

static bool append(text *t, const void *data, size_t size) {
    if (!sn_grow((void **)&t->data, &t->capacity, t->size + size + 1, 1)) return false;
    if (size > 0) memcpy(t->data + t->size, data, size);
    t->size += size;
    return true;
}

/* A muscle's name and mesh: what else its document holds makes no difference, so that rigs may be made in any order. */
static bool append_mesh(text *t, const char *name, const sn_mesh *mesh) {
    char hash[SN_HASH_LENGTH];
    text bytes = {0};
    bool enough = append(&bytes, mesh->positions, (size_t)mesh->vertex_count * sizeof *mesh->positions) &&
                  append(&bytes, mesh->triangles, (size_t)mesh->triangle_count * sizeof *mesh->triangles);
    if (enough) sn_hash(bytes.data, bytes.size, hash);
    free(bytes.data);
    return enough && append(t, name, strlen(name)) && append(t, "\t", 1) && append(t, hash, strlen(hash)) && append(t, "\n", 1);
}

sn_status neighbours_hash(const neighbour_result *result, const char *value, char out[SN_HASH_LENGTH], sn_error *error) {
    text all = {0};
    bool enough = true;
    for (size_t i = 0; i < result->obstacles.count && enough; i++) {
        const bone *b = &result->obstacles.items[i];
        if (b->used && strcmp(b->list, value) == 0) enough = append_mesh(&all, b->name, &b->mesh);
    }
    for (size_t i = 0; i < result->target_count && enough; i++) {
        const neighbour_target *t = &result->targets[i];
        if (t->list != NULL && strcmp(t->list, value) == 0) enough = append_mesh(&all, t->name, &t->muscle.mesh);
    }
    if (enough) sn_hash(all.data != NULL ? all.data : "", all.size, out);
    free(all.data);
    return enough ? SN_OK : sn_fail_memory(error, "the history");
}
