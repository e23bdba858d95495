/* envelope_deform.c -- how long a frame of an envelope takes: envelope_deform FILE.envelope.json; the least of 200, on one thread. */
#include "sinew/io.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Poses that all differ: what they are changes nothing about the time. */
static double time_method(sn_envelope *envelope, sn_envelope_method method, sn_rigid *poses, sn_vec3 *positions) {
    double least = INFINITY;
    envelope->method = method;
    for (sn_index b = 0; b < envelope->bone_count; b++)
        poses[b] = (sn_rigid){sn_quat_axis_angle(sn_v3(0, 0, 1), 0.01 * b), {0, 0, 0.1 * b}};
    for (int k = 0; k < 200; k++) {
        double begun = seconds();
        sn_envelope_deform(envelope, poses, NULL, positions);
        least = fmin(least, seconds() - begun);
    }
    return least;
}

int main(int argc, char **argv) {
    sn_blob blob;
    sn_envelope envelope;
    sn_error error = {0};
    if (argc != 2 || sn_blob_read(argv[1], &blob, &error) != SN_OK || sn_envelope_parse(&blob, &envelope, &error) != SN_OK) {
        fprintf(stderr, "envelope_deform: %s\n", argc != 2 ? "name an envelope document" : error.text);
        return 1;
    }
    sn_rigid *poses = SN_NEW(sn_rigid, envelope.bone_count);
    sn_vec3 *positions = SN_NEW(sn_vec3, envelope.mesh.vertex_count);
    for (int m = SN_ENVELOPE_BLEND; poses != NULL && positions != NULL && m <= SN_ENVELOPE_WRAP; m++)
        printf("a frame of %d vertices, %s\t%.3f\n", envelope.mesh.vertex_count, sn_envelope_method_names[m],
               1e3 * time_method(&envelope, (sn_envelope_method)m, poses, positions));
    free(poses);
    free(positions);
    sn_envelope_free(&envelope);
    sn_blob_free(&blob);
    return 0;
}
