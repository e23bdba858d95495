/* test_document.c -- the muscle document: what is read is written back; what is stale is dropped; what is wrong is named. */
#include "documents.h"

/* A tetrahedron with everything a document can hold, and members that sinew does not know. */
static const char *const full =
    "{\n"
    "  \"format\": \"sinew-muscle\",\n"
    "  \"version\": 1,\n"
    "  \"name\": \"biceps\",\n"
    "  \"metersPerUnit\": 0.001,\n"
    "  \"mesh\": {\n"
    "    \"vertices\": [0,0,0,1,0,0,0,1,0,0.10000000000000001,0.2,0.3],\n"
    "    \"triangles\": [0,2,1,0,1,3,1,2,3,0,3,2],\n"
    "    \"attributes\": {\n"
    "      \"paint\": {\n"
    "        \"components\": 1,\n"
    "        \"integer\": false,\n"
    "        \"values\": [0,0.5,1,0.25]\n"
    "      }\n"
    "    },\n"
    "    \"groups\": {\n"
    "      \"names\": [\"belly\",\"tendon\"],\n"
    "      \"triangles\": [0,1,-1,0]\n"
    "    }\n"
    "  },\n"
    "  \"roots\": {\n"
    "    \"vertices\": [2,0],\n"
    "    \"rule\": \"plane\"\n"
    "  },\n"
    "  \"structure\": {\n"
    "    \"samples\": [\n"
    "      {\"position\": [0.1,0.2,0.1], \"parent\": -1, \"branch\": 0, \"axis\": [0,0,1], \"vertices\": [0,3]},\n"
    "      {\"position\": [0.3,0.2,0.1], \"parent\": 0, \"branch\": 1, \"axis\": [0,0,1], \"vertices\": [1,2]}\n"
    "    ],\n"
    "    \"spacing\": 0.5\n"
    "  },\n"
    "  \"fibers\": {\n"
    "    \"directions\": [0,0,1,0,0,1,0,0,1,0,0,1],\n"
    "    \"field\": \"tree\",\n"
    "    \"polylines\": [\n"
    "      {\"points\": [0,0,0,0,0,1]}\n"
    "    ]\n"
    "  },\n"
    "  \"attachments\": [\n"
    "    {\"bone\": \"humerus\", \"vertices\": [0,2], \"method\": \"contact\", \"distances\": [0.1,-0.2], "
    "\"reasons\": [5,3], \"confidence\": [0.25,1]},\n"
    "    {\"bone\": \"radius\", \"vertices\": []}\n"
    "  ],\n"
    "  \"externals\": [\n"
    "    {\"target\": \"triceps\", \"fascia\": \"deep\", \"vertices\": [1,3], \"triangles\": [7,8], "
    "\"barycentric\": [1,0,0,0.5,0.25,0.25], \"distances\": [0.5,-0.1], \"minimumDistances\": [0.2,-0.1], "
    "\"weights\": [1,0,0,0.5,0.25,0]}\n"
    "  ],\n"
    "  \"omega\": [[1,2.50],\"a\",null],\n"
    "  \"x-studio\": {\n"
    "    \"shot\": 12\n"
    "  },\n"
    "  \"history\": [\n"
    "    {\"tool\": \"mesh-clean\", \"version\": \"0.0.9\", \"args\": [\"--weld\",\"0\"], \"more\": true}\n"
    "  ]\n"
    "}\n";

typedef struct held {
    sn_muscle muscle;
    sn_document *document;
} held;

static held read_text(const char *text) {
    held h;
    sn_error error = {0};
    sn_blob blob = blob_of("t.muscle.json", text);
    if (sn_muscle_parse(&blob, NULL, &h.muscle, &h.document, &error) != SN_OK) fail_msg("%s", error.text);
    sn_blob_free(&blob); /* the document must not need it any more */
    return h;
}

static char *write_held(const held *h, unsigned changed, const sn_history_entry *entry, bool keep_history) {
    sn_error error = {0};
    sn_output *output = open_output();
    const sn_write_options options = {changed, entry, !keep_history};
    if (sn_muscle_write(&h->muscle, h->document, &options, output, &error) != SN_OK) fail_msg("%s", error.text);
    return commit_output(output);
}

static void let_go(held *h) {
    sn_muscle_free(&h->muscle);
    sn_document_free(h->document);
}

static const unsigned every_section =
    SN_SECTION_MESH | SN_SECTION_ROOTS | SN_SECTION_STRUCTURE | SN_SECTION_FIBERS | SN_SECTION_ATTACHMENTS | SN_SECTION_EXTERNALS;

/* ---- what is read ----------------------------------------------------------------------------------------------------- */

static void sections_are_read(void **state) {
    (void)state;
    held h = read_text(full);
    const sn_muscle *m = &h.muscle;
    assert_int_equal(sn_muscle_sections(m), every_section);
    assert_string_equal(m->name, "biceps");
    assert_true(m->meters_per_unit == 0.001);
    assert_int_equal(m->mesh.vertex_count, 4);
    assert_true(m->mesh.positions[3].x == 0.1 && m->mesh.positions[3].z == 0.3);
    assert_int_equal(m->mesh.triangles[3].v[1], 3);
    assert_true(sn_mesh_attribute(&m->mesh, "paint")->values[3] == 0.25);
    assert_string_equal(m->mesh.group_names[1], "tendon");
    assert_int_equal(m->mesh.triangle_group[2], SN_NONE);
    assert_int_equal(m->roots.vertices[0], 2); /* ring order, not sorted */
    assert_int_equal(m->structure.sample_count, 2);
    assert_int_equal(m->structure.parents[1], 0);
    assert_int_equal(m->structure.vertex_sample[3], 0);
    assert_int_equal(m->structure.vertex_sample[2], 1);
    assert_string_equal(m->fibers.field, "tree");
    assert_int_equal(m->fibers.polylines[0].count, 2);
    assert_true(m->attachments[0].distances[1] == -0.2);
    assert_null(m->attachments[1].distances);
    assert_int_equal(m->attachments[0].reasons[1], SN_REASON_CONTACT);
    assert_true(m->attachments[0].confidence[0] == 0.25);
    assert_null(m->attachments[1].reasons);
    assert_int_equal(m->external_count, 1);
    assert_string_equal(m->externals[0].target, "triceps");
    assert_int_equal(m->externals[0].triangles[1], 8);
    assert_true(m->externals[0].barycentric[3] == 0.5 && m->externals[0].weights[4] == 0.25);
    assert_true(m->externals[0].distances[1] == -0.1 && m->externals[0].minimum[0] == 0.2);
    let_go(&h);
}

static void a_partial_structure_leaves_vertices_without_sample(void **state) {
    (void)state;
    char *text = replace(full, "\"vertices\": [1,2]}", "\"vertices\": [1]}");
    held h = read_text(text);
    assert_int_equal(h.muscle.structure.vertex_sample[2], SN_NONE);
    let_go(&h);
    free(text);
}

/* ---- what is written -------------------------------------------------------------------------------------------------- */

/* Written once, a document is a fixed point: whether its sections are passed on or written anew from the muscle. */
static void writing_is_a_fixed_point(void **state) {
    (void)state;
    held h = read_text(full);
    char *passed = write_held(&h, 0, NULL, true), *anew = write_held(&h, every_section, NULL, true);
    char *normal = replace(full, "0.10000000000000001", "0.1"); /* a number written anew is written short */
    assert_string_equal(passed, full);
    assert_string_equal(anew, normal);
    assert_string_equal(logged, "");
    free(passed);
    free(anew);
    free(normal);
    let_go(&h);
}

static void blanks_and_order_of_the_input_do_not_matter(void **state) {
    (void)state;
    held h = read_text("\xEF\xBB\xBF {\"mesh\":{\"triangles\":[0,2,\n1 , 0,1,3, 1,2,3, 0,3,2],\"vertices\":[0,0,0, 1,0,0, 0,1,0, 0,0,1]},"
                       "\"metersPerUnit\":1,\"zzz\":[],\"version\":1,\"format\":\"sinew-muscle\",\"aaa\":{}}");
    char *text = write_held(&h, 0, NULL, true);
    assert_string_equal(text,
                        "{\n  \"format\": \"sinew-muscle\",\n  \"version\": 1,\n  \"metersPerUnit\": 1,\n"
                        "  \"mesh\": {\n    \"triangles\": [0,2,1,0,1,3,1,2,3,0,3,2],\n    \"vertices\": [0,0,0,1,0,0,0,1,0,0,0,1]\n  },\n"
                        "  \"zzz\": [],\n  \"aaa\": {}\n}\n");
    free(text);
    let_go(&h);
}

static void history_grows_or_is_left_out(void **state) {
    (void)state;
    const char *const args[] = {"--at", "plane:0,0,\"1\""};
    const sn_history_entry entry = {"root-select", 2, args, "sha256:0123"};
    held h = read_text(full);
    char *with = write_held(&h, 0, &entry, true), *without = write_held(&h, 0, &entry, false);
    assert_contains(with, "    {\"tool\": \"mesh-clean\", \"version\": \"0.0.9\", \"args\": [\"--weld\",\"0\"], \"more\": true},\n"
                          "    {\"tool\": \"root-select\", \"version\": \"" SN_VERSION "\", \"args\": [\"--at\",\"plane:0,0,\\\"1\\\"\"], "
                          "\"input\": \"sha256:0123\"}\n  ]\n}\n");
    assert_lacks(without, "history");
    assert_contains(without, "x-studio");
    free(with);
    free(without);
    let_go(&h);
}

static void stale_sections_are_dropped_and_named(void **state) {
    (void)state;
    held h = read_text(full);
    char *text = write_held(&h, SN_SECTION_ROOTS, NULL, true);
    assert_contains(text, "\"roots\"");
    assert_contains(text, "\"attachments\"");
    assert_lacks(text, "\"structure\"");
    assert_lacks(text, "\"fibers\"");
    assert_contains(logged, "\"structure\" is dropped");
    assert_contains(logged, "\"fibers\" is dropped");
    free(text);
    forget_log(state);
    text = write_held(&h, SN_SECTION_STRUCTURE, NULL, true);
    assert_contains(text, "\"roots\"");
    assert_contains(text, "\"structure\"");
    assert_lacks(text, "\"fibers\"");
    free(text);
    text = write_held(&h, SN_SECTION_STRUCTURE | SN_SECTION_FIBERS, NULL, true); /* made anew together */
    assert_contains(text, "\"fibers\"");
    free(text);
    forget_log(state);
    text = write_held(&h, SN_SECTION_ATTACHMENTS | SN_SECTION_FIBERS, NULL, true); /* nothing depends on these */
    assert_contains(text, "\"structure\"");
    assert_string_equal(logged, "");
    free(text);
    let_go(&h);
}

/* A new, smaller mesh: the stale sections of the muscle speak of vertices that are gone, and are not even looked at. */
static void a_new_mesh_drops_all_that_hangs_on_it(void **state) {
    (void)state;
    held h = read_text(full);
    h.muscle.mesh.vertex_count = 3;
    h.muscle.mesh.triangle_count = 1;
    char *text = write_held(&h, SN_SECTION_MESH, NULL, true);
    assert_contains(text, "\"vertices\": [0,0,0,1,0,0,0,1,0],");
    assert_contains(text, "\"triangles\": [0,2,1]");
    assert_contains(text, "x-studio");
    for (int i = 0; i < 5; i++) {
        static const char *const gone[] = {"\"roots\"", "\"structure\"", "\"fibers\"", "\"attachments\"", "\"externals\""};
        assert_lacks(text, gone[i]);
        assert_contains(logged, gone[i]);
    }
    free(text);
    let_go(&h);
}

static void what_is_not_valid_is_not_written(void **state) {
    (void)state;
    held h = read_text(full);
    sn_output *output = open_output();
    sn_error error = {0};
    h.muscle.fibers.directions[1].y = (double)NAN;
    assert_int_equal(sn_muscle_write(&h.muscle, h.document, &(sn_write_options){.changed = SN_SECTION_FIBERS}, output, &error),
                     SN_ERROR_INPUT);
    assert_contains(error.text, "fibers: vertex 1");
    sn_output_abort(output);
    let_go(&h);
}

/* ---- bare meshes and references --------------------------------------------------------------------------------------- */

static const char *const obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

static void a_bare_mesh_is_a_muscle(void **state) {
    (void)state;
    held h;
    sn_blob blob = blob_of("left.biceps.obj", obj);
    assert_int_equal(sn_muscle_parse(&blob, &(sn_read_options){.meters_per_unit = 0.01}, &h.muscle, &h.document, NULL), SN_OK);
    sn_blob_free(&blob);
    assert_string_equal(h.muscle.name, "left.biceps");
    assert_true(h.muscle.meters_per_unit == 0.01);
    assert_string_equal(logged, "");
    char *text = write_held(&h, 0, NULL, true);
    held again = read_text(text);
    assert_int_equal(sn_muscle_sections(&again.muscle), SN_SECTION_MESH);
    assert_memory_equal(again.muscle.mesh.positions, h.muscle.mesh.positions, 4 * sizeof(sn_vec3));
    free(text);
    let_go(&again);
    let_go(&h);
}

static void y_up_is_turned_to_z_up(void **state) {
    (void)state;
    held h;
    sn_blob blob = blob_of("a.obj", "v 1 2 3\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_int_equal(sn_muscle_parse(&blob, &(sn_read_options){.up_y = true}, &h.muscle, &h.document, NULL), SN_OK);
    sn_blob_free(&blob);
    assert_true(h.muscle.mesh.positions[0].x == 1 && h.muscle.mesh.positions[0].y == -3 && h.muscle.mesh.positions[0].z == 2);
    let_go(&h);
}

static void an_unlikely_size_draws_a_warning(void **state) {
    (void)state;
    static const struct {
        double unit;
        bool warned;
    } cases[] = {{0.0, false}, {0.001, false}, {1e-4, true}, {10.0, true}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        held h;
        sn_blob blob = blob_of("a.obj", obj);
        forget_log(state);
        assert_int_equal(sn_muscle_parse(&blob, &(sn_read_options){.meters_per_unit = cases[i].unit}, &h.muscle, &h.document, NULL), SN_OK);
        sn_blob_free(&blob);
        let_go(&h);
        if (cases[i].warned)
            assert_contains(logged, "--units");
        else
            assert_string_equal(logged, "");
    }
}

static char *reference_document(const char *mesh, const char *uri) {
    static char text[1024];
    char hash[SN_HASH_LENGTH];
    sn_hash(mesh, strlen(mesh), hash);
    snprintf(text, sizeof text,
             "{\"format\":\"sinew-muscle\",\"version\":1,\"metersPerUnit\":1,\"mesh\":{\"uri\":\"%s\",\"sha256\":\"%s\"},"
             "\"roots\":{\"vertices\":[3]}}",
             uri, hash);
    return text;
}

static void a_mesh_by_reference_stays_one(void **state) {
    (void)state;
    write_file("m.obj", obj);
    held h = read_text(reference_document(obj, "m.obj"));
    assert_int_equal(h.muscle.mesh.vertex_count, 4);
    char *text = write_held(&h, SN_SECTION_ATTACHMENTS, NULL, true);
    assert_contains(text, "\"uri\": \"m.obj\",\n    \"sha256\": \"sha256:");
    assert_lacks(text, "triangles");
    free(text);
    text = write_held(&h, SN_SECTION_MESH, NULL, true); /* a new mesh is written out */
    assert_lacks(text, "uri");
    assert_contains(text, "triangles");
    free(text);
    let_go(&h);
}

/* ---- what is wrong ------------------------------------------------------------------------------------------------------- */

static void expect_error(const char *name, const char *text, const char *part) {
    held h;
    sn_error error = {.element = -1};
    sn_blob blob = blob_of(name, text);
    sn_status status = sn_muscle_parse(&blob, NULL, &h.muscle, &h.document, &error);
    if (status == SN_OK) fail_msg("no error, but expected: %s", part);
    assert_contains(error.text, part);
    assert_true(error.file[0] != '\0');
    assert_null(h.document);
    assert_int_equal(sn_muscle_sections(&h.muscle), 0);
    sn_blob_free(&blob);
}

static void a_reference_is_checked(void **state) {
    (void)state;
    write_file("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    expect_error("t.muscle.json", reference_document(obj, "m.obj"), "mesh.sha256: ");
    expect_error("t.muscle.json", reference_document(obj, "none.obj"), "No such file");
    expect_error("t.muscle.json", reference_document(obj, "."), "directory");
}

static void every_defect_is_named(void **state) {
    (void)state;
    static const struct {
        const char *old, *new, *part;
    } defects[] = {
        {"sinew-muscle", "sinew-scene", "format: expected \"sinew-muscle\", found \"sinew-scene\""},
        {"\"version\": 1", "\"version\": 2", "version: the document has version 2"},
        {"\"version\": 1", "\"version\": \"1\"", "version: expected a whole number"},
        {"\"biceps\"", "12", "name: expected a text"},
        {"0.001", "0", "metersPerUnit: expected a number above 0, found 0"},
        {"0.001", "-1", "metersPerUnit"},
        {"\"metersPerUnit\": 0.001,", "", "metersPerUnit: expected the metres per unit"},
        {"[0,0,0,1,0,0", "[0,0,1,0,0", "mesh.vertices: expected a multiple of 3 numbers, found 11"},
        {"[0,0,0,1,0,0", "[0,0,0,null,0,0", "mesh.vertices[3]: expected a number, found null"},
        {"[0,0,0,1,0,0", "[0,0,0,1e400,0,0", "overflow"},
        {"[0,0,0,1,0,0", "[0,0,0,NaN,0,0", "not valid JSON"},
        {"1,2,3,0,3,2]", "1,2,3,0,3]", "mesh.triangles: expected a multiple of 3"},
        {"1,2,3,0,3,2]", "1,2,3,0,4,2]", "mesh.triangles[10]: expected a whole number in [0,3], found 4"},
        {"1,2,3,0,3,2]", "1,2,3,0,-1,2]", "mesh.triangles[10]: expected a whole number in [0,3], found -1"},
        {"1,2,3,0,3,2]", "1,2,3,0,1.5,2]", "mesh.triangles[10]: expected a whole number in [0,3], found 1.5"},
        {"1,2,3,0,3,2]", "1,2,3,0,99999999999999999999,2]", "mesh.triangles[10]"},
        {"[0,2,1,0,1,3,1,2,3,0,3,2]", "[]", "triangle"},
        {"\"triangles\": [0,2,1", "\"corners\": [0,2,1", "mesh.triangles: expected an array of numbers, found nothing"},
        {"\"values\": [0,0.5,1,0.25]", "\"values\": [0,0.5,1]",
         "mesh.attributes.paint.values: expected an array of 4 numbers, found one of 3"},
        {"\"components\": 1", "\"components\": 0", "mesh.attributes.paint.components"},
        {"\"triangles\": [0,1,-1,0]", "\"triangles\": [0,1,2,0]", "mesh.groups.triangles[2]"},
        {"\"vertices\": [2,0]", "\"vertices\": [2,4]", "roots.vertices[1]: expected a whole number in [0,3], found 4"},
        {"\"vertices\": [2,0]", "\"vertices\": [2,2]", "roots: vertex 2 is named twice"},
        {"\"parent\": 0", "\"parent\": 1", "structure.samples[1].parent: expected a whole number in [-1,0], found 1"},
        {"\"parent\": 0", "\"parent\": -1", "structure: sample 1 is a second root"},
        {"\"parent\": -1", "\"parent\": 0", "structure.samples[0].parent"},
        {"\"branch\": 0", "\"branch\": 3", "structure: sample 0 is the root, but not on branch 0"},
        {"\"branch\": 1", "\"branch\": -1", "structure.samples[1].branch"},
        {"\"vertices\": [1,2]}", "\"vertices\": [1,0]}", "structure.samples[1].vertices: vertex 0 already hangs on sample 0"},
        {"\"vertices\": [1,2]}", "\"vertices\": [1,9]}", "structure.samples[1].vertices[1]"},
        {"\"position\": [0.3,0.2,0.1]", "\"position\": [0.3,0.2]", "structure.samples[1].position: expected an array of 3 numbers"},
        {"\"position\": [0.3,0.2,0.1], ", "", "structure.samples[1].position: expected a point"},
        {"\"spacing\": 0.5", "\"spacing\": -0.5", "structure.spacing"},
        {"[0,0,1,0,0,1,0,0,1,0,0,1]", "[0,0,1,0,0,1,0,0,1]", "fibers.directions: expected an array of 12 numbers, found one of 9"},
        {"[0,0,0,0,0,1]", "[0,0,0]", "fibers: polyline 0 has fewer than two points"},
        {"\"bone\": \"radius\", ", "", "attachments[1].bone: expected the name of a bone"},
        {"\"vertices\": []", "\"vertices\": [2]", "attachments: vertex 2 is held by bone 'humerus' and again by bone 'radius'"},
        {"\"vertices\": [0,2]", "\"vertices\": [2,0]", "attachments: the vertices of bone 'humerus' do not ascend"},
        {"\"distances\": [0.1,-0.2]", "\"distances\": [0.1]", "attachments[0].distances: expected an array of 2 numbers"},
        {"\"reasons\": [5,3]", "\"reasons\": [5]", "attachments[0].reasons: expected an array of 2"},
        {"\"reasons\": [5,3]", "\"reasons\": [5,9]", "attachments[0].reasons[1]"},
        {"\"confidence\": [0.25,1]", "\"confidence\": [0.25,1.5]", "attachments: bone 'humerus' has a confidence that is not within [0,1]"},
        {"\"target\": \"triceps\", ", "", "externals[0].target: expected the name of a muscle or an envelope"},
        {"\"vertices\": [1,3]", "\"vertices\": [3,1]", "externals: target 'triceps' has vertices that do not ascend"},
        {"\"vertices\": [1,3]", "\"vertices\": [1,4]", "externals[0].vertices[1]"},
        {"\"triangles\": [7,8]", "\"triangles\": [7]", "externals[0].triangles: expected an array of 2"},
        {"[1,0,0,0.5,0.25,0.25]", "[1,0,0,0.5,0.5,0.25]", "externals: target 'triceps' has barycentric coordinates that are no point"},
        {"[1,0,0,0.5,0.25,0]", "[1,0,0,0.5,-0.25,0]", "externals: target 'triceps' has a weight that is not within [0,1]"},
        {"{\"tool\": \"mesh-clean\"", "7, {\"tool\": \"mesh-clean\"", "history[0]: expected an object, found 7"},
        {"\"x-studio\"", "\"omega\"", "duplicate"},
        {"  ]\n}\n", "  ]\n", "not valid JSON"},
    };
    for (size_t i = 0; i < sizeof defects / sizeof *defects; i++) {
        char *text = replace(full, defects[i].old, defects[i].new);
        expect_error("t.muscle.json", text, defects[i].part);
        free(text);
    }
    expect_error("t.muscle.json", "", "");
    expect_error("t.muscle.json", "{}", "format: expected \"sinew-muscle\", found nothing");
    expect_error("t.muscle.json", "[1,2,3]", "");
}

/* Cut anywhere, a document is an error: never a crash, never a muscle. */
static void truncation_is_an_error(void **state) {
    (void)state;
    size_t size = strlen(full);
    for (size_t length = 0; length + 2 < size; length++) {
        held h;
        sn_error error = {0};
        sn_blob blob = blob_of("t.muscle.json", full);
        blob.data[length] = '\0';
        blob.size = length;
        assert_int_not_equal(sn_muscle_parse(&blob, NULL, &h.muscle, &h.document, &error), SN_OK);
        assert_true(error.text[0] != '\0');
        sn_blob_free(&blob);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sections_are_read),
        cmocka_unit_test(a_partial_structure_leaves_vertices_without_sample),
        cmocka_unit_test_setup(writing_is_a_fixed_point, forget_log),
        cmocka_unit_test(blanks_and_order_of_the_input_do_not_matter),
        cmocka_unit_test(history_grows_or_is_left_out),
        cmocka_unit_test_setup(stale_sections_are_dropped_and_named, forget_log),
        cmocka_unit_test_setup(a_new_mesh_drops_all_that_hangs_on_it, forget_log),
        cmocka_unit_test(what_is_not_valid_is_not_written),
        cmocka_unit_test_setup(a_bare_mesh_is_a_muscle, forget_log),
        cmocka_unit_test(y_up_is_turned_to_z_up),
        cmocka_unit_test(an_unlikely_size_draws_a_warning),
        cmocka_unit_test(a_mesh_by_reference_stays_one),
        cmocka_unit_test(a_reference_is_checked),
        cmocka_unit_test(every_defect_is_named),
        cmocka_unit_test(truncation_is_an_error),
    };
    return cmocka_run_group_tests_name("document", tests, make_folder, remove_folder);
}
