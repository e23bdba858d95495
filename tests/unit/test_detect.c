/* test_detect.c -- scenes told from everything else. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "sinew/io.h"

static bool detect(const char *text) {
    sn_blob blob = {.name = (char[]){"x"}, .data = (char *)(uintptr_t)text, .size = strlen(text)};
    return sn_scene_detect(&blob);
}

static void scenes_are_known_by_their_format_member(void **state) {
    (void)state;
    assert_true(detect("{\"format\":\"sinew-scene\"}"));
    assert_true(detect("\xEF\xBB\xBF \n{ \"format\" : \"sinew-scene\", \"version\": 1 }"));
    assert_true(detect("{\"name\": \"a \\\"format\\\"\", \"list\": [1, {\"format\": \"other\"}, \"]\"], \"format\": \"sinew-scene\"}"));
}

static void everything_else_is_not_a_scene(void **state) {
    (void)state;
    const char *const others[] = {"",
                                  "{",
                                  "{}",
                                  "[]",
                                  "OFF\n1 0 0\n",
                                  "{\"format\"",
                                  "{\"format\":",
                                  "{\"format\": \"sinew-sc",
                                  "{\"format\": \"sinew-muscle\"}",
                                  "{\"format\": 3}",
                                  "{\"a\": {\"format\": \"sinew-scene\"}}",
                                  "{\"a\": \"format\", \"b\": \"sinew-scene\"}",
                                  "{\"a\": \"\\",
                                  "{\"a\" 1, \"format\": \"sinew-scene\"}",
                                  "{\"a\": [[[[, \"format\": \"sinew-scene\"}"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) assert_false(detect(others[i]));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_are_known_by_their_format_member),
        cmocka_unit_test(everything_else_is_not_a_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
