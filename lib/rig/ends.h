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

/* What two ends leave out, as shares of the area of the component that both are on. */
typedef struct ends_cover {
    double flat;   /* in none, and the harmonic field between them rises along no edge by a tenth of one in their greatest distance: no way
                      leads on */
    double beyond; /* in none, and farther from the one end than all of the other, by 5 % of L: beyond that */
} ends_cover;
SN_MUST_CHECK sn_status ends_measure_cover(const ends_surface *surface, const ends *e, ends_cover *out, sn_error *error);

/* The best known ends. Attachments make both ends where their patches lie at two places: no point of the surface is farther from all of
 * them than the farthest two are from each other (on average over their vertices). Where the document tells at which end an attachment
 * is, it counts as an area, whatever it came by. Found ones (contact, proximity) are trusted where they hold 1 % of their end or more, half
 * of their vertices or more are in one patch, or in patches of six vertices and a third of the largest or more (heads), and no point is
 * farther from them than 0.6 of what the two ends are from each other; of these, patches of less than a tenth of the largest, and what lies
 * on the middle fifth of the field, are left out; all on one bone are no ends, nor are those that leave more than
 * 10 % of the surface beyond them or 30 % where no way leads on (ends_cover). Areas and pins that lie at one end only are that end, and the
 * point farthest from them is the other. Areas that are called origin are the end at 0, those called insertion that at 1; where one of the
 * two is told the other is what lies farthest from it. Where neither is, the end at 0 has the lowest vertex. SN_ERROR_INPUT as
 * ends_from_sites. lib/rig/ends_choose.c */
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
