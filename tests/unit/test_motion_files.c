/* test_motion_files.c -- BVH, ASF with AMC and motion documents: what is read, what is refused and on which line; ASF/AMC against BVH. */
#include "documents.h"

static const sn_clip_options no_options = {0};

static sn_status parse(const char *name, const char *text, const char *skeleton, const sn_clip_options *options, sn_clip *out,
                       sn_error *error) {
    sn_blob motion = blob_of(name, text), bones = {0};
    if (skeleton != NULL) bones = blob_of("bones.asf", skeleton);
    sn_status status = sn_clip_parse(&motion, skeleton != NULL ? &bones : NULL, options, out, error);
    sn_blob_free(&motion);
    sn_blob_free(&bones);
    return status;
}

static sn_clip read_good(const char *name, const char *text, const char *skeleton, const sn_clip_options *options) {
    sn_clip clip;
    sn_error error = {0};
    if (parse(name, text, skeleton, options, &clip, &error) != SN_OK) fail_msg("%s:%ld: %s", error.file, (long)error.line, error.text);
    return clip;
}

/* Refused on that line (0 = of the whole file), with these words. */
static void refuse(const char *name, const char *text, const char *skeleton, int64_t line, const char *words) {
    sn_clip clip;
    sn_error error = {0};
    if (parse(name, text, skeleton, &no_options, &clip, &error) == SN_OK) fail_msg("taken, not refused with '%s'", words);
    if (strstr(error.text, words) == NULL || error.line != line)
        fail_msg("line %ld: '%s', not line %ld: '%s'", (long)error.line, error.text, (long)line, words);
    assert_true(error.file[0] != '\0');
}

/* Where a point of the rest pose goes with a joint. */
static sn_vec3 moved(const sn_clip *clip, const char *joint, sn_index frame, sn_vec3 rest) {
    for (sn_index j = 0; j < clip->joint_count; j++)
        if (strcmp(clip->joints[j].name, joint) == 0) return sn_rigid_apply(clip->joints[j].poses[frame], rest);
    fail_msg("no joint %s", joint);
    return rest;
}

static void assert_at(sn_vec3 found, double x, double y, double z) {
    if (!(sn_distance(found, sn_v3(x, y, z)) < 1e-12)) fail_msg("(%g, %g, %g), not (%g, %g, %g)", found.x, found.y, found.z, x, y, z);
}

/* ---- BVH ---------------------------------------------------------------------------------------------------------------------- */

/* Two roots, 6, 3, 0 and 2 channels, names with blanks, tabs, CR LF, a byte order mark, a brace behind a name. */
static const char odd_bvh[] =
    "\xEF\xBB\xBFHIERARCHY\r\nROOT Hips {\r\n\tOFFSET 0 0 0\r\n\tCHANNELS 6 Xposition Yposition Zposition Zrotation "
    "Xrotation Yrotation\r\n\tJOINT upper arm\r\n\t{\r\n\t\tOFFSET\t0 10 0\r\n\t\tCHANNELS 3 Yrotation Xrotation "
    "Zrotation\r\n\t\tJOINT hand\r\n\t\t{\r\n\t\t\tOFFSET 5 0 0\r\n\t\t\tCHANNELS 0\r\n\t\t\tEnd Site\r\n\t\t\t{"
    "\r\n\t\t\t\tOFFSET 2 0 0\r\n\t\t\t}\r\n\t\t}\r\n\t}\r\n}\r\nROOT prop\r\n{\r\nOFFSET 1 2 3\r\nCHANNELS 2 "
    "Xrotation Yposition\r\n}\r\nMOTION\r\nFrames:\t2\r\nFrame Time: .0333333\r\n0 0 0 0 0 0 0 0 0 0 0\r\n"
    "1 2 3 90 0 0 0 0 90 90 7\r\n\r\n";

static void bvh_of_any_form_is_read(void **state) {
    (void)state;
    sn_clip clip = read_good("odd.bvh", odd_bvh, NULL, &no_options);
    assert_int_equal(clip.joint_count, 4);
    assert_int_equal(clip.frame_count, 2);
    assert_int_equal(clip.coordinate_count, 11);
    assert_true(clip.rate == 30.0); /* what the digits of the frame time mean */
    assert_string_equal(clip.joints[1].name, "upper arm");
    assert_string_equal(clip.coordinates[9].name, "prop.Xrotation");
    assert_true(clip.joints[2].parent == 1 && clip.joints[3].parent == SN_NONE);
    /* y up in the file: (x, y, z) is at (x, -z, y), in metres */
    assert_at(clip.joints[2].rest, 0.05, 0, 0.10);
    assert_true(clip.joints[2].has_end && !clip.joints[1].has_end);
    assert_at(clip.joints[2].end, 0.07, 0, 0.10);
    /* frame 1: hips to (1, 2, 3), turned by 90 degrees about z: the arm at (1 - 10, 2, 3); it turns as much again: the hand goes to -x */
    assert_at(moved(&clip, "upper arm", 1, clip.joints[1].rest), -0.09, -0.03, 0.02);
    assert_at(moved(&clip, "hand", 1, clip.joints[2].rest), -0.14, -0.03, 0.02);
    assert_at(moved(&clip, "hand", 1, clip.joints[2].end), -0.16, -0.03, 0.02);
    assert_true(fabs(clip.coordinates[3].values[1] - 0.5 * SN_PI) < 1e-15 && clip.coordinates[2].values[1] == 3.0 * 0.01);
    sn_clip_free(&clip);
}

#define ONE(channels, numbers)                                                                                                             \
    "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS " channels                                                                               \
    "\nEnd Site\n{\nOFFSET 0 0 1\n}\n}\nMOTION\nFrames: 1\nFrame Time: 0.01\n" numbers "\n"

/* Channels multiply in the order in which they stand: by matrices, written out here. */
static void rotations_multiply_in_the_order_of_their_channels(void **state) {
    (void)state;
    const sn_clip_options plain = {.meters_per_unit = 1.0, .up = SN_UP_Z};
    sn_clip clip = read_good("o.bvh", ONE("3 Zrotation Xrotation Yrotation", "90 90 0"), NULL, &plain);
    assert_at(moved(&clip, "r", 0, sn_v3(0, 0, 1)), 1, 0, 0); /* about x: to -y; then about z: to x */
    sn_clip_free(&clip);
    clip = read_good("o.bvh", ONE("3 Xrotation Zrotation Yrotation", "90 90 0"), NULL, &plain);
    assert_at(moved(&clip, "r", 0, sn_v3(0, 0, 1)), 0, -1, 0); /* about z: stays; then about x: to -y */
    sn_clip_free(&clip);
    clip = read_good("o.bvh", ONE("3 Zrotation Xrotation Zrotation", "90 90 90"), NULL, &plain);
    assert_at(moved(&clip, "r", 0, sn_v3(1, 0, 0)), 0, 0, 1); /* about z: to y; about x: to z; about z: stays */
    assert_string_equal(clip.coordinates[2].name, "r.Zrotation2");
    sn_clip_free(&clip);
}

#define MOVED(position)                                                                                                                    \
    "HIERARCHY\nROOT r\n{\nOFFSET 0 0 90\nCHANNELS 3 Xposition Yposition Zposition\n}\nMOTION\nFrames: 1\nFrame Time: 0.01\n" position "\n"

static void positions_add_to_the_offset_or_stand_in_its_place(void **state) {
    (void)state;
    sn_clip_options options = {.meters_per_unit = 1.0, .up = SN_UP_Z};
    const struct {
        const char *text;
        sn_clip_positions how;
        double z;
    } cases[] = {{MOVED("1 2 3"), SN_POSITIONS_AUTO, 93},
                 {MOVED("1 2 88"), SN_POSITIONS_AUTO, 88},
                 {MOVED("1 2 3"), SN_POSITIONS_REPLACE, 3},
                 {MOVED("1 2 88"), SN_POSITIONS_ADD, 178}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        options.positions = cases[i].how;
        sn_clip clip = read_good("p.bvh", cases[i].text, NULL, &options);
        assert_at(moved(&clip, "r", 0, clip.joints[0].rest), 1, 2, cases[i].z);
        sn_clip_free(&clip);
    }
}

static void the_rate_is_what_the_digits_of_the_frame_time_mean(void **state) {
    (void)state;
    const struct {
        const char *time;
        double rate;
    } cases[] = {{"0.0083333", 120.0}, {"0.008333", 120.0},          {"0.0333667", 1.0 / 0.0333667}, {"0.04", 25.0},
                 {"1", 1.0},           {"0.016683", 1.0 / 0.016683}, {"3.3333e-2", 1.0 / 3.3333e-2}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text, "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n}\nMOTION\nFrames: 1\nFrame Time: %s\n0\n",
                 cases[i].time);
        sn_clip clip = read_good("rate.bvh", text, NULL, &no_options);
        if (clip.rate != cases[i].rate) fail_msg("%s: %.17g", cases[i].time, clip.rate);
        sn_clip_free(&clip);
    }
}

static void joints_of_one_name_are_told_apart(void **state) {
    (void)state;
    sn_clip clip = read_good("twice.bvh",
                             "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\nJOINT a\n{\nOFFSET 0 0 1\nCHANNELS 1 "
                             "Xrotation\n}\n}\nMOTION\nFrames: 1\nFrame Time: 1\n0 0\n",
                             NULL, &no_options);
    assert_string_equal(clip.joints[1].name, "a_");
    assert_non_null(strstr(logged, "twice.bvh:6: the joint 'a' becomes 'a_'"));
    sn_clip_free(&clip);
}

#define HEAD "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n}\n"

static void broken_bvh_is_refused_with_line_and_reason(void **state) {
    (void)state;
    refuse("x.bvh", "HIERARCHY\n", NULL, 2, "ends in its hierarchy");
    refuse("x.bvh", "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\n", NULL, 5, "ends in its hierarchy");
    refuse("x.bvh", "HIERARCHY\nROOT\n{\n", NULL, 2, "ROOT has no name");
    refuse("x.bvh", "HIERARCHY\nJOINT r\n{\n", NULL, 2, "outside of a ROOT");
    refuse("x.bvh", "HIERARCHY\nROOT r\n{\nROOT q\n", NULL, 4, "inside of a joint");
    refuse("x.bvh", "HIERARCHY\nROOT r\nOFFSET 0 0 0\n", NULL, 3, "expected '{', found 'OFFSET'");
    refuse("x.bvh", "HIERARCHY\nROOT r\n{\nOFFSET 0 x 0\n", NULL, 4, "'x'");
    refuse("x.bvh", "HIERARCHY\nROOT r\n{\nOFFSET 0 nan 0\n", NULL, 4, "not finite");
    refuse("x.bvh", "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nOFFSET 0 0 0\n", NULL, 5, "twice");
    refuse("x.bvh", "HIERARCHY\nROOT r\n{\nCHANNELS 1 Xrotation\n}\n", NULL, 5, "has no OFFSET");
    refuse("x.bvh", "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 2 Xrotation\n", NULL, 5, "channel 2 of 2");
    refuse("x.bvh", "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 1 Wrotation\n", NULL, 5, "found 'Wrotation'");
    refuse("x.bvh", "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 2 Xposition Xposition\n", NULL, 5, "Xposition stands twice");
    refuse("x.bvh", "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 99 Xposition\n", NULL, 5, "number of channels");
    refuse("x.bvh", "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\n}\nMOTION\n", NULL, 6, "nothing moves");
    refuse("x.bvh", HEAD "}\n", NULL, 7, "ROOT or MOTION is expected");
    refuse("x.bvh", HEAD "MOTION\nFrame Time: 1\n", NULL, 8, "expected 'Frames:'");
    refuse("x.bvh", HEAD "MOTION\nFrames: 0\n", NULL, 8, "at least 1");
    refuse("x.bvh", HEAD "MOTION\nFrames: 1\nFrame Time: 0\n", NULL, 9, "seconds of a frame");
    refuse("x.bvh", HEAD "MOTION\nFrames: 3\nFrame Time: 1\n0\n1\n", NULL, 12, "after 2 of 3 frames");
    refuse("x.bvh", HEAD "MOTION\nFrames: 1\nFrame Time: 1\n0\n1\n", NULL, 11, "goes on behind its 1 frames");
    refuse("x.bvh", HEAD "MOTION\nFrames: 2\nFrame Time: 1\n0\n1 2\n", NULL, 11, "frame 1 has more than 1 numbers");
    refuse("x.bvh", HEAD "MOTION\nFrames: 1\nFrame Time: 1\ninf\n", NULL, 10, "a finite number, found 'inf'");
    refuse("x.bvh", HEAD "MOTION\nFrames: 1000000000\nFrame Time: 1\n0\n", NULL, 9, "do not fit");
    refuse("x.bvh", ONE("3 Zrotation Xrotation Yrotation", "1 2"), NULL, 14, "frame 0 has 2 numbers; the channels are 3");
    refuse("x.bvh", "ANARCHY\n", NULL, 0, "no motion that is known");
}

/* ---- ASF and AMC ------------------------------------------------------------------------------------------------------------------ */

/* Length in units of 2: meters_per_unit 1 makes a number 0.5 m. The children stand before their parents. */
static const char small_asf[] =
    "# small\n:version 1.10\n:name small\n:units\n mass 1.0\n length 2\n angle deg\n:documentation\n any \"text\n:root\n"
    " order TX TY TZ RX RY RZ\n axis XYZ\n position 0 0 0\n orientation 0 0 0\n:bonedata\n begin\n id 2\n name hand\n"
    " direction 0 1 0\n length 2\n axis 90 0 0 XYZ\n dof rz\n limits (-inf inf)\n end\n begin\n id 1\n name arm\n"
    " direction 1 0 0\n length 4\n axis 0 0 90 XYZ\n dof rx ry\n limits (-10 10)\n   (-20.0 20.0)\n end\n"
    ":hierarchy\n begin\n root arm\n arm hand\n end\n";
static const char small_amc[] =
    "#!OML:ASF x\n:FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\narm 0 0\nhand 0\n2\nroot 2 4 6 0 0 90\narm 0 0\n"
    "hand 0\n3\nroot 0 0 0 0 0 0\narm 90 0\nhand 90\n";

static void asf_and_amc_pose_bones_in_their_own_axes(void **state) {
    (void)state;
    const sn_clip_options plain = {.meters_per_unit = 1.0, .up = SN_UP_Z};
    sn_clip clip = read_good("small.amc", small_amc, small_asf, &plain);
    assert_int_equal(clip.joint_count, 3);
    assert_int_equal(clip.frame_count, 3);
    assert_int_equal(clip.coordinate_count, 9);
    assert_string_equal(clip.joints[1].name, "arm");
    assert_string_equal(clip.coordinates[7].name, "arm.ry");
    assert_true(clip.rate == 120.0 && clip.rate_assumed);
    assert_at(clip.joints[2].rest, 2, 0, 0);
    assert_at(clip.joints[2].end, 2, 1, 0);
    assert_at(moved(&clip, "hand", 0, sn_v3(2, 1, 0)), 2, 1, 0);
    assert_at(moved(&clip, "hand", 1, sn_v3(2, 1, 0)), 0, 4, 3); /* turned about z: (-1, 2, 0), and moved by (1, 2, 3) */
    /* frame 2: the arm about its x, which is the world's y: x goes to -z; the hand about its z, the world's -y */
    assert_at(moved(&clip, "arm", 2, sn_v3(2, 0, 0)), 0, 0, -2);
    assert_at(moved(&clip, "hand", 2, sn_v3(3, 0, 0)), 1, 0, -2);
    assert_non_null(strstr(logged, "1 angles lie beyond the limits"));
    sn_clip_free(&clip);
}

static void asf_alone_is_its_rest_pose(void **state) {
    (void)state;
    sn_clip clip = read_good("small.asf", small_asf, NULL, &no_options);
    assert_int_equal(clip.frame_count, 1);
    assert_true(fabs(clip.joints[2].rest.x - 4 * 0.0254 / 2) < 1e-15);
    for (sn_index j = 0; j < 3; j++) assert_true(clip.joints[j].poses[0].rotation.w == 1.0);
    sn_clip_free(&clip);
}

/* Not :FULLY-SPECIFIED: what a frame leaves out stays as it was; radians; a rate. */
static void amc_may_leave_out_what_does_not_move(void **state) {
    (void)state;
    sn_clip clip =
        read_good("part.amc", ":SAMPLES-PER-SECOND 60\n:RADIANS\n7\nhand 0.5\n8\narm 0.25 0\n9\nhand 1\n", small_asf, &no_options);
    const double *hand = clip.coordinates[8].values, *arm = clip.coordinates[6].values;
    assert_true(hand[0] == 0.5 && hand[1] == 0.5 && hand[2] == 1.0);
    assert_true(arm[0] == 0.0 && arm[1] == 0.25 && arm[2] == 0.25);
    assert_true(clip.rate == 60.0 && !clip.rate_assumed);
    sn_clip_free(&clip);
}

static void broken_amc_is_refused_with_line_and_reason(void **state) {
    (void)state;
    refuse("x.amc", ":DEGREES\n", small_asf, 2, "there is no frame");
    refuse("x.amc", ":DEGREES\nroot 1\n1\n", small_asf, 2, "expected the number of a frame");
    refuse("x.amc", ":DEGREES\n1\nfoot 1\n", small_asf, 3, "no bone 'foot'");
    refuse("x.amc", ":DEGREES\n1\nhand 1 2\n", small_asf, 3, "more numbers than its 1");
    refuse("x.amc", ":DEGREES\n1\narm 1\n", small_asf, 3, "'arm' has 1 numbers");
    refuse("x.amc", ":DEGREES\n1\nhand x\n", small_asf, 3, "found 'x'");
    refuse("x.amc", ":DEGREES\n1\nhand 1\nhand 2\n", small_asf, 4, "stands twice");
    refuse("x.amc", ":DEGREES\n1\nhand 1\n3\nhand 2\n", small_asf, 4, "frame 3 follows frame 1");
    refuse("x.amc", ":FULLY-SPECIFIED\n1\nhand 1\n", small_asf, 4, "does not tell 'root'");
    refuse("x.amc", ":DEGREES\n1\nhand 1\n", NULL, 0, "--skeleton");
    refuse("x.amc", ":DEGREES\n1\nhand 1\n", "HIERARCHY\n", 0, "no skeleton of Acclaim's");
    refuse("x.bvh", odd_bvh, small_asf, 0, "takes none");
}

#define BONES ":root\norder TX\n:bonedata\nbegin\nname a\nend\nbegin\nname b\nend\n"

static void broken_asf_is_refused_with_line_and_reason(void **state) {
    (void)state;
    refuse("x.asf", ":version 1\nx\n", NULL, 3, "no :hierarchy"); /* what stands behind :version is its text */
    refuse("x.asf", ":units\nlength 0\n", NULL, 2, "unit of length of 0");
    refuse("x.asf", ":units\nangle grad\n", NULL, 2, "deg or rad");
    refuse("x.asf", ":root\norder TX TX\n", NULL, 2, "tx stands twice");
    refuse("x.asf", ":root\naxis XYX\n", NULL, 2, "an order of axes");
    refuse("x.asf", ":bonedata\nname\n", NULL, 2, "expected begin");
    refuse("x.asf", ":bonedata\nbegin\nname a\n", NULL, 4, "has no 'end'");
    refuse("x.asf", ":bonedata\nbegin\nid 1\nend\n", NULL, 4, "has no name");
    refuse("x.asf", ":bonedata\nbegin\ndof l\n", NULL, 3, "stretch");
    refuse("x.asf", ":bonedata\nbegin\ndof rx\nlimits (1)\n", NULL, 4, "limits (low high) of rx");
    refuse("x.asf", ":bonedata\nbegin\naxis 0 0 nan XYZ\n", NULL, 3, "found 'nan'");
    refuse("x.asf", BONES, NULL, 10, "no :hierarchy");
    refuse("x.asf", BONES ":hierarchy\nroot a c\n", NULL, 11, "no bone 'c'");
    refuse("x.asf", BONES ":hierarchy\nroot a\na a\n", NULL, 12, "cannot hang");
    refuse("x.asf", BONES ":hierarchy\na b\nb a\n", NULL, 4, "hangs on no chain");
    refuse("x.asf", BONES "begin\nname a\nend\n:hierarchy\n", NULL, 13, "two bones");
}

/* ---- motion documents ---------------------------------------------------------------------------------------------------------------- */

static char *written(const sn_clip *clip) {
    sn_motion motion;
    sn_output *output;
    sn_blob blob;
    sn_error error = {0};
    assert_int_equal(sn_clip_to_motion(clip, &motion, &error), SN_OK);
    assert_int_equal(sn_output_open(path_of("out.motion.json"), false, &output, &error), SN_OK);
    assert_int_equal(sn_motion_document_write(&motion, &(sn_motion_head){.name = clip->name, .rate = clip->rate}, output, &error), SN_OK);
    assert_int_equal(sn_output_commit(output, &error), SN_OK);
    assert_int_equal(sn_blob_read(path_of("out.motion.json"), &blob, &error), SN_OK);
    char *text = sn_strdup(blob.data);
    sn_blob_free(&blob);
    sn_motion_free(&motion);
    return text;
}

/* Rest places, ends and coordinates come back with the same bits; poses to rounding. */
static void a_motion_document_is_read_again_as_the_same(void **state) {
    (void)state;
    sn_clip clip = read_good("odd.bvh", odd_bvh, NULL, &no_options);
    char *text = written(&clip);
    assert_non_null(strstr(text, "\"frame\": 1,"));
    sn_clip back = read_good("back.motion.json", text, NULL, &no_options);
    assert_true(back.joint_count == clip.joint_count && back.frame_count == clip.frame_count && back.rate == clip.rate);
    assert_string_equal(back.name, "odd");
    for (sn_index j = 0; j < clip.joint_count; j++) {
        const sn_clip_joint *a = &clip.joints[j], *b = &back.joints[j];
        assert_memory_equal(&a->rest, &b->rest, sizeof a->rest);
        assert_memory_equal(&a->rest_rotation, &b->rest_rotation, sizeof a->rest_rotation);
        assert_true(a->has_end == b->has_end && sn_distance(a->end, b->end) == 0.0);
        for (sn_index f = 0; f < 2; f++)
            assert_true(sn_distance(sn_rigid_apply(a->poses[f], a->rest), sn_rigid_apply(b->poses[f], b->rest)) < 1e-15);
    }
    for (sn_index c = 0; c < clip.coordinate_count; c++) {
        assert_string_equal(back.coordinates[c].unit, clip.coordinates[c].unit);
        assert_memory_equal(back.coordinates[c].values, clip.coordinates[c].values, 2 * sizeof(double));
    }
    sn_clip_free(&clip);
    sn_clip_free(&back);
    free(text);
}

/* A scene takes the document; what it does not need is kept, and written in the scene's plan. */
static void a_scene_reads_the_document_and_keeps_what_is_beside(void **state) {
    (void)state;
    sn_clip clip = read_good("odd.bvh", odd_bvh, NULL, &no_options);
    free(written(&clip)); /* out.motion.json is in the folder */
    sn_blob blob = blob_of("x.scene.json",
                           "{\"format\":\"sinew-scene\",\"version\":1,\"metersPerUnit\":0.01,\"motion\":{\"uri\":\"out.motion.json\"}}");
    sn_scene scene;
    sn_error error = {0};
    if (sn_scene_parse(&blob, false, &scene, &error) != SN_OK) fail_msg("%s", error.text);
    assert_string_equal(logged, "");
    assert_int_equal(scene.motion.joint_count, 4);
    assert_int_equal(scene.motion.coordinate_count, 11);
    assert_true(sn_distance(scene.motion.joints[2].rest, clip.joints[2].rest) == 0.0);
    sn_rigid pose = sn_motion_pose(&scene.motion, 2, 1.0 / 30.0);
    assert_true(sn_distance(sn_rigid_apply(pose, clip.joints[2].end), moved(&clip, "hand", 1, clip.joints[2].end)) < 1e-15);
    sn_scene_free(&scene);
    sn_blob_free(&blob);
    sn_clip_free(&clip);
}

static void hinges_and_broken_documents(void **state) {
    (void)state;
#define DOCUMENT(members) "{\"format\":\"sinew-motion\",\"version\":1," members "}"
    sn_clip clip =
        read_good("h.motion.json",
                  DOCUMENT("\"rate\":10,\"joints\":[{\"name\":\"e\",\"type\":\"hinge\",\"axis\":[0,0,1],\"point\":[1,0,0],\"keys\":"
                           "[[0,0],[0.5,90]]}]"),
                  NULL, &no_options);
    assert_int_equal(clip.frame_count, 6);
    assert_at(clip.joints[0].rest, 1, 0, 0);
    assert_at(moved(&clip, "e", 5, sn_v3(2, 0, 0)), 1, 1, 0);
    sn_clip_free(&clip);
    refuse("x.motion.json", DOCUMENT("\"joints\":[]"), NULL, 0, "no joint");
    refuse("x.motion.json", DOCUMENT("\"joints\":[{\"name\":\"e\",\"type\":\"pose\",\"keys\":[{\"time\":1e9}]}]"), NULL, 0, "too long");
    refuse("x.motion.json", DOCUMENT("\"coordinates\":[{\"name\":\"c\",\"unit\":\"deg\",\"values\":[1]}]"), NULL, 1, "unit");
    refuse("x.motion.json", DOCUMENT("\"coordinates\":[{\"name\":\"c\"}]"), NULL, 1, "values");
}

/* ---- the same capture in two formats ---------------------------------------------------------------------------------------------------
 */

static const char *data_folder(void) { return getenv("DATA") != NULL ? getenv("DATA") : "../shared/data"; }

static bool read_data(const char *name, const char *skeleton, sn_clip *out) {
    char path[512], bones_path[512];
    sn_blob motion = {0}, bones = {0};
    sn_error error = {0};
    snprintf(path, sizeof path, "%s/mocap-cmu/motion/%s", data_folder(), name);
    snprintf(bones_path, sizeof bones_path, "%s/mocap-cmu/motion/%s", data_folder(), skeleton != NULL ? skeleton : "");
    if (access(path, R_OK) != 0) return false;
    assert_int_equal(sn_blob_read(path, &motion, &error), SN_OK);
    if (skeleton != NULL) assert_int_equal(sn_blob_read(bones_path, &bones, &error), SN_OK);
    if (sn_clip_parse(&motion, skeleton != NULL ? &bones : NULL, &no_options, out, &error) != SN_OK)
        fail_msg("%s: %s", error.file, error.text);
    sn_blob_free(&motion);
    sn_blob_free(&bones);
    return true;
}

/* The greatest distance of any joint's centre, or segment's end, in any frame, metres. */
static double greatest_distance(const sn_clip *a, const sn_clip *b) {
    double greatest = 0.0;
    assert_true(a->joint_count == 31 && b->joint_count == 31 && a->frame_count == b->frame_count && a->rate == b->rate);
    for (sn_index j = 0; j < a->joint_count; j++) {
        const sn_clip_joint *joint = &a->joints[j];
        for (sn_index f = 0; f < a->frame_count; f++) {
            sn_vec3 p = sn_rigid_apply(joint->poses[f], joint->rest);
            greatest = fmax(greatest, sn_distance(p, moved(b, joint->name, f, joint->rest)));
            if (!joint->has_end) continue;
            greatest = fmax(greatest, sn_distance(sn_rigid_apply(joint->poses[f], joint->end), moved(b, joint->name, f, joint->end)));
        }
    }
    return greatest;
}

static void acclaim_and_the_bvh_made_from_it_are_the_same_motion(void **state) {
    (void)state;
    const struct {
        const char *amc, *bvh;
        sn_index frames;
        double speed;
    } captures[] = {{"02_01.amc", "cmu_02_01_walk.bvh", 343, 1.18}, {"02_03.amc", "cmu_02_03_run.bvh", 173, 2.58}};
    for (size_t i = 0; i < 2; i++) {
        sn_clip acclaim, biovision;
        if (!read_data(captures[i].bvh, NULL, &biovision)) {
            print_message("mocap-cmu is not there\n");
            skip();
        }
        assert_true(read_data(captures[i].amc, "02.asf", &acclaim));
        assert_int_equal(acclaim.frame_count, captures[i].frames);
        double distance = greatest_distance(&biovision, &acclaim);
        print_message("%s: %.2g cm\n", captures[i].bvh, 100.0 * distance);
        assert_true(100.0 * distance <= 1e-4);
        const sn_clip_joint *root = &acclaim.joints[0];
        sn_vec3 way = sn_sub(root->poses[acclaim.frame_count - 1].translation, root->poses[0].translation);
        double speed = sn_norm(way) * acclaim.rate / acclaim.frame_count; /* as the data's page has it */
        if (!(fabs(speed - captures[i].speed) < 0.01)) fail_msg("%g m/s", speed);
        sn_clip_free(&acclaim);
        sn_clip_free(&biovision);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(bvh_of_any_form_is_read, forget_log),
        cmocka_unit_test(rotations_multiply_in_the_order_of_their_channels),
        cmocka_unit_test(positions_add_to_the_offset_or_stand_in_its_place),
        cmocka_unit_test(the_rate_is_what_the_digits_of_the_frame_time_mean),
        cmocka_unit_test_setup(joints_of_one_name_are_told_apart, forget_log),
        cmocka_unit_test(broken_bvh_is_refused_with_line_and_reason),
        cmocka_unit_test_setup(asf_and_amc_pose_bones_in_their_own_axes, forget_log),
        cmocka_unit_test(asf_alone_is_its_rest_pose),
        cmocka_unit_test(amc_may_leave_out_what_does_not_move),
        cmocka_unit_test(broken_amc_is_refused_with_line_and_reason),
        cmocka_unit_test(broken_asf_is_refused_with_line_and_reason),
        cmocka_unit_test(a_motion_document_is_read_again_as_the_same),
        cmocka_unit_test_setup(a_scene_reads_the_document_and_keeps_what_is_beside, forget_log),
        cmocka_unit_test(hinges_and_broken_documents),
        cmocka_unit_test(acclaim_and_the_bvh_made_from_it_are_the_same_motion),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
