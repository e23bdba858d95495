/*
 * fiber_architecture.h -- the part of fiber-fill that measures what it has made: lengths, pennation, cross-section area, tendons.
 */
#ifndef SINEW_TOOLS_FIBER_ARCHITECTURE_H
#define SINEW_TOOLS_FIBER_ARCHITECTURE_H

#include "cli.h"
#include "sinew/architecture.h"

/* What was measured; all zeros at first. */
typedef struct fiber_architecture {
    sn_architecture figures;
    double meters_per_unit;
    bool measured, paints; /* paints: the map is to go into the document */
} fiber_architecture;

/* Measure the muscle's fibres where a report or --tendon HOW wants it, and paint the map on its mesh where HOW makes one. how: "thickness",
 * "painted", "none", two lengths or percentages; NULL = painted where there is such a map, else by thickness. Wrong usage exits. */
SN_MUST_CHECK sn_status fiber_architecture_measure(cli *c, const char *how, sn_muscle *muscle, fiber_architecture *out, sn_error *error);
/* Sections of the document that change beside the fibres: bits of sn_section. */
unsigned fiber_architecture_changes(const fiber_architecture *architecture);
/* The member "architecture" of the open object; nothing where nothing was measured. */
void fiber_architecture_write(sn_json *json, const fiber_architecture *architecture);
void fiber_architecture_free(fiber_architecture *architecture);

#endif
