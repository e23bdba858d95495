/*
 * fiber_architecture.c -- fibre lengths, pennation and cross-section areas for fiber-fill's report; the tendon map for the document.
 */
#include "fiber_architecture.h"

#include <stdlib.h>
#include <string.h>

#define DEGREES (180.0 / SN_PI)

/* ---- --tendon ----------------------------------------------------------------------------------------------------------------- */

/* "20mm" or "30%". */
static sn_status parse_end(const char *text, double meters_per_unit, sn_tendon_end *out, sn_error *error) {
    size_t size = strlen(text);
    char *number = sn_strndup(text, size > 0 ? size - 1 : 0);
    sn_length length = {0};
    sn_status status = number != NULL ? SN_OK : sn_fail_memory(error, "--tendon");
    out->is_share = size > 0 && text[size - 1] == '%';
    if (status == SN_OK && out->is_share) {
        status = sn_parse_number(number, &out->length, error);
        out->length /= 100.0;
    } else if (status == SN_OK) {
        status = sn_parse_length(text, &length, error);
        out->length = sn_length_meters(length, meters_per_unit) / meters_per_unit;
    }
    free(number);
    return status;
}

static sn_status parse_ends(const char *how, double meters_per_unit, sn_architecture_params *params, sn_error *error) {
    const char *comma = strchr(how, ',');
    if (comma == NULL || strchr(comma + 1, ',') != NULL)
        return sn_fail(error, SN_ERROR_USAGE,
                       "--tendon takes thickness, painted, none, or what is tendon at the origin and at the insertion, "
                       "as in 0,80mm or 5%%,30%%");
    char *first = sn_strndup(how, (size_t)(comma - how));
    sn_status status = first != NULL ? SN_OK : sn_fail_memory(error, "--tendon");
    params->tendon = SN_TENDON_GIVEN;
    if (status == SN_OK) status = parse_end(first, meters_per_unit, &params->ends[0], error);
    if (status == SN_OK) status = parse_end(comma + 1, meters_per_unit, &params->ends[1], error);
    free(first);
    return status;
}

static sn_status choose(const char *how, const sn_muscle *muscle, sn_architecture_params *params, sn_error *error) {
    bool painted = sn_mesh_attribute(&muscle->mesh, SN_TENDON_ATTRIBUTE) != NULL;
    if (how == NULL) how = sn_tendon_names[painted ? SN_TENDON_PAINTED : SN_TENDON_THICKNESS];
    for (int i = 0; i < SN_TENDON_GIVEN; i++) {
        if (strcmp(how, sn_tendon_names[i]) != 0) continue;
        params->tendon = (sn_tendon_source)i;
        return SN_OK;
    }
    sn_status status = parse_ends(how, muscle->meters_per_unit, params, error);
    return status == SN_ERROR_INPUT ? SN_ERROR_USAGE : status;
}

/* ---- the map on the mesh -------------------------------------------------------------------------------------------------------- */

static sn_status paint(const double *map, sn_mesh *mesh, sn_error *error) {
    sn_mesh_remove_attribute(mesh, SN_TENDON_ATTRIBUTE);
    sn_attribute *attribute = sn_mesh_add_attribute(mesh, SN_TENDON_ATTRIBUTE, 1);
    if (attribute == NULL) return sn_fail_memory(error, "the map of tendons");
    memcpy(attribute->values, map, (size_t)mesh->vertex_count * sizeof *map);
    return SN_OK;
}

static void say(const cli *c, const sn_architecture *a) {
    cli_say(c, "tendon by %s: %.1f %% of the fibres' length; belly fibres %.4g, tip to tip %.4g; pennation %.1f and %.1f degrees",
            sn_tendon_names[a->tendon], 100.0 * a->tendon_share, a->belly.mean, a->length.mean, a->pennation[0].mean * DEGREES,
            a->pennation[1].mean * DEGREES);
    if (a->belly_fibers < a->fibers)
        cli_warn(c, "%ld of %ld fibres lie in tendon all along: they have no part in the belly", (long)(a->fibers - a->belly_fibers),
                 (long)a->fibers);
}

sn_status fiber_architecture_measure(cli *c, const char *how, sn_muscle *muscle, fiber_architecture *out, sn_error *error) {
    sn_architecture_params params = sn_architecture_defaults();
    if (muscle->fibers.polyline_count == 0 || (how == NULL && c->report == NULL)) return SN_OK;
    sn_status status = choose(how, muscle, &params, error);
    if (status == SN_OK) status = sn_architecture_measure(muscle, &params, &out->figures, error);
    if (status != SN_OK) return status;
    out->measured = true;
    out->meters_per_unit = muscle->meters_per_unit;
    out->paints = how != NULL && (params.tendon == SN_TENDON_THICKNESS || params.tendon == SN_TENDON_GIVEN);
    say(c, &out->figures);
    return out->paints ? paint(out->figures.map, &muscle->mesh, error) : SN_OK;
}

/* The surface is the same: what was made from it stays, and is written anew. */
unsigned fiber_architecture_changes(const fiber_architecture *architecture) {
    if (!architecture->paints) return 0;
    return SN_SECTION_MESH | SN_SECTION_ROOTS | SN_SECTION_STRUCTURE | SN_SECTION_ATTACHMENTS | SN_SECTION_EXTERNALS;
}

/* ---- report --------------------------------------------------------------------------------------------------------------------- */

typedef struct named_figure {
    const char *name;
    double value;
} named_figure;

static void write_figures(sn_json *json, const named_figure *figures, size_t count) {
    for (size_t i = 0; i < count; i++) sn_json_number(json, figures[i].name, figures[i].value);
}

void fiber_architecture_write(sn_json *json, const fiber_architecture *architecture) {
    const sn_architecture *a = &architecture->figures;
    double unit = architecture->meters_per_unit;
    if (!architecture->measured) return;
    const named_figure figures[] = {
        {"metersPerUnit", unit},
        {"volume", a->volume},
        {"volumeCubicMeters", a->volume * unit * unit * unit},
        {"lengthMean", a->length.mean},
        {"lengthDeviation", a->length.deviation},
        {"lengthLeast", a->length.least},
        {"lengthGreatest", a->length.greatest},
        {"lengthMeanMeters", a->length.mean * unit},
        {"pennationOriginDegrees", a->pennation[0].mean * DEGREES},
        {"pennationOriginDeviationDegrees", a->pennation[0].deviation * DEGREES},
        {"pennationInsertionDegrees", a->pennation[1].mean * DEGREES},
        {"pennationInsertionDeviationDegrees", a->pennation[1].deviation * DEGREES},
        {"physiologicalArea", a->area},
        {"physiologicalAreaSquareMeters", a->area * unit * unit},
    };
    const named_figure bellies[] = {
        {"tendonLengthShare", a->tendon_share},
        {"tendonVolumeShare", a->tendon_volume},
        {"bellyLengthMean", a->belly.mean},
        {"bellyLengthDeviation", a->belly.deviation},
        {"bellyLengthLeast", a->belly.least},
        {"bellyLengthGreatest", a->belly.greatest},
        {"bellyLengthMeanMeters", a->belly.mean * unit},
        {"bellyPhysiologicalArea", a->belly_area},
        {"bellyPhysiologicalAreaSquareMeters", a->belly_area * unit * unit},
    };
    sn_json_object(json, "architecture");
    sn_json_integer(json, "fibers", a->fibers);
    sn_json_bool(json, "closed", a->closed);
    write_figures(json, figures, sizeof figures / sizeof *figures);
    sn_json_text(json, "tendon", sn_tendon_names[a->tendon]);
    sn_json_integer(json, "bellyFibers", a->belly_fibers);
    write_figures(json, bellies, sizeof bellies / sizeof *bellies);
    sn_json_close(json);
}

void fiber_architecture_free(fiber_architecture *architecture) { sn_architecture_free(&architecture->figures); }
