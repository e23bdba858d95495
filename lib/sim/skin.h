/*
 * skin.h -- inside lib/sim: the energy of a muscle's closed surface under `qn`, all of its kinds of rows together.
 */
#ifndef SN_SIM_SKIN_H
#define SN_SIM_SKIN_H

#include "rows.h"

/* After the rows: where the surface is closed and held by springs and hinges; else the muscle has no skin, and its kinds are evaluated one
 * by one. */
SN_MUST_CHECK sn_status sn_skin_build(const sn_build *build, sn_error *error);
/* Is this kind of rows in the muscle's skin? */
bool sn_skin_has(const sn_model_muscle *m, sn_row_kind kind);
/* Energy of those kinds at points (point_count), J, the same as theirs one by one but for rounding; the gradient is added, N. Leaves the
 * normals of the triangles in the inputs. */
double sn_skin_evaluate(const sn_model_muscle *m, const sn_muscle_state *s, const sn_point *points, sn_forces gradient);
/* Remember the areas of the points that were evaluated last; has, in those evaluated last, no guarded triangle less than this share of what
 * is remembered? */
void sn_skin_keep(const sn_model_muscle *m, const sn_muscle_state *s);
bool sn_skin_keeps_areas(const sn_model_muscle *m, const sn_muscle_state *s, double least);
/* dV/dx of the points that were evaluated last, to the inputs' volume_gradient. */
void sn_skin_volume_gradient(const sn_model_muscle *m, const sn_muscle_state *s);

#endif
