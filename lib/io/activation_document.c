/* activation_document.c -- activations over time, a channel each, as a scene takes them. */
#include "motion_document.h"

#include <stdlib.h>

/* What is put out: every stride-th sample. */
static sn_index output_count(const sn_sense *sense) { return (sense->sample_count - 1) / sense->stride + 1; }

static void write_channel(const sn_sense *sense, const char *name, const double *activations, const double *times, double *values,
                          sn_json *json) {
    sn_index count = output_count(sense);
    for (sn_index k = 0; k < count; k++) values[k] = activations[(size_t)k * (size_t)sense->stride];
    sn_json_object(json, name);
    sn_json_numbers(json, "times", times, (size_t)count);
    sn_json_numbers(json, "values", values, (size_t)count);
    sn_json_close(json);
}

static sn_status write_document(const sn_sensors *sensors, const sn_sense *sense, const sn_history_entry *entry, double *numbers,
                                sn_output *output, sn_error *error) {
    sn_index count = output_count(sense);
    sn_json *json = sn_json_begin(output, true);
    if (json == NULL) return sn_fail_memory(error, "an activation document");
    for (sn_index k = 0; k < count; k++) numbers[k] = sense->begin + k / sense->rate;
    sn_json_object(json, NULL);
    sn_json_text(json, "format", "sinew-activation");
    sn_json_integer(json, "version", 1);
    if (sensors->name != NULL) sn_json_text(json, "name", sensors->name);
    sn_json_object(json, "channels");
    for (sn_index i = 0; i < sense->channel_count; i++)
        write_channel(sense, sensors->channels[i].name, sense->activations[i], numbers, numbers + count, json);
    sn_json_close(json);
    sn_history_write(NULL, entry, json);
    return sn_json_end(json, error);
}

sn_status sn_activation_document_write(const sn_sensors *sensors, const sn_sense *sense, const sn_history_entry *entry, sn_output *output,
                                       sn_error *error) {
    double *numbers = sn_alloc((size_t)output_count(sense) * 2, sizeof *numbers);
    if (numbers == NULL) return sn_fail_memory(error, "an activation document");
    sn_status status = write_document(sensors, sense, entry, numbers, output, error);
    free(numbers);
    return status;
}

/* ---- names ------------------------------------------------------------------------------------------------------------- */

static sn_status add_name(sn_muscle_names *out, size_t *capacity, const char *name, sn_error *error) {
    void *names = out->names;
    if (!sn_grow(&names, capacity, (size_t)out->count + 1, sizeof *out->names)) return sn_fail_memory(error, "names");
    out->names = names;
    out->names[out->count] = sn_strdup(name);
    return out->names[out->count++] != NULL ? SN_OK : sn_fail_memory(error, "names");
}

static sn_status parse_names(const sn_json_value *top, sn_muscle_names *out, sn_error *error) {
    sn_json_value format = sn_json_member(top, "format"), channels = sn_json_member(top, "channels"), channel = {0};
    size_t capacity = 0;
    sn_status status = sn_json_has(&format) ? sn_json_expect_format(top, "sinew-activation", 1, error) : SN_OK;
    if (status == SN_OK) status = sn_json_require(&channels, "the channels, an object", error);
    if (status == SN_OK) status = sn_json_expect_object(&channels, error);
    if (status == SN_OK) status = sn_json_check_members(top, sn_activation_members, error);
    while (status == SN_OK && sn_json_next(&channels, &channel)) status = add_name(out, &capacity, channel.key, error);
    if (status == SN_OK && out->count == 0) status = sn_json_complain(&channels, error, "there is no channel");
    return status;
}

sn_status sn_activation_names_parse(const sn_blob *blob, sn_muscle_names *out, sn_error *error) {
    sn_json_tree *tree = NULL;
    *out = (sn_muscle_names){0};
    sn_status status = sn_json_parse(blob, &tree, error);
    if (status == SN_OK) {
        sn_json_value top = sn_json_top(tree);
        status = parse_names(&top, out, error);
    }
    sn_json_tree_free(tree);
    if (status == SN_OK) return SN_OK;
    sn_error_set_file(error, blob->name);
    sn_muscle_names_free(out);
    return status;
}
