/*
 * ends.h -- the two ends of a muscle as patches of vertices: known sites, attachments, or the tips of its shape. Private to lib/rig.
 *
 * What is better known comes first: sites given by hand; attachments with landmarks; pins; attachments that were found and are trusted;
 * tips. Attachments are taken apart into connected patches, whose bones do not matter: a harmonic field between the two that lie farthest
 * apart along the surface says to which end each of the others belongs.
 */
#ifndef SINEW_RIG_ENDS_H
#define SINEW_RIG_ENDS_H

#include "sinew/rig.h"

#include "tips.h"

/* Vertices of the end at 0 and of the end at 1. */
typedef struct ends {
    sn_ends_choice choice;
    sn_index count;
    sn_index *vertices; /* (vertex_count) of which count are used; none twice */
    double *values;     /* (vertex_count) 0 or 1 */
} ends;

SN_MUST_CHECK sn_status ends_alloc(sn_index vertex_count, ends *out, sn_error *error);
void ends_free(ends *e);

/* What the ends lie on. */
typedef struct ends_surface {
    const sn_mesh *mesh;
    const sn_topology *topology;
    const tips *shape; /* its length is L */
} ends_surface;

/* The best known ends. Attachments make both ends where their patches lie at two places: no point of the surface is farther from all of
 * them than the farthest two are from each other (on average over their vertices). Found ones (contact, proximity) are trusted where they
 * hold 1 % of their end or more, are not scattered (sn_grip_judge), half of their vertices or more are in one patch, and no point is
 * farther from them than 0.6 of what the two ends are from each other; of these, what lies on the middle fifth of the field is left out;
 * all on one bone are no ends. Areas and pins that lie at one end only are that end, and the point farthest from them is the other. Areas
 * that are called origin are the end at 0, those called insertion that at 1; where one of the two is told the other is what lies farthest
 * from it. Where neither is, the end at 0 has the lowest vertex. SN_ERROR_INPUT as ends_from_sites. lib/rig/ends_choose.c */
SN_MUST_CHECK sn_status ends_choose(const ends_surface *surface, const sn_muscle *muscle, sn_index site_count, const sn_end_site *sites,
                                    ends *out, sn_error *error);

/* The vertices within 5 % of L of each site's closest vertex. SN_ERROR_INPUT where an end has no site, where one lies farther than 10 % of
 * L from the surface, or where the ends overlap so much that one has no vertex of its own. */
SN_MUST_CHECK sn_status ends_from_sites(const ends_surface *surface, sn_index count, const sn_end_site *sites, ends *out, sn_error *error);
/* The vertices within 5 % of L of each tip; leaves what the choice says of others. */
SN_MUST_CHECK sn_status ends_from_tips(const ends_surface *surface, ends *out, sn_error *error);
/* Sets what the ends are taken from and which of them is known. */
void ends_source(ends *e, sn_ends_source source, bool first, bool second);
/* Both ends are known, and by more than found attachments. */
bool ends_known(const sn_ends_choice *choice);
/* Adds a sentence's part to why. */
void ends_say(sn_ends_choice *choice, const char *format, ...) SN_PRINTF(2, 3);

#endif
