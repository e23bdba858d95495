/*
 * selector.h -- a selector as a user writes it on the command line, for root-select and attach-detect --pin.
 */
#ifndef SINEW_SELECTOR_H
#define SINEW_SELECTOR_H

#include "sinew/rig.h"

/* A selector with the memory that it points into. Move it freely: `rule` points to the heap only. */
typedef struct selector {
    sn_selector rule;
    sn_index *indices; /* rule.indices; owned; NULL unless the kind is INDICES */
    char *attribute;   /* rule.attribute; owned; NULL unless the kind is PAINTED */
} selector;

/* Parse
 *   indices:3,4,5           these vertices
 *   near:x,y,z[,n]          the n (1) vertices nearest the point
 *   sphere:x,y,z,r          vertices within r of the point
 *   box:x0,y0,z0,x1,y1,z1   vertices in the box between two opposite corners
 *   plane:px,py,pz,nx,ny,nz the ring of vertices along the section by this plane (a point, a normal)
 *   half:px,py,pz,nx,ny,nz  the vertices on the normal's side of this plane
 *   painted:NAME[>T]        vertices whose attribute NAME is greater than T (0)
 * Coordinates and lengths are in the document's unit. SN_ERROR_USAGE quotes the text and names what is wrong; *out then owns nothing. */
SN_MUST_CHECK sn_status selector_parse(const char *text, selector *out, sn_error *error);
void selector_free(selector *s); /* frees what it owns and zeroes it */

#endif
