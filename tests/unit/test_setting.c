/* test_setting.c -- solver settings in text: what is read, what is refused, what is applied. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "sinew/setting.h"

static void check_canonical(const char *text, const char *canonical, const char *family) {
    char out[SN_SETTING_LENGTH];
    sn_setting setting, again;
    assert_int_equal(sn_setting_parse(text, &setting, NULL), SN_OK);
    sn_setting_format(&setting, out);
    assert_string_equal(out, canonical);
    assert_int_equal(sn_setting_parse(out, &again, NULL), SN_OK);
    assert_memory_equal(&again, &setting, sizeof setting);
    sn_setting_family(&setting, out);
    assert_string_equal(out, family);
}

static void text_has_one_canonical_form(void **state) {
    (void)state;
    check_canonical("qn", "qn", "qn");
    check_canonical("xpbd substeps=64 iterations=1", "xpbd substeps=64 iterations=1", "xpbd");
    check_canonical(" \tqn  iterations=5\tsubsteps=2\r", "qn substeps=2 iterations=5", "qn");
    check_canonical("qn substeps=auto", "qn substeps=auto", "qn");
    check_canonical("qn tolerance=1e-3", "qn tolerance=0.001", "qn");
    check_canonical("xpbd scheme=kohout iterations=10", "xpbd iterations=10 scheme=kohout", "xpbd scheme=kohout");
    check_canonical("xpbd hinges=printed scheme=kohout", "xpbd scheme=kohout hinges=printed", "xpbd scheme=kohout hinges=printed");
    check_canonical("xpbd scheme=kohout hinges=scheme", "xpbd scheme=kohout hinges=scheme", "xpbd scheme=kohout");
    check_canonical("qn preconditioner=scalar tolerance=0", "qn tolerance=0 preconditioner=scalar", "qn");
    check_canonical("qn preconditioner=corotated", "qn preconditioner=corotated", "qn preconditioner=corotated");
    check_canonical("qn preconditioner=two-level", "qn preconditioner=two-level", "qn preconditioner=two-level");
    check_canonical("xpbd scheme=guarded", "xpbd scheme=guarded", "xpbd"); /* the default is no family of its own */
}

static void check_refused(const char *text, const char *because) {
    sn_setting setting;
    sn_error error = {0};
    assert_int_equal(sn_setting_parse(text, &setting, &error), SN_ERROR_INPUT);
    if (strstr(error.text, because) == NULL) fail_msg("\"%s\": %s", text, error.text);
}

static void what_is_unknown_is_refused_by_name(void **state) {
    (void)state;
    check_refused("", "begins with its method");
    check_refused("newton iterations=5", "not with \"newton\"");
    check_refused("substeps=4", "not with \"substeps=4\"");
    check_refused("qn 5", "cannot read \"5\"");
    check_refused("qn speed=5", "qn has no \"speed\"; it has substeps, iterations");
    check_refused("qn scheme=kohout", "qn has no \"scheme\"");
    check_refused("qn hinges=printed", "qn has no \"hinges\"");
    check_refused("xpbd scheme=kohout hinges=paper", "hinges=paper: it is scheme, published or printed");
    check_refused("xpbd tolerance=1e-5", "xpbd has no \"tolerance\"");
    check_refused("xpbd scheme=papers", "scheme=papers: it is guarded, romeo or kohout");
    check_refused("xpbd scheme=", "scheme=: it is guarded");
}

static void numbers_out_of_range_are_refused(void **state) {
    (void)state;
    check_refused("xpbd substeps=auto", "a whole number from 1 to 1e+06");
    check_refused("qn substeps=0", "a whole number from 1 to 1e+06");
    check_refused("qn substeps=1.5", "a whole number");
    check_refused("qn substeps=1000001", "a whole number");
    check_refused("qn substeps=-3", "a whole number");
    check_refused("qn substeps=", "a whole number");
    check_refused("qn substeps=2x", "a whole number");
    check_refused("qn substeps=nan", "a whole number");
    check_refused("qn tolerance=inf", "a number from 0 to 1");
    check_refused("qn tolerance=1.1", "a number from 0 to 1");
    check_refused("qn substeps=2 substeps=3", "substeps is given twice");
}

static void a_list_has_comments_and_knows_its_lines(void **state) {
    (void)state;
    static const char good[] = "# two\n\nqn iterations=5 # fast\r\n   \nxpbd";
    static const char bad[] = "qn\n\nqn iterations=none\nqn\n";
    static const char none[] = "# nothing\n\n";
    sn_setting *list;
    sn_index count;
    sn_error error = {0};
    assert_int_equal(sn_settings_parse(good, sizeof good - 1, &list, &count, NULL), SN_OK);
    assert_int_equal(count, 2);
    assert_int_equal(list[0].method, SN_SOLVER_QN);
    assert_int_equal(list[1].method, SN_SOLVER_XPBD);
    free(list);
    assert_int_equal(sn_settings_parse(bad, sizeof bad - 1, &list, &count, &error), SN_ERROR_INPUT);
    assert_int_equal(error.line, 3);
    assert_null(list);
    assert_int_equal(sn_settings_parse(none, sizeof none - 1, &list, &count, &error), SN_ERROR_INPUT);
    assert_int_equal(sn_settings_parse("", 0, &list, &count, &error), SN_ERROR_INPUT);
}

static void a_setting_stands_for_itself(void **state) {
    (void)state;
    sn_scene scene;
    sn_setting setting;
    sn_scene_defaults(&scene);
    scene.muscle_count = 1;
    scene.muscles = SN_NEW(sn_scene_muscle, 1);
    scene.muscles[0].iterations = 77;
    scene.solver.substeps = 9;
    scene.solver.threads = 3;
    scene.solver.sleep = false;
    scene.solver.scheme = SN_SCHEME_KOHOUT;
    assert_int_equal(sn_setting_parse("qn iterations=6 tolerance=0.25", &setting, NULL), SN_OK);
    sn_setting_apply(&setting, &scene);
    sn_solver_settings defaults = sn_solver_defaults(SN_SOLVER_QN);
    assert_int_equal(scene.solver.method, SN_SOLVER_QN);
    assert_int_equal(scene.solver.substeps, defaults.substeps);
    assert_int_equal(scene.solver.iterations, 6);
    assert_true(scene.solver.tolerance == 0.25);
    assert_int_equal(scene.solver.scheme, SN_SCHEME_GUARDED);
    assert_int_equal(scene.solver.threads, 3);
    assert_false(scene.solver.sleep);
    assert_int_equal(scene.muscles[0].iterations, 0);
    assert_int_equal(sn_setting_parse("qn preconditioner=corotated", &setting, NULL), SN_OK);
    sn_setting_apply(&setting, &scene);
    assert_int_equal(scene.solver.preconditioner, SN_PRECONDITION_COROTATED);
    assert_int_equal(sn_setting_parse("xpbd scheme=romeo", &setting, NULL), SN_OK);
    sn_setting_apply(&setting, &scene);
    assert_int_equal(scene.solver.scheme, SN_SCHEME_ROMEO);
    assert_int_equal(sn_setting_parse("xpbd scheme=kohout hinges=printed", &setting, NULL), SN_OK);
    sn_setting_apply(&setting, &scene);
    assert_int_equal(scene.solver.hinges, SN_HINGES_PRINTED);
    sn_scene_free(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(text_has_one_canonical_form),      cmocka_unit_test(what_is_unknown_is_refused_by_name),
        cmocka_unit_test(numbers_out_of_range_are_refused), cmocka_unit_test(a_list_has_comments_and_knows_its_lines),
        cmocka_unit_test(a_setting_stands_for_itself),
    };
    return cmocka_run_group_tests_name("setting", tests, NULL, NULL);
}
