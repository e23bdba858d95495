/*
 * ends.h -- the two ends of a muscle as patches of vertices: known sites, attachments, or the tips of its shape. Private to lib/rig.
 */
#ifndef SINEW_RIG_ENDS_H
#define SINEW_RIG_ENDS_H

#include "sinew/rig.h"

#include "tips.h"

/* Vertices of the end at 0 and of the end at 1. */
typedef struct ends {
    sn_ends_source source;
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

/* The vertices within 5 % of L of each site's closest vertex. SN_ERROR_INPUT where an end has no site, where one lies farther than 10 % of
 * L from the surface, or where the ends overlap so much that one has no vertex of its own. */
SN_MUST_CHECK sn_status ends_from_sites(const ends_surface *surface, sn_index count, const sn_end_site *sites, ends *out, sn_error *error);
/* The two bones whose attachments lie farthest apart; those between them stay free. areas_only: only attachments whose method is "area":
 * patches of merely detected contact are poor ends of fibres. false = there are no such two. */
bool ends_from_attachments(const sn_muscle *muscle, bool areas_only, ends *out);
/* The vertices within 5 % of L of each tip. */
SN_MUST_CHECK sn_status ends_from_tips(const ends_surface *surface, ends *out, sn_error *error);

#endif
