/*
 * mesh-import.c -- the meshes of a glTF, FBX, Collada, 3DS, ... file as one binary PLY file, or its nodes and their animations as text;
 * the only user of assimp.
 *
 * Assimp crashes, hangs and eats memory on damaged files, so the other tools run this program as a child with limits (lib/io/import.c)
 * and believe nothing of its answer. Comments of the PLY file say what PLY cannot: the unit, the axis that is up, and which faces
 * belong to which mesh. Its numbers are assimp's, of single precision.
 */
#include "cli.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char *name; /* --name */
static bool motion;      /* --motion */

static const cli_option options[] = {
    {0, "motion", NULL, CLI_FLAG, &motion, 0, 0, 0, NULL, "write the nodes and their animations as text, in place of the meshes"},
    {0, "name", "FILE", CLI_TEXT, &name, 0, 0, 0, NULL, "what the standard input is called: for messages, and to find buffers beside it"},
};

static const cli_tool tool = {"mesh-import",
                              "turn the meshes of a glTF, FBX, Collada, 3DS, ... file into one PLY file",
                              CLI_TAKES_INPUT | CLI_HAS_OUTPUT,
                              options,
                              sizeof options / sizeof *options,
                              NULL,
                              ".ply"};

/* ---- the files that assimp may open: the input, and binary buffers beside it ----------------------------------------------- */

typedef struct opened {
    struct aiFile file; /* first: assimp holds a pointer to it */
    sn_blob blob;
    bool owned;
    size_t at;
} opened;

typedef struct folder {
    struct aiFileIO io; /* first */
    const sn_blob *input;
    char main_name[32]; /* what assimp calls the input */
} folder;

static opened *as_opened(struct aiFile *file) { return (opened *)(void *)file; }

static size_t read_items(struct aiFile *file, char *out, size_t size, size_t count) {
    opened *o = as_opened(file);
    size_t left = o->blob.size - o->at, items = size > 0 ? left / size : 0;
    if (items > count) items = count;
    if (items > 0) memcpy(out, o->blob.data + o->at, items * size);
    o->at += items * size;
    return items;
}

static size_t write_nothing(struct aiFile *file, const char *data, size_t size, size_t count) {
    (void)file, (void)data, (void)size, (void)count;
    return 0;
}

static size_t tell(struct aiFile *file) { return as_opened(file)->at; }
static size_t file_size(struct aiFile *file) { return as_opened(file)->blob.size; }
static void flush(struct aiFile *file) { (void)file; }

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin origin) {
    opened *o = as_opened(file);
    size_t base = origin == aiOrigin_CUR ? o->at : origin == aiOrigin_END ? o->blob.size : 0;
    size_t target = base + offset; /* wraps for steps back */
    if (target > o->blob.size) return aiReturn_FAILURE;
    o->at = target;
    return aiReturn_SUCCESS;
}

static int hexadecimal(char c) {
    const char *digits = "0123456789abcdef", *at = c != '\0' ? strchr(digits, c >= 'A' && c <= 'F' ? c + 32 : c) : NULL;
    return at != NULL ? (int)(at - digits) : -1;
}

/* A name as a uri has it, with %20 for a blank and so on, as it is in the folder (RFC 3986); false = it does not fit, or has a %00. */
static bool decode_uri(const char *uri, char *out, size_t size) {
    size_t length = 0;
    for (; *uri != '\0'; uri++) {
        int high = *uri == '%' ? hexadecimal(uri[1]) : -1, low = high >= 0 ? hexadecimal(uri[2]) : -1;
        if (length + 1 >= size || (low >= 0 && high + low == 0)) return false;
        out[length++] = low >= 0 ? (char)(16 * high + low) : *uri;
        if (low >= 0) uri += 2;
    }
    out[length] = '\0';
    return true;
}

/* A plain file of this name in the input's folder or below: its name ends in ".bin" or has no extension. */
static bool read_beside(const char *input, const char *wanted, sn_blob *out) {
    const char *slash = strrchr(input, '/'), *base = strrchr(wanted, '/'), *dot = strrchr(base != NULL ? base : wanted, '.');
    if (*wanted == '/' || strstr(wanted, "..") != NULL || (dot != NULL && strcmp(dot, ".bin") != 0)) return false;
    char path[4096];
    int length = snprintf(path, sizeof path, "%.*s%s", slash != NULL ? (int)(slash - input) + 1 : 0, input, wanted);
    struct stat info;
    if (length < 0 || (size_t)length >= sizeof path || stat(path, &info) != 0 || !S_ISREG(info.st_mode)) return false;
    return sn_blob_read_bytes(path, out, NULL) == SN_OK;
}

/* A buffer of a glTF file, by its uri; many programs write names there as they are. */
static bool read_buffer(const folder *f, const char *wanted, sn_blob *out) {
    char decoded[4096];
    if (strcmp(f->input->name, "<stdin>") == 0) return false;
    if (read_beside(f->input->name, wanted, out)) return true;
    return decode_uri(wanted, decoded, sizeof decoded) && read_beside(f->input->name, decoded, out);
}

static struct aiFile *open_file(struct aiFileIO *io, const char *wanted, const char *mode) {
    const folder *f = (const folder *)(void *)io;
    opened *o = SN_NEW(opened, 1);
    if (o == NULL || strchr(mode, 'w') != NULL) {
        free(o);
        return NULL;
    }
    while (strncmp(wanted, "./", 2) == 0) wanted += 2;
    o->file = (struct aiFile){.ReadProc = read_items,
                              .WriteProc = write_nothing,
                              .TellProc = tell,
                              .FileSizeProc = file_size,
                              .SeekProc = seek,
                              .FlushProc = flush};
    if (strcmp(wanted, f->main_name) == 0) {
        o->blob = *f->input;
        return &o->file;
    }
    o->owned = read_buffer(f, wanted, &o->blob);
    if (o->owned) return &o->file;
    free(o);
    return NULL;
}

static void close_file(struct aiFileIO *io, struct aiFile *file) {
    (void)io;
    opened *o = as_opened(file);
    if (o->owned) sn_blob_free(&o->blob);
    free(o);
}

/* ---- the meshes as they will be written ------------------------------------------------------------------------------------ */

/* One node of the scene with the meshes that hang on it. */
typedef struct part {
    char name[256];
    size_t triangles;
} part;

typedef struct vertex {
    double position[3];
    float colour[4]; /* 0 to 1; 1 where the mesh has none */
} vertex;

typedef struct meshes {
    sn_mesh_frame frame;
    vertex *vertices;
    size_t vertex_count, vertex_capacity;
    int32_t *faces; /* rows of a count and as many vertices */
    size_t face_count, face_words, face_capacity;
    part *parts;
    size_t part_count, part_capacity;
    bool coloured;
    /* vertices of the part with equal positions are one: open addressing, entries are vertex + 1, 0 = free */
    int32_t *slots;
    size_t slot_count;
} meshes;

static void free_meshes(meshes *m) {
    free(m->vertices);
    free(m->faces);
    free(m->parts);
    free(m->slots);
}

/* ---- welding: these formats give every corner of a face, or both sides of a seam of textures, a vertex of its own ---------- */

static uint64_t hash_position(const double *p) {
    uint64_t hash = 0;
    for (int k = 0; k < 3; k++) {
        uint64_t bits;
        memcpy(&bits, &p[k], sizeof bits);
        hash = (hash ^ bits) * 0x9e3779b97f4a7c15U;
        hash ^= hash >> 29;
    }
    return hash;
}

/* An empty table for `count` more vertices. */
static bool begin_weld(meshes *m, size_t count) {
    size_t size = 16;
    while (size < 2 * count) size *= 2;
    free(m->slots);
    m->slots = SN_NEW(int32_t, size);
    m->slot_count = m->slots != NULL ? size : 0;
    return m->slots != NULL;
}

/* The vertex of this part at the same position, else v itself, the last one. */
static size_t weld(meshes *m, size_t v) {
    const double *p = m->vertices[v].position;
    for (size_t i = hash_position(p) & (m->slot_count - 1);; i = (i + 1) & (m->slot_count - 1)) {
        if (m->slots[i] == 0) {
            m->slots[i] = (int32_t)v + 1;
            return v;
        }
        size_t other = (size_t)m->slots[i] - 1;
        if (memcmp(m->vertices[other].position, p, sizeof m->vertices[other].position) == 0) return other;
    }
}

/* ---- from assimp's scene ------------------------------------------------------------------------------------------------------ */

/* Products of single precision numbers in double precision: the identity changes nothing. */
typedef struct transform {
    double m[3][4];
} transform;

static transform to_transform(const struct aiMatrix4x4 *m) {
    return (transform){{{m->a1, m->a2, m->a3, m->a4}, {m->b1, m->b2, m->b3, m->b4}, {m->c1, m->c2, m->c3, m->c4}}};
}

static transform multiply(const transform *a, const transform *b) {
    transform c;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            c.m[i][j] = a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] + a->m[i][2] * b->m[2][j] + (j == 3 ? a->m[i][3] : 0.0);
    return c;
}

static double determinant(const transform *t) {
    const double(*m)[4] = t->m;
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

static float clamp_colour(float c) { return c >= 0.0f && c <= 1.0f ? c : c > 1.0f ? 1.0f : 0.0f; }

static vertex to_vertex(const struct aiMesh *mesh, unsigned i, const transform *t) {
    const struct aiVector3D p = mesh->mVertices[i];
    vertex v = {.colour = {1.0f, 1.0f, 1.0f, 1.0f}};
    for (int k = 0; k < 3; k++) /* adding zero makes -0 equal 0 */
        v.position[k] = t->m[k][0] * (double)p.x + t->m[k][1] * (double)p.y + t->m[k][2] * (double)p.z + t->m[k][3] + 0.0;
    if (mesh->mColors[0] == NULL) return v;
    const struct aiColor4D c = mesh->mColors[0][i];
    const float channels[4] = {c.r, c.g, c.b, c.a};
    for (int k = 0; k < 4; k++) v.colour[k] = clamp_colour(channels[k]);
    return v;
}

/* new_index (mNumVertices): where each vertex went. */
static sn_status add_vertices(meshes *m, const struct aiMesh *mesh, const transform *t, int32_t *new_index, sn_error *error) {
    if (!sn_grow((void **)&m->vertices, &m->vertex_capacity, m->vertex_count + mesh->mNumVertices, sizeof *m->vertices))
        return sn_fail_memory(error, "the vertices");
    for (unsigned i = 0; i < mesh->mNumVertices; i++) {
        m->vertices[m->vertex_count] = to_vertex(mesh, i, t);
        size_t at = weld(m, m->vertex_count);
        if (at == m->vertex_count) m->vertex_count++;
        new_index[i] = (int32_t)at;
    }
    m->coloured = m->coloured || mesh->mColors[0] != NULL;
    return SN_OK;
}

/* Points and lines are passed over. A mirrored mesh is turned, so that its outside stays outside. */
static sn_status add_face(meshes *m, const struct aiFace *face, unsigned vertex_count, bool mirrored, const int32_t *new_index,
                          sn_error *error) {
    unsigned corners = face->mNumIndices;
    if (corners < 3) return SN_OK;
    if (corners >= SN_INDEX_MAX || !sn_grow((void **)&m->faces, &m->face_capacity, m->face_words + corners + 1, sizeof *m->faces))
        return sn_fail_memory(error, "the faces");
    m->faces[m->face_words++] = (int32_t)corners;
    for (unsigned k = 0; k < corners; k++) {
        unsigned corner = face->mIndices[mirrored ? corners - 1 - k : k];
        if (corner >= vertex_count) return sn_fail(error, SN_ERROR_INPUT, "a face names vertex %u of %u", corner, vertex_count);
        m->faces[m->face_words++] = new_index[corner];
    }
    m->face_count++;
    m->parts[m->part_count - 1].triangles += corners - 2;
    return SN_OK;
}

static sn_status add_mesh(meshes *m, const struct aiMesh *mesh, const transform *t, sn_error *error) {
    int32_t *new_index = SN_NEW(int32_t, mesh->mNumVertices);
    if (new_index == NULL) return sn_fail_memory(error, "the vertices");
    bool mirrored = determinant(t) < 0.0;
    sn_status status = add_vertices(m, mesh, t, new_index, error);
    for (unsigned i = 0; i < mesh->mNumFaces && status == SN_OK; i++)
        status = add_face(m, &mesh->mFaces[i], mesh->mNumVertices, mirrored, new_index, error);
    free(new_index);
    return status;
}

/* ---- names ------------------------------------------------------------------------------------------------------------------- */

/* Names that assimp makes up for nodes that have none. */
static bool is_made_up(const struct aiString *text) {
    static const char *const names[] = {"", "RootNode", "ROOT"}, *const starts[] = {"nodes[", "$ColladaAutoName$", "<"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(text->data, names[i]) == 0) return true;
    for (size_t i = 0; i < sizeof starts / sizeof *starts; i++)
        if (strncmp(text->data, starts[i], strlen(starts[i])) == 0) return true;
    return false;
}

/* As one line, from `length` on. */
static size_t append_line(char *line, size_t length, size_t size, const char *text) {
    for (; *text != '\0' && length < size - 1; text++) {
        unsigned char c = (unsigned char)*text;
        line[length++] = c < ' ' || c == 0x7f ? '_' : (char)c;
    }
    line[length] = '\0';
    return length;
}

/* The node's name, or else its mesh's, as one line. */
static void name_part(part *p, const struct aiNode *node, const struct aiScene *scene) {
    const struct aiString *mesh = &scene->mMeshes[node->mMeshes[0]]->mName;
    const struct aiString *text = is_made_up(&node->mName) && mesh->length > 0 ? mesh : &node->mName;
    append_line(p->name, 0, sizeof p->name, text->data);
}

/* ---- parts of glTF, which sinew reads itself -------------------------------------------------------------------------------------- */

/* The node's name, or else its mesh's; instances are counted behind it. */
static void name_gltf_part(part *p, const sn_gltf_part *from) {
    char spare[32], number[16] = "";
    snprintf(spare, sizeof spare, "meshes[%d]", (int)from->mesh);
    if (from->instance != SN_NONE) snprintf(number, sizeof number, " %d", (int)from->instance + 1);
    const char *text = *from->node_name != '\0' ? from->node_name : *from->mesh_name != '\0' ? from->mesh_name : spare;
    size_t length = append_line(p->name, 0, sizeof p->name - strlen(number), text);
    append_line(p->name, length, sizeof p->name, number);
}

static sn_status weld_gltf_part(meshes *m, const sn_gltf_part *from, int32_t *new_index, sn_error *error) {
    size_t count = (size_t)from->vertex_count;
    if (!begin_weld(m, count) || !sn_grow((void **)&m->vertices, &m->vertex_capacity, m->vertex_count + count, sizeof *m->vertices))
        return sn_fail_memory(error, "the vertices");
    for (size_t i = 0; i < count; i++) {
        vertex *v = &m->vertices[m->vertex_count];
        *v = (vertex){.colour = {1.0f, 1.0f, 1.0f, 1.0f}};
        memcpy(v->position, from->positions + 3 * i, sizeof v->position);
        if (from->colours != NULL) memcpy(v->colour, from->colours + 4 * i, sizeof v->colour);
        size_t at = weld(m, m->vertex_count);
        if (at == m->vertex_count) m->vertex_count++;
        new_index[i] = (int32_t)at;
    }
    m->coloured = m->coloured || from->colours != NULL;
    return SN_OK;
}

static sn_status add_gltf_faces(meshes *m, const sn_gltf_part *from, const int32_t *new_index, sn_error *error) {
    size_t triangles = (size_t)from->corner_count / 3;
    if (!sn_grow((void **)&m->faces, &m->face_capacity, m->face_words + 4 * triangles, sizeof *m->faces))
        return sn_fail_memory(error, "the faces");
    for (size_t i = 0; i < triangles; i++) {
        m->faces[m->face_words++] = 3;
        for (size_t k = 0; k < 3; k++) m->faces[m->face_words++] = new_index[from->corners[3 * i + k]];
    }
    m->face_count += triangles;
    m->parts[m->part_count++].triangles = triangles;
    return SN_OK;
}

static sn_status take_gltf_part(void *context, const sn_gltf_part *from, sn_error *error) {
    meshes *m = context;
    if (m->vertex_count + (size_t)from->vertex_count >= SN_INDEX_MAX || m->face_count + (size_t)from->corner_count >= SN_INDEX_MAX)
        return sn_fail(error, SN_ERROR_INPUT, "the file has more vertices or faces than sinew can count");
    int32_t *new_index = SN_NEW(int32_t, from->vertex_count);
    if (new_index == NULL || !sn_grow((void **)&m->parts, &m->part_capacity, m->part_count + 1, sizeof *m->parts)) {
        free(new_index);
        return sn_fail_memory(error, "the meshes");
    }
    name_gltf_part(&m->parts[m->part_count], from);
    sn_status status = weld_gltf_part(m, from, new_index, error);
    if (status == SN_OK) status = add_gltf_faces(m, from, new_index, error);
    free(new_index);
    return status;
}

static bool read_gltf_buffer(const void *context, const char *uri, sn_blob *out) {
    const folder f = {.input = context};
    return read_buffer(&f, uri, out);
}

/* ---- nodes by name, and where bones have their meshes --------------------------------------------------------------------------- */

typedef struct listing {
    const struct aiNode **nodes; /* parents before children */
    int *parents, *sorted;       /* sorted: by name */
    size_t count, capacity;
} listing;

static void free_listing(listing *l) {
    free(l->nodes);
    free(l->parents);
    free(l->sorted);
}

static bool add_listed(listing *l, const struct aiNode *node, int parent) {
    size_t other = l->capacity;
    if (l->count >= SN_INDEX_MAX || !sn_grow((void **)&l->parents, &other, l->count + 1, sizeof *l->parents) ||
        !sn_grow((void **)&l->nodes, &l->capacity, l->count + 1, sizeof *l->nodes))
        return false;
    l->parents[l->count] = parent;
    l->nodes[l->count++] = node;
    return true;
}

static const listing *sorting; /* what qsort's and bsearch's comparison looks at */

static int compare_names(const void *a, const void *b) {
    int i = *(const int *)a, j = *(const int *)b, order = strcmp(sorting->nodes[i]->mName.data, sorting->nodes[j]->mName.data);
    return order != 0 ? order : (i > j) - (i < j);
}

static int compare_with_name(const void *text, const void *b) { return strcmp(text, sorting->nodes[*(const int *)b]->mName.data); }

/* Level by level, without a stack. */
static sn_status list_nodes(const struct aiScene *scene, listing *l, sn_error *error) {
    bool enough = add_listed(l, scene->mRootNode, -1);
    for (size_t i = 0; i < l->count && enough; i++)
        for (unsigned k = 0; k < l->nodes[i]->mNumChildren && enough; k++) enough = add_listed(l, l->nodes[i]->mChildren[k], (int)i);
    if (enough) enough = (l->sorted = SN_NEW(int, l->count)) != NULL;
    if (!enough) return sn_fail_memory(error, "the nodes");
    for (size_t i = 0; i < l->count; i++) l->sorted[i] = (int)i;
    sorting = l;
    qsort(l->sorted, l->count, sizeof *l->sorted, compare_names);
    return SN_OK;
}

/* *out is -1 where there is none. Assimp's animations name nodes, which fits one only where names are distinct. */
static sn_status find_node(const listing *l, const struct aiString *text, int *out, sn_error *error) {
    sorting = l;
    const int *at = bsearch(text->data, l->sorted, l->count, sizeof *l->sorted, compare_with_name);
    *out = at != NULL ? *at : -1;
    if (at == NULL) return SN_OK;
    size_t i = (size_t)(at - l->sorted);
    bool twin = (i > 0 && compare_with_name(text->data, at - 1) == 0) || (i + 1 < l->count && compare_with_name(text->data, at + 1) == 0);
    if (!twin) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT, "an animation or a skin names the node \"%.100s\", and more than one is called so; rename them",
                   text->data);
}

/* Where the node is in the world, at rest. */
static transform world_of(const listing *l, int node) {
    transform t = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    for (; node >= 0; node = l->parents[node]) {
        transform own = to_transform(&l->nodes[node]->mTransformation);
        t = multiply(&own, &t);
    }
    return t;
}

/* Does one of its weights count? */
static bool carries(const struct aiBone *bone) {
    for (unsigned i = 0; i < bone->mNumWeights; i++)
        if (bone->mWeights[i].mWeight > 0.0f) return true;
    return false;
}

static int depth_of(const listing *l, int node) {
    int depth = 0;
    for (; node >= 0; node = l->parents[node]) depth++;
    return depth;
}

/* Where a bone has the mesh: its place in the world times its offset, which takes the mesh to it. */
static sn_status place_by_bone(const listing *l, const struct aiBone *bone, transform *out, int *depth, sn_error *error) {
    int node;
    sn_status status = find_node(l, &bone->mName, &node, error);
    if (status == SN_OK && node < 0)
        status = sn_fail(error, SN_ERROR_INPUT, "a skin names the joint '%.100s', which is not in its scene; export both together",
                         bone->mName.data);
    if (status != SN_OK) return status;
    transform world = world_of(l, node), offset = to_transform(&bone->mOffsetMatrix);
    *out = multiply(&world, &offset);
    *depth = depth_of(l, node);
    return SN_OK;
}

/* Offsets are single precision: placements are one within this times their size. */
static bool differ(const transform *a, const transform *b) {
    double size[2] = {0.0, 0.0}, difference[2] = {0.0, 0.0}; /* of the matrix, of the translation */
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            size[j == 3] = fmax(size[j == 3], fmax(fabs(a->m[i][j]), fabs(b->m[i][j])));
            difference[j == 3] = fmax(difference[j == 3], fabs(a->m[i][j] - b->m[i][j]));
        }
    return difference[0] > 1e-4 * size[0] || difference[1] > 1e-4 * fmax(size[0], size[1]);
}

/* By the uppermost bone that carries something, of all where none does; *posed: others have it elsewhere. */
static sn_status place_by_bones(const listing *l, const struct aiMesh *mesh, transform *out, bool *posed, sn_error *error) {
    bool any = false, begun = false;
    int least = 0;
    for (unsigned b = 0; b < mesh->mNumBones && !any; b++) any = carries(mesh->mBones[b]);
    *posed = false;
    for (unsigned b = 0; b < mesh->mNumBones; b++) {
        transform t;
        int depth;
        if (any && !carries(mesh->mBones[b])) continue;
        sn_status status = place_by_bone(l, mesh->mBones[b], &t, &depth, error);
        if (status != SN_OK) return status;
        *posed = *posed || (begun && differ(out, &t));
        if (!begun || depth < least) *out = t, least = depth;
        begun = true;
    }
    return SN_OK;
}

/* ---- nodes --------------------------------------------------------------------------------------------------------------------- */

/* A scene of assimp's, and what is known of it besides. */
typedef struct source {
    const struct aiScene *scene;
    listing nodes;
    bool skins_place; /* skins and not nodes say where their meshes are: Collada, glTF */
    bool *placed;     /* (meshes of the scene) skinned ones that were met */
} source;

static void free_source(source *s) {
    free_listing(&s->nodes);
    free(s->placed);
    if (s->scene != NULL) aiReleaseImport(s->scene);
    *s = (source){0};
}

/* Where a mesh of a node is, t being the node's place. Of one skin on two nodes assimp tells one skeleton: the other's place is lost. */
static sn_status place_mesh(const source *from, unsigned index, const transform *t, transform *out, sn_error *error) {
    const struct aiMesh *mesh = from->scene->mMeshes[index];
    bool posed = false;
    *out = *t;
    if (!from->skins_place || mesh->mNumBones == 0) return SN_OK;
    if (from->placed[index])
        return sn_fail(error, SN_ERROR_INPUT, "the skinned mesh '%.100s' is in the scene twice, which is not read right; export two meshes",
                       mesh->mName.data);
    from->placed[index] = true;
    sn_status status = place_by_bones(&from->nodes, mesh, out, &posed, error);
    if (status == SN_OK && posed)
        sn_log(SN_LOG_WARNING,
               "the joints of '%.100s' are not as its skin was bound: the mesh is as bound, where its uppermost joint has it",
               mesh->mName.data);
    return status;
}

/* FBX: a lone shape has a weight of 1 in assimp 5.2, whatever the file says. */
static void warn_shapes(const struct aiMesh *mesh) {
    bool mixed = false;
    for (unsigned i = 0; i < mesh->mNumAnimMeshes; i++)
        mixed = mixed || (mesh->mNumAnimMeshes > 1 && mesh->mAnimMeshes[i]->mWeight != 0.0f);
    if (mixed)
        sn_log(SN_LOG_WARNING, "shapes that the file mixes into '%.100s' are left out; apply them and export again", mesh->mName.data);
}

static sn_status add_placed(meshes *m, const source *from, unsigned index, const transform *t, sn_error *error) {
    transform own;
    sn_status status = place_mesh(from, index, t, &own, error);
    warn_shapes(from->scene->mMeshes[index]);
    return status == SN_OK ? add_mesh(m, from->scene->mMeshes[index], &own, error) : status;
}

/* All meshes on a node, one for each of its materials, are one part: they share borders. */
static sn_status add_node_meshes(meshes *m, const source *from, const struct aiNode *node, const transform *t, sn_error *error) {
    const struct aiScene *scene = from->scene;
    size_t vertices = m->vertex_count;
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        if (node->mMeshes[i] >= scene->mNumMeshes)
            return sn_fail(error, SN_ERROR_INPUT, "a node names mesh %u of %u", node->mMeshes[i], scene->mNumMeshes);
        vertices += scene->mMeshes[node->mMeshes[i]]->mNumVertices;
    }
    if (vertices >= SN_INDEX_MAX) return sn_fail(error, SN_ERROR_INPUT, "the file has more vertices than sinew can count");
    if (!begin_weld(m, vertices - m->vertex_count) || !sn_grow((void **)&m->parts, &m->part_capacity, m->part_count + 1, sizeof *m->parts))
        return sn_fail_memory(error, "the meshes");
    m->parts[m->part_count] = (part){0};
    name_part(&m->parts[m->part_count++], node, scene);
    sn_status status = SN_OK;
    for (unsigned i = 0; i < node->mNumMeshes && status == SN_OK; i++) status = add_placed(m, from, node->mMeshes[i], t, error);
    if (status == SN_OK && m->parts[m->part_count - 1].triangles == 0) m->part_count--;
    return status;
}

static sn_status add_node(meshes *m, const source *from, const struct aiNode *node, const transform *parent, sn_error *error) {
    transform own = to_transform(&node->mTransformation), t = multiply(parent, &own);
    sn_status status = node->mNumMeshes > 0 ? add_node_meshes(m, from, node, &t, error) : SN_OK;
    for (unsigned i = 0; i < node->mNumChildren && status == SN_OK; i++) status = add_node(m, from, node->mChildren[i], &t, error);
    return status;
}

/* ---- unit and axis --------------------------------------------------------------------------------------------------------------- */

/* Single precision made of a decimal: the shortest decimal is meant. */
static double shortest(double value) {
    char text[32];
    snprintf(text, sizeof text, "%.7g", value);
    return strtod(text, NULL);
}

static bool equal_rotation(const transform *t, double scale, const double rotation[3][3]) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            if (fabs(t->m[i][j] - (j < 3 ? scale * rotation[i][j] : 0.0)) > 1e-6 * scale) return false;
    return true;
}

/* z up turned to y up, as assimp does in Collada's and 3DS's root node. */
static const double z_to_y[3][3] = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
static const double identity[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* Assimp scales and turns Collada files to metres and y up by the root node: taken out again, so that coordinates are the file's. */
static void take_collada_frame(struct aiNode *root, sn_mesh_frame *frame) {
    transform t = to_transform(&root->mTransformation);
    double scale = sqrt(t.m[0][0] * t.m[0][0] + t.m[1][0] * t.m[1][0] + t.m[2][0] * t.m[2][0]);
    bool up_z = equal_rotation(&t, scale, z_to_y), up_y = equal_rotation(&t, scale, identity);
    *frame = (sn_mesh_frame){1.0, SN_UP_Y, SN_SPACE_UNKNOWN};
    if (!(scale > 0.0) || (!up_z && !up_y)) return;
    *frame = (sn_mesh_frame){shortest(scale), up_z ? SN_UP_Z : SN_UP_Y, SN_SPACE_UNKNOWN};
    root->mTransformation = (struct aiMatrix4x4){1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
}

static void take_3ds_frame(struct aiNode *root, sn_mesh_frame *frame) {
    transform t = to_transform(&root->mTransformation);
    *frame = (sn_mesh_frame){0.0, SN_UP_Z, SN_SPACE_UNKNOWN};
    if (equal_rotation(&t, 1.0, z_to_y)) root->mTransformation = (struct aiMatrix4x4){1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
}

static double metadata_number(const struct aiScene *scene, const char *key, double otherwise) {
    for (unsigned i = 0; scene->mMetaData != NULL && i < scene->mMetaData->mNumProperties; i++) {
        const struct aiMetadataEntry *entry = &scene->mMetaData->mValues[i];
        if (strcmp(scene->mMetaData->mKeys[i].data, key) != 0 || entry->mData == NULL) continue;
        if (entry->mType == AI_FLOAT) return (double)*(const float *)entry->mData;
        if (entry->mType == AI_DOUBLE) return *(const double *)entry->mData;
        if (entry->mType == AI_INT32) return (double)*(const int32_t *)entry->mData;
    }
    return otherwise;
}

/* FBX counts in centimetres times UnitScaleFactor; UpAxis is 0, 1, 2 for x, y, z. */
static void take_fbx_frame(const struct aiScene *scene, sn_mesh_frame *frame) {
    double factor = metadata_number(scene, "UnitScaleFactor", 0.0), up = metadata_number(scene, "UpAxis", -1.0);
    if (factor > 0.0 && isfinite(factor)) frame->meters_per_unit = shortest(0.01 * factor);
    frame->up = up == 1.0 ? SN_UP_Y : up == 2.0 ? SN_UP_Z : SN_UP_UNKNOWN;
}

static bool is_gltf(const char *kind) { return kind != NULL && (strcmp(kind, "glb") == 0 || strcmp(kind, "gltf") == 0); }

static void take_frame(const struct aiScene *scene, const char *kind, sn_mesh_frame *frame) {
    if (is_gltf(kind)) *frame = (sn_mesh_frame){1.0, SN_UP_Y, SN_SPACE_UNKNOWN}; /* by its specification */
    if (strcmp(kind, "dae") == 0) take_collada_frame(scene->mRootNode, frame);
    if (strcmp(kind, "3ds") == 0) take_3ds_frame(scene->mRootNode, frame);
    if (strcmp(kind, "fbx") == 0) take_fbx_frame(scene, frame);
}

/* ---- import ------------------------------------------------------------------------------------------------------------------------ */

static const struct aiScene *load(folder *f, const char *kind) {
    struct aiPropertyStore *properties = aiCreatePropertyStore();
    if (properties == NULL) return NULL;
    static const char *const off[] = {AI_CONFIG_IMPORT_FBX_READ_MATERIALS, AI_CONFIG_IMPORT_FBX_READ_TEXTURES,
                                      AI_CONFIG_IMPORT_FBX_READ_CAMERAS, AI_CONFIG_IMPORT_FBX_READ_LIGHTS};
    for (size_t i = 0; i < sizeof off / sizeof *off; i++) aiSetImportPropertyInteger(properties, off[i], 0);
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_FBX_READ_ANIMATIONS, motion);
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_FBX_READ_WEIGHTS, motion);
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_NO_SKELETON_MESHES, 1);
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, 1);
    f->io = (struct aiFileIO){.OpenProc = open_file, .CloseProc = close_file};
    snprintf(f->main_name, sizeof f->main_name, "input.%s", kind);
    const struct aiScene *scene = aiImportFileExWithProperties(f->main_name, aiProcess_ValidateDataStructure, &f->io, properties);
    aiReleasePropertyStore(properties);
    return scene;
}

/* Assimp's words, or ours where it only says that none of its importers feels called. */
static sn_status fail_import(const char *kind, const char *words, sn_error *error) {
    const char *format = sn_import_format_name(kind);
    if (*words == '\0' || strstr(words, "No suitable reader") != NULL)
        return sn_fail(error, SN_ERROR_INPUT, "begins like a %s file but does not go on like one; it is damaged or cut short", format);
    return sn_fail(error, SN_ERROR_INPUT, "cannot be imported as %s: %s", format, words);
}

/* The scene of a file; its root node without the turn and the scale that assimp has put there. Free it also on failure. */
static sn_status open_scene(const sn_blob *input, source *out, sn_mesh_frame *frame, sn_error *error) {
    const char *kind = sn_import_detect(input);
    if (kind == NULL) return sn_fail(error, SN_ERROR_INPUT, "is in no format that can be imported; glTF, FBX, Collada and 3DS are some");
    folder f = {.input = input};
    sn_status status = strcmp(kind, "dae") == 0 ? sn_collada_check(input, !motion, error) : SN_OK;
    if (status != SN_OK) return status;
    out->scene = load(&f, kind);
    if (out->scene == NULL) return fail_import(kind, aiGetErrorString(), error);
    out->skins_place = strcmp(kind, "dae") == 0 || is_gltf(kind);
    out->placed = SN_NEW(bool, out->scene->mNumMeshes);
    if (out->placed == NULL) return sn_fail_memory(error, "the meshes");
    take_frame(out->scene, kind, frame);
    return list_nodes(out->scene, &out->nodes, error);
}

static sn_status import_scene(const sn_blob *input, meshes *out, sn_error *error) {
    static const transform world = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    source from = {0};
    sn_status status = open_scene(input, &from, &out->frame, error);
    if (status == SN_OK) status = add_node(out, &from, from.scene->mRootNode, &world, error);
    free_source(&from);
    return status;
}

/* In metres and y up by its specification. */
static sn_status import_gltf(const sn_blob *input, meshes *out, sn_error *error) {
    const sn_gltf_source from = {input, read_gltf_buffer, input};
    out->frame = (sn_mesh_frame){1.0, SN_UP_Y, SN_SPACE_UNKNOWN};
    sn_status status = sn_gltf_read(&from, take_gltf_part, out, error);
    if (status != SN_OK) error->line = error->column = 0; /* within the JSON of a GLB, of a file of one line: its path says more */
    return status;
}

static sn_status import(const sn_blob *input, meshes *out, sn_error *error) {
    sn_status status =
        is_gltf(sn_import_detect(input)) && !sn_gltf_is_old(input) ? import_gltf(input, out, error) : import_scene(input, out, error);
    if (status == SN_OK && out->face_count == 0)
        status = sn_fail(error, SN_ERROR_INPUT, "holds no surface: no mesh of triangles or polygons is in its scene");
    return status;
}

/* ---- writing ----------------------------------------------------------------------------------------------------------------------- */

/* Are all colours whole 255ths? */
static bool are_bytes(const meshes *m) {
    for (size_t i = 0; i < m->vertex_count; i++)
        for (int k = 0; k < 4; k++)
            if (fabsf(m->vertices[i].colour[k] * 255.0f - roundf(m->vertices[i].colour[k] * 255.0f)) > 1e-3f) return false;
    return true;
}

static void write_header(const meshes *m, bool bytes, sn_output *output) {
    static const char *const channels[] = {"red", "green", "blue", "alpha"};
    const uint16_t one = 1;
    sn_output_print(output, "ply\nformat binary_%s_endian 1.0\n", *(const unsigned char *)&one == 1 ? "little" : "big");
    if (m->frame.meters_per_unit > 0.0) sn_output_print(output, "comment metersPerUnit %.17g\n", m->frame.meters_per_unit);
    if (m->frame.up != SN_UP_UNKNOWN) sn_output_print(output, "comment up %c\n", m->frame.up == SN_UP_Y ? 'y' : 'z');
    for (size_t i = 0; i < m->part_count; i++) sn_output_print(output, "comment mesh %zu %s\n", m->parts[i].triangles, m->parts[i].name);
    sn_output_print(output, "element vertex %zu\nproperty double x\nproperty double y\nproperty double z\n", m->vertex_count);
    for (int k = 0; m->coloured && k < 4; k++) sn_output_print(output, "property %s %s\n", bytes ? "uchar" : "float", channels[k]);
    sn_output_print(output, "element face %zu\nproperty list int int vertex_indices\nend_header\n", m->face_count);
}

static sn_status write_ply(const meshes *m, sn_output *output, sn_error *error) {
    bool bytes = m->coloured && are_bytes(m);
    write_header(m, bytes, output);
    for (size_t i = 0; i < m->vertex_count; i++) {
        const vertex *v = &m->vertices[i];
        sn_output_write(output, v->position, sizeof v->position, NULL);
        if (m->coloured && !bytes) sn_output_write(output, v->colour, sizeof v->colour, NULL);
        for (int k = 0; bytes && k < 4; k++) {
            unsigned char c = (unsigned char)roundf(v->colour[k] * 255.0f);
            sn_output_write(output, &c, 1, NULL);
        }
    }
    return sn_output_write(output, m->faces, m->face_words * sizeof *m->faces, error);
}

static sn_status convert(cli *c, const sn_blob *input, sn_error *error) {
    meshes m = {0};
    sn_output *output = NULL;
    sn_status status = import(input, &m, error);
    if (status == SN_OK) status = sn_output_open(c->output, false, &output, error);
    if (status == SN_OK && sn_output_is_terminal(output))
        status = sn_fail(error, SN_ERROR_USAGE, "PLY is binary and not for a terminal; use --output");
    if (status == SN_OK) status = write_ply(&m, output, error);
    if (status == SN_OK)
        status = sn_output_commit(output, error);
    else
        sn_output_abort(output);
    free_meshes(&m);
    return status;
}

/* ---- nodes and animations ----------------------------------------------------------------------------------------------------------
 *
 * Text, a line for each thing: "sinew-nodes 1"; "metersPerUnit NUMBER", "up y" where they are known; "node PARENT NAME" (-1 = none), the
 * twelve numbers of its transform to its parent behind it; "bind NODE" and twelve numbers: where a bone is in the world as its mesh was
 * bound; "animation TICKS CHANNELS NAME", and for each channel "channel NODE POSITIONS ROTATIONS SCALES", then so many lines of a time in
 * ticks and three or four numbers (w x y z); "end". A node is -1 where the scene has none of its name.
 */

static void write_name(const struct aiString *text, sn_output *output) {
    char line[sizeof text->data + 1] = " ";
    size_t length = append_line(line, 1, sizeof line, text->data);
    sn_output_write(output, line, length, NULL);
}

static void write_transform(const transform *t, sn_output *output) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) sn_output_print(output, "%s%.17g", i + j > 0 ? " " : "", t->m[i][j]);
    sn_output_print(output, "\n");
}

static void write_nodes(const listing *l, sn_output *output) {
    for (size_t i = 0; i < l->count; i++) {
        transform t = to_transform(&l->nodes[i]->mTransformation);
        sn_output_print(output, "node %d", l->parents[i]);
        write_name(&l->nodes[i]->mName, output);
        sn_output_print(output, "\n");
        write_transform(&t, output);
    }
}

/* The inverse of what is affine; zeros where there is none. */
static transform invert(const transform *t) {
    const double(*m)[4] = t->m;
    double d = determinant(t);
    transform out = {{{0}}};
    if (d == 0.0) return out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int a = (j + 1) % 3, b = (j + 2) % 3, u = (i + 1) % 3, v = (i + 2) % 3;
            out.m[i][j] = (m[a][u] * m[b][v] - m[a][v] * m[b][u]) / d;
        }
    for (int i = 0; i < 3; i++) out.m[i][3] = -(out.m[i][0] * m[0][3] + out.m[i][1] * m[1][3] + out.m[i][2] * m[2][3]);
    return out;
}

/* The bones of the meshes of one node. A bone's offset takes the mesh to the bone, as they were when the mesh was bound; the mesh is where
 * the meshes have it that are written without --motion. */
static sn_status write_binds(const source *from, int node, sn_output *output, sn_error *error) {
    const struct aiNode *holder = from->nodes.nodes[node];
    transform world = holder->mNumMeshes > 0 ? world_of(&from->nodes, node) : (transform){{{0}}}, place;
    for (unsigned k = 0; k < holder->mNumMeshes; k++) {
        if (holder->mMeshes[k] >= from->scene->mNumMeshes) return sn_fail(error, SN_ERROR_INPUT, "a node names a mesh that is not there");
        const struct aiMesh *mesh = from->scene->mMeshes[holder->mMeshes[k]];
        if (from->placed[holder->mMeshes[k]]) continue; /* its bones are told */
        sn_status status = place_mesh(from, holder->mMeshes[k], &world, &place, error);
        for (unsigned b = 0; b < mesh->mNumBones && status == SN_OK; b++) {
            int bone;
            transform offset = to_transform(&mesh->mBones[b]->mOffsetMatrix), inverse = invert(&offset), bind = multiply(&place, &inverse);
            status = find_node(&from->nodes, &mesh->mBones[b]->mName, &bone, error);
            if (status != SN_OK) return status;
            sn_output_print(output, "bind %d\n", bone);
            write_transform(&bind, output);
        }
        if (status != SN_OK) return status;
    }
    return SN_OK;
}

static void write_vectors(const struct aiVectorKey *keys, unsigned count, sn_output *output) {
    for (unsigned i = 0; i < count; i++) {
        const struct aiVector3D v = keys[i].mValue;
        sn_output_print(output, "%.17g %.9g %.9g %.9g\n", keys[i].mTime, (double)v.x, (double)v.y, (double)v.z);
    }
}

static sn_status write_channel(const listing *l, const struct aiNodeAnim *channel, sn_output *output, sn_error *error) {
    int node;
    sn_status status = find_node(l, &channel->mNodeName, &node, error);
    if (status != SN_OK) return status;
    sn_output_print(output, "channel %d %u %u %u\n", node, channel->mNumPositionKeys, channel->mNumRotationKeys, channel->mNumScalingKeys);
    write_vectors(channel->mPositionKeys, channel->mNumPositionKeys, output);
    for (unsigned i = 0; i < channel->mNumRotationKeys; i++) {
        const struct aiQuaternion q = channel->mRotationKeys[i].mValue;
        sn_output_print(output, "%.17g %.9g %.9g %.9g %.9g\n", channel->mRotationKeys[i].mTime, (double)q.w, (double)q.x, (double)q.y,
                        (double)q.z);
    }
    write_vectors(channel->mScalingKeys, channel->mNumScalingKeys, output);
    return SN_OK;
}

static sn_status write_animations(const listing *l, const struct aiScene *scene, sn_output *output, sn_error *error) {
    sn_status status = SN_OK;
    for (unsigned i = 0; i < scene->mNumAnimations && status == SN_OK; i++) {
        const struct aiAnimation *animation = scene->mAnimations[i];
        sn_output_print(output, "animation %.17g %u", animation->mTicksPerSecond, animation->mNumChannels);
        write_name(&animation->mName, output);
        sn_output_print(output, "\n");
        for (unsigned k = 0; k < animation->mNumChannels && status == SN_OK; k++)
            status = write_channel(l, animation->mChannels[k], output, error);
    }
    return status;
}

static sn_status write_motion(const source *from, const sn_mesh_frame *frame, sn_output *output, sn_error *error) {
    sn_status status = SN_OK;
    sn_output_print(output, "sinew-nodes 1\n");
    if (frame->meters_per_unit > 0.0) sn_output_print(output, "metersPerUnit %.17g\n", frame->meters_per_unit);
    if (frame->up != SN_UP_UNKNOWN) sn_output_print(output, "up %c\n", frame->up == SN_UP_Y ? 'y' : 'z');
    write_nodes(&from->nodes, output);
    for (size_t i = 0; i < from->nodes.count && status == SN_OK; i++) status = write_binds(from, (int)i, output, error);
    if (status == SN_OK) status = write_animations(&from->nodes, from->scene, output, error);
    return status == SN_OK ? sn_output_print(output, "end\n") : status;
}

/* "skin": and "skins": of the JSON get names that mean nothing, in place, so that its nodes have none. */
static void hide_skins(sn_blob *input) {
    static const char *const keys[] = {"\"skin\"", "\"skins\""};
    for (int k = 0; k < 2; k++) {
        size_t length = strlen(keys[k]);
        char *end = input->data + input->size;
        for (char *at = input->data; (at = memmem(at, (size_t)(end - at), keys[k], length)) != NULL; at++) {
            const char *next = at + length;
            while (next < end && strchr(" \t\r\n", *next) != NULL && *next != '\0') next++;
            if (next < end && *next == ':') at[1] = 'x';
        }
    }
}

/* Assimp dies on a skin without inverse bind matrices; where they are not told, no bone is bound. */
static sn_status prepare_motion(sn_blob *input, sn_error *error) {
    bool unbound = false;
    if (!is_gltf(sn_import_detect(input)) || sn_gltf_is_old(input)) return SN_OK;
    sn_status status = sn_gltf_check(input, &unbound, error);
    if (status == SN_OK && unbound) hide_skins(input);
    return status;
}

static sn_status convert_motion(cli *c, sn_blob *input, sn_error *error) {
    source from = {0};
    sn_mesh_frame frame = {0};
    sn_output *output = NULL;
    sn_status status = prepare_motion(input, error);
    if (status == SN_OK) status = open_scene(input, &from, &frame, error);
    if (status == SN_OK) status = sn_output_open(c->output, false, &output, error);
    if (status == SN_OK) status = write_motion(&from, &frame, output, error);
    if (status == SN_OK)
        status = sn_output_commit(output, error);
    else
        sn_output_abort(output);
    free_source(&from);
    return status;
}

int main(int argc, char **argv) {
    cli c;
    sn_blob input = {0};
    sn_error error = {0};
    cli_start(&c, &tool, argc, argv);
    sn_status status = sn_blob_read(c.inputs.items[0], &input, &error);
    if (status == SN_OK && name != NULL) {
        free(input.name);
        if ((input.name = sn_strdup(name)) == NULL) status = sn_fail_memory(&error, "a file name");
    }
    if (status == SN_OK) status = motion ? convert_motion(&c, &input, &error) : convert(&c, &input, &error);
    if (status != SN_OK) sn_error_set_file(&error, input.name);
    sn_blob_free(&input);
    return cli_finish(&c, status, &error);
}
