/* test_json.c -- JSON: one layout out; parse, typed access, places and paths in errors, and passing on in. */
#include "documents.h"

#include "../../lib/io/json.h"

/* ---- out -------------------------------------------------------------------------------------------------------------- */

static void write_sample(sn_json *json) {
    sn_json_object(json, NULL);
    sn_json_text(json, "name", "arm");
    sn_json_numbers(json, "values", (const double[3]){1, 0.5, 1e-300}, 3);
    sn_json_array(json, "bones");
    sn_json_object_line(json, NULL);
    sn_json_text(json, "name", "ulna");
    sn_json_indices(json, "vertices", (const sn_index[2]){3, -1}, 2);
    sn_json_close(json);
    sn_json_object(json, NULL);
    sn_json_bool(json, "fixed", true);
    sn_json_close(json);
    sn_json_close(json);
    sn_json_array(json, "none");
    sn_json_close(json);
    sn_json_object(json, "empty");
    sn_json_close(json);
    sn_json_null(json, "null");
}

static char *written(void (*write)(sn_json *json), bool pretty) {
    sn_output *output = open_output();
    sn_json *json = sn_json_begin(output, pretty);
    assert_non_null(json);
    write(json);
    assert_int_equal(sn_json_end(json, NULL), SN_OK); /* closes what is open */
    return commit_output(output);
}

static void layout_is_fixed(void **state) {
    (void)state;
    char *pretty = written(write_sample, true), *compact = written(write_sample, false);
    assert_string_equal(pretty, "{\n"
                                "  \"name\": \"arm\",\n"
                                "  \"values\": [1,0.5,1e-300],\n"
                                "  \"bones\": [\n"
                                "    {\"name\": \"ulna\", \"vertices\": [3,-1]},\n"
                                "    {\n"
                                "      \"fixed\": true\n"
                                "    }\n"
                                "  ],\n"
                                "  \"none\": [],\n"
                                "  \"empty\": {},\n"
                                "  \"null\": null\n"
                                "}\n");
    assert_string_equal(compact, "{\"name\":\"arm\",\"values\":[1,0.5,1e-300],\"bones\":[{\"name\":\"ulna\",\"vertices\":[3,-1]},"
                                 "{\"fixed\":true}],\"none\":[],\"empty\":{},\"null\":null}\n");
    free(pretty);
    free(compact);
}

static void write_texts(sn_json *json) {
    sn_json_array(json, NULL);
    sn_json_text(json, NULL, "\"\\\b\t\n\v\f\r\x01/");
    sn_json_text(json, NULL, "m\xC3\xBAsculo \xF0\x9F\x92\xAA");
    sn_json_text(json, NULL,
                 "a\xFF"
                 "b\xC0\xAF"
                 "c\xED\xA0\x80"
                 "d\xE2\x82"); /* stray, overlong, surrogate, cut off */
    sn_json_text(json, NULL, NULL);
    sn_json_close(json);
}

static void texts_are_escaped_and_valid_utf8(void **state) {
    (void)state;
    char *text = written(write_texts, false);
    assert_string_equal(text, "[\"\\\"\\\\\\b\\t\\n\\u000b\\f\\r\\u0001/\",\"m\xC3\xBAsculo \xF0\x9F\x92\xAA\","
                              "\"a\xEF\xBF\xBD"
                              "b\xEF\xBF\xBD\xEF\xBF\xBD"
                              "c\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD"
                              "d\xEF\xBF\xBD\xEF\xBF\xBD\",null]\n");
    free(text);
}

static void write_limits(sn_json *json) {
    sn_json_array(json, NULL);
    sn_json_integer(json, NULL, INT64_MIN);
    sn_json_integer(json, NULL, INT64_MAX);
    sn_json_integer(json, NULL, 0);
    sn_json_number(json, NULL, (double)NAN);
    sn_json_number(json, NULL, (double)-INFINITY);
    sn_json_number(json, NULL, -0.0);
    sn_json_close(json);
}

static void limits_are_written(void **state) {
    (void)state;
    char *text = written(write_limits, false);
    assert_string_equal(text, "[-9223372036854775808,9223372036854775807,0,null,null,0]\n");
    free(text);
}

/* ---- in --------------------------------------------------------------------------------------------------------------- */

static sn_json_tree *parsed(const char *text) {
    sn_blob blob = blob_of("t.json", text);
    sn_json_tree *tree;
    sn_error error = {0};
    if (sn_json_parse(&blob, &tree, &error) != SN_OK) fail_msg("%s", error.text);
    sn_blob_free(&blob);
    return tree;
}

static void expect_parse_error(const char *text, int64_t line, int64_t column, const char *part) {
    sn_blob blob = blob_of("t.json", text);
    sn_json_tree *tree;
    sn_error error = {0};
    assert_int_equal(sn_json_parse(&blob, &tree, &error), SN_ERROR_INPUT);
    assert_null(tree);
    assert_string_equal(error.file, blob.name);
    if (error.line != line || error.column != column)
        fail_msg("%s: at %d:%d, not %d:%d", error.text, (int)error.line, (int)error.column, (int)line, (int)column);
    assert_contains(error.text, part);
    sn_blob_free(&blob);
}

/* The place is that of the text as it was written, also behind arrays of numbers (which the parser proper never sees). */
static void malformed_text_is_placed(void **state) {
    (void)state;
    expect_parse_error("", 1, 1, "end of file");
    expect_parse_error("{", 1, 1, "end of file");
    expect_parse_error("{\"a\": [1,2,3],\n \"b\": [4,5,\n6], \"c\" 7}", 3, 9, "':' expected near '7'");
    expect_parse_error("{\"a\": [1,2,3,]}", 1, 14, "near ']'");
    expect_parse_error("{\"a\": [1,2,03]}", 1, 12, "'0'");
    expect_parse_error("{\"a\": [1,2,nan]}", 1, 14, "nan");
    expect_parse_error("{\"a\": [1,2,1e999]}", 1, 16, "overflow");
    expect_parse_error("{\"\xC3\xBA\": 1, \"\xC3\xBA\": 2}", 1, 12, "duplicate");
    expect_parse_error("{\"a\": \"\xFF\"}", 1, 7, "0xff");
    expect_parse_error("{\"a\": 1} x", 1, 10, "end of file expected");
    expect_parse_error("[{\"a\": 1}]", 1, 0, "not a JSON object");
}

static void deep_nesting_is_an_error(void **state) {
    (void)state;
    char text[20010] = "{\"a\":";
    memset(text + 5, '[', 20000);
    expect_parse_error(text, 1, 2053, "depth");
}

static void numbers_come_back_bit_for_bit(void **state) {
    (void)state;
    uint64_t random = 7;
    double values[1000], *read;
    for (int i = 0; i < 1000; i++) values[i] = (sn_random(&random) - 0.5) * pow(10.0, floor(40.0 * sn_random(&random) - 20.0));
    values[0] = 5e-324, values[1] = 1.7976931348623157e308, values[2] = 0.1, values[3] = 2.2250738585072011e-308;
    sn_output *output = open_output();
    sn_json *json = sn_json_begin(output, true);
    sn_json_object(json, NULL);
    sn_json_numbers(json, "v", values, 1000);
    assert_int_equal(sn_json_end(json, NULL), SN_OK);
    char *text = commit_output(output);
    sn_json_tree *tree = parsed(text);
    sn_json_value top = sn_json_top(tree), v = sn_json_member(&top, "v");
    assert_int_equal(sn_json_get_numbers(&v, 1, 1000, NULL, &read, NULL), SN_OK);
    assert_memory_equal(read, values, sizeof values);
    free(read);
    free(text);
    sn_json_tree_free(tree);
}

static const char *const things = "{\"number\": 1.5, \"whole\": 7, \"flag\": true, \"text\": \"abc\", \"none\": null,\n"
                                  " \"list\": [ 1 , 2.50,\n 3 ], \"empty\": [], \"nested\": [{\"v\": [0,1,99]}, {\"v\": [0,\"x\"]}]}";

static void values_have_types(void **state) {
    (void)state;
    sn_json_tree *tree = parsed(things);
    sn_json_value top = sn_json_top(tree), value;
    double number = -1.0, *numbers;
    bool flag = false;
    char *text = NULL;
    sn_index index = 0, count;
    int choice = 0;
    value = sn_json_member(&top, "number");
    assert_int_equal(sn_json_get_number(&value, 0, 2, &number, NULL), SN_OK);
    assert_true(number == 1.5);
    value = sn_json_member(&top, "absent");
    assert_int_equal(sn_json_get_number(&value, 0, 2, &number, NULL), SN_OK);
    assert_true(number == 1.5); /* left alone */
    value = sn_json_member(&top, "none");
    assert_int_equal(sn_json_get_number(&value, 0, 2, &number, NULL), SN_OK); /* null is absent */
    value = sn_json_member(&top, "whole");
    assert_int_equal(sn_json_get_index(&value, 0, 10, &index, NULL), SN_OK);
    assert_int_equal(index, 7);
    value = sn_json_member(&top, "flag");
    assert_int_equal(sn_json_get_bool(&value, &flag, NULL), SN_OK);
    assert_true(flag);
    value = sn_json_member(&top, "text");
    assert_int_equal(sn_json_get_text(&value, &text, NULL), SN_OK);
    assert_string_equal(text, "abc");
    assert_int_equal(sn_json_get_choice(&value, (const char *const[]){"x", "abc", NULL}, &choice, NULL), SN_OK);
    assert_int_equal(choice, 1);
    value = sn_json_member(&top, "list");
    assert_int_equal(sn_json_length(&value), 3);
    assert_int_equal(sn_json_get_numbers(&value, 3, -1, &count, &numbers, NULL), SN_OK);
    assert_int_equal(count, 3);
    assert_true(numbers[0] == 1.0 && numbers[1] == 2.5 && numbers[2] == 3.0);
    free(numbers);
    value = sn_json_member(&top, "empty");
    assert_int_equal(sn_json_get_numbers(&value, 3, -1, &count, &numbers, NULL), SN_OK);
    assert_int_equal(count, 0);
    free(numbers);
    free(text);
    sn_json_tree_free(tree);
}

static void expect_complaint(sn_status status, const sn_error *error, int64_t line, int64_t column, const char *text) {
    assert_int_equal(status, SN_ERROR_INPUT);
    assert_string_equal(error->text, text);
    assert_int_equal(error->line, line);
    assert_int_equal(error->column, column);
    assert_string_equal(error->file, path_of("t.json"));
}

static void mismatches_name_path_and_place(void **state) {
    (void)state;
    sn_json_tree *tree = parsed(things);
    sn_json_value top = sn_json_top(tree), nested = sn_json_member(&top, "nested"), first = sn_json_element(&nested, 0),
                  second = sn_json_element(&nested, 1), v0 = sn_json_member(&first, "v"), v1 = sn_json_member(&second, "v"),
                  text = sn_json_member(&top, "text"), list = sn_json_member(&top, "list"), absent = sn_json_member(&second, "w"),
                  number = sn_json_member(&top, "number"), element = sn_json_element(&list, 1);
    sn_error error;
    double value, *values;
    sn_index *indices, whole;
    error = (sn_error){0};
    expect_complaint(sn_json_get_number(&text, 0, 1, &value, &error), &error, 1, 51, "text: expected a number in [0,1], found \"abc\"");
    error = (sn_error){0};
    expect_complaint(sn_json_get_number(&number, SN_JSON_POSITIVE, 1, &value, &error), &error, 1, 12,
                     "number: expected a number above 0 and up to 1, found 1.5");
    error = (sn_error){0};
    expect_complaint(sn_json_get_index(&number, 0, 9, &whole, &error), &error, 1, 12,
                     "number: expected a whole number in [0,9], found 1.5");
    error = (sn_error){0};
    expect_complaint(sn_json_get_indices(&v0, (sn_index_rule){1, -1, 0, 41}, NULL, &indices, &error), &error, 3, 42,
                     "nested[0].v[2]: expected a whole number in [0,41], found 99");
    error = (sn_error){0};
    expect_complaint(sn_json_get_indices(&list, (sn_index_rule){1, -1, 0, 41}, NULL, &indices, &error), &error, 2, 16,
                     "list[1]: expected a whole number in [0,41], found 2.50");
    error = (sn_error){0};
    expect_complaint(sn_json_get_numbers(&v1, 1, -1, NULL, &values, &error), &error, 3, 57,
                     "nested[1].v[1]: expected a number, found \"x\"");
    error = (sn_error){0};
    expect_complaint(sn_json_get_numbers(&list, 2, -1, NULL, &values, &error), &error, 2, 10,
                     "list: expected a multiple of 2 numbers, found 3");
    error = (sn_error){0};
    expect_complaint(sn_json_require(&absent, "a thing", &error), &error, 3, 48, "nested[1].w: expected a thing, found nothing");
    error = (sn_error){0};
    expect_complaint(sn_json_expect_object(&element, &error), &error, 2, 16, "list[1]: expected an object, found a number");
    sn_json_tree_free(tree);
}

/* A search that ran on behind the last member left the text: a sanitizer sees that. */
static void missing_members_are_placed_at_their_object(void **state) {
    (void)state;
    sn_json_tree *tree = parsed("{\"x\": [\n {\"a\": 1}, null]}");
    sn_json_value top = sn_json_top(tree), list = sn_json_member(&top, "x"), first = sn_json_element(&list, 0),
                  lost = sn_json_member(&first, "w");
    sn_error error = {0};
    expect_complaint(sn_json_require(&lost, "a thing", &error), &error, 2, 2, "x[0].w: expected a thing, found nothing");
    sn_json_tree_free(tree);
}

/* Whatever a document holds goes through: the same members in the same order, numbers as they were. */
static void passing_on_keeps_everything(void **state) {
    (void)state;
    const char *text = "{\n"
                       "  \"z\": {\n"
                       "    \"deep\": [[1.0,2.50],[]],\n"
                       "    \"mixed\": [1,\"two\",null,true,2.5],\n"
                       "    \"objects\": [\n"
                       "      {\"leaf\": 1, \"v\": [1e5,-0.0]},\n"
                       "      {\n"
                       "        \"in\": {\n"
                       "          \"it\": \"\\\"\\u0001\"\n"
                       "        }\n"
                       "      }\n"
                       "    ]\n"
                       "  },\n"
                       "  \"a\": 12345678901234567\n"
                       "}\n";
    sn_json_tree *tree = parsed(text);
    sn_json_value top = sn_json_top(tree);
    sn_output *output = open_output();
    sn_json *json = sn_json_begin(output, true);
    sn_json_object(json, NULL);
    sn_json_value member = {0};
    while (sn_json_next(&top, &member)) sn_json_pass(json, member.key, &member);
    assert_int_equal(sn_json_end(json, NULL), SN_OK);
    char *copy = commit_output(output);
    assert_string_equal(copy, text);
    free(copy);
    sn_json_tree_free(tree);
}

static void unknown_members_are_named(void **state) {
    (void)state;
    sn_error error = {0};
    sn_json_tree *tree = parsed("{\"stiffness\": {\"relaxed\": 1,\n \"activ\": 2, \"_note\": 3, \"x-mine\": 4, \"other\": 5}}");
    sn_json_value top = sn_json_top(tree), stiffness = sn_json_member(&top, "stiffness");
    assert_int_equal(sn_json_check_members(&stiffness, (const char *const[]){"relaxed", "active", NULL}, &error), SN_OK);
    assert_contains(logged, "t.json:2: stiffness: sinew knows no member activ (did you mean active?), other here");
    assert_lacks(logged, "_note");
    assert_lacks(logged, "x-mine");
    sn_json_tree_free(tree);
}

static void what_is_passed_on_is_named_where_it_seems_mistyped(void **state) {
    (void)state;
    sn_error error = {0};
    const char *const known[] = {"roots", "fibers", "structure", NULL};
    sn_json_tree *tree = parsed("{\"host\": 1,\n \"fibres\": 2, \"roots\": 3, \"root\": 4}");
    sn_json_value top = sn_json_top(tree);
    assert_int_equal(sn_json_check_passed(&top, known, &error), SN_OK);
    assert_contains(logged, "t.json:2: sinew knows no member fibres (did you mean fibers?) here");
    assert_lacks(logged, "host");
    assert_lacks(logged, "root ("); /* the one that is there was not meant */
    sn_json_tree_free(tree);
}

static void strictly_unknown_members_are_errors(void **state) {
    (void)state;
    sn_error error = {0};
    const char *const known[] = {"relaxed", "active", NULL};
    sn_json_tree *tree = parsed("{\"stiffness\": {\"_note\": 3, \"x-mine\": 4,\n \"Relaxd\": 1}}");
    sn_json_value top = sn_json_top(tree), stiffness = sn_json_member(&top, "stiffness");
    sn_documents_strict(true);
    sn_status status = sn_json_check_members(&stiffness, known, &error), passed = sn_json_check_passed(&stiffness, known, NULL);
    sn_documents_strict(false);
    expect_complaint(
        status, &error, 2, 12,
        "stiffness.Relaxd: sinew knows no such member: did you mean \"relaxed\"?; a member of your own begins with '_' or \"x-\"");
    assert_int_equal(passed, SN_ERROR_INPUT);
    sn_json_tree_free(tree);
}

/* A document that consists of mistyped members does not bury what else is said. */
static void not_every_object_is_told_of(void **state) {
    (void)state;
    sn_error error = {0};
    sn_json_tree *tree = parsed("{\"a\": 1}");
    sn_json_value top = sn_json_top(tree);
    const char *const known[] = {"b", NULL};
    for (int i = 0; i < 1000; i++) assert_int_equal(sn_json_check_members(&top, known, &error), SN_OK);
    int lines = 0;
    for (const char *at = logged; (at = strstr(at, "t.json:1:")) != NULL; at++) lines++;
    assert_in_range(lines, 1, 21);
    sn_json_tree_free(tree);
}

static void a_mistyped_member_that_is_needed_is_found(void **state) {
    (void)state;
    sn_error error = {0};
    int choice = 0;
    sn_json_tree *tree = parsed("{\"verticse\": 1, \"law\": \"isochorik\", \"other\": \"nothing\"}");
    sn_json_value top = sn_json_top(tree), vertices = sn_json_member(&top, "vertices"), law = sn_json_member(&top, "law"),
                  other = sn_json_member(&top, "other");
    const char *const laws[] = {"projected", "paper", "isochoric", NULL};
    assert_int_equal(sn_json_require(&vertices, "numbers", &error), SN_ERROR_INPUT);
    assert_string_equal(error.text, "vertices: expected numbers, found nothing; did you mean it by \"verticse\"?");
    assert_int_equal(sn_json_get_choice(&law, laws, &choice, &error), SN_ERROR_INPUT);
    assert_contains(error.text, "found \"isochorik\"; did you mean \"isochoric\"?");
    assert_int_equal(sn_json_get_choice(&other, laws, &choice, &error), SN_ERROR_INPUT);
    assert_lacks(error.text, "did you mean");
    sn_json_tree_free(tree);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layout_is_fixed),
        cmocka_unit_test(texts_are_escaped_and_valid_utf8),
        cmocka_unit_test(limits_are_written),
        cmocka_unit_test(malformed_text_is_placed),
        cmocka_unit_test(deep_nesting_is_an_error),
        cmocka_unit_test(numbers_come_back_bit_for_bit),
        cmocka_unit_test(values_have_types),
        cmocka_unit_test(mismatches_name_path_and_place),
        cmocka_unit_test(missing_members_are_placed_at_their_object),
        cmocka_unit_test(passing_on_keeps_everything),
        cmocka_unit_test_setup(unknown_members_are_named, forget_log),
        cmocka_unit_test_setup(what_is_passed_on_is_named_where_it_seems_mistyped, forget_log),
        cmocka_unit_test_setup(strictly_unknown_members_are_errors, forget_log),
        cmocka_unit_test_setup(not_every_object_is_told_of, forget_log),
        cmocka_unit_test(a_mistyped_member_that_is_needed_is_found),
    };
    return cmocka_run_group_tests_name("json", tests, make_folder, remove_folder);
}
