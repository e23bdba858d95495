/*
 * scheme.c -- what back end `xpbd` does and leaves out under each scheme.   numerics.md 2, [R18] alg. 1, [K21] alg. 2 and 4
 *
 *   guarded   every row; inside first, then the surface, then its shape, the volume last; the least areas after each group that can crush
 *             a triangle (once an iteration leaves triangles of 0.01 of their rest area in the dog's biceps, so often 0.37)
 *             no hinge moves a point by more than two edges: one whose arms are stretched 50 times would throw it 15
 *   romeo     the rows of [R18]: no dihedral angles, no least area; one projection of the volume; external constraints one way, last, with
 *             targets where they are when the muscle's turn comes
 *   kohout    [K21]: the surface only; plain position based dynamics, so no stiffness but a factor on each correction; points of 1 kg;
 *             velocities times 0.99 in each step; no contraction. Where contact is on, bones come last in each iteration, by the paper's
 *             voxels unless the scene wants distance fields (contact_voxels.c). Its hinges by one of two rules (dihedral.c):
 *     published   that of the authors' program, which leaves out what its limits exclude
 *     printed     eqs 1, 6 and 7, the angle by arc tangent: eq. 6 as printed gives pi for a flat pair, and its gradient is singular there.
 *                 No hinge moves a point by more than 0.2 mean edges, as a regular one that is off by a radian does. Without a limit they
 *                 alone make the scheme explode: an arm is thrown by up to its length, and the longer it was pulled the farther (volume
 *                 off by 6e25 V0 at 4000 triangles and one iteration; with 2.0, 0.19; 0.5, 0.014; 0.2, 0.003; without hinges, 1e-7).
 *                 Runs that hold without a limit, of 10 iterations, hardly feel this one; 0.1 lets their angles go by 10 to 25 % more
 */
#include "rows.h"

/* [K21] but for its hinges: those of SN_SCHEME_KOHOUT are as published, those of the entry behind all schemes as printed. */
enum { KOHOUT_PRINTED = SN_SCHEME_KOHOUT + 1 };
#define KOHOUT_RULES                                                                                                                       \
    .count = 4, .order = {SN_ROWS_MESH, SN_ROWS_VOLUME, SN_ROWS_DIHEDRAL, SN_ROWS_CONTACT}, .gain = {[SN_ROWS_DIHEDRAL] = 0.9},            \
    .volume_projections = 1, .keep = 0.99, .damps_all = true, .plain = true, .unit_mass = true, .yields = true

static const sn_scheme_rules RULES[] = {
    [SN_SCHEME_GUARDED] =
        {.hinge_clamp = SN_HINGE_CLAMP, .hinge_step = 2.0, .volume_projections = 5, .most_speed = 50.0, .contracts = true, .scales = true},
    [SN_SCHEME_ROMEO] = {.count = 5,
                         .order = {SN_ROWS_MESH, SN_ROWS_INTERNAL, SN_ROWS_RADIAL, SN_ROWS_VOLUME, SN_ROWS_EXTERNAL},
                         .one_way = true,
                         .hinge_clamp = INFINITY,
                         .hinge_step = INFINITY,
                         .volume_projections = 1,
                         .damps_all = true,
                         .contracts = true},
    [SN_SCHEME_KOHOUT] = {KOHOUT_RULES, .hinges_published = true},
    [KOHOUT_PRINTED] = {KOHOUT_RULES, .hinge_clamp = INFINITY, .hinge_step = 0.2},
};

const sn_scheme_rules *sn_scheme_rules_of(const sn_solver_settings *solver) {
    bool printed = solver->scheme == SN_SCHEME_KOHOUT && solver->hinges == SN_HINGES_PRINTED;
    return &RULES[printed ? KOHOUT_PRINTED : (int)solver->scheme];
}

int sn_scheme_order(const sn_scheme_rules *rules, sn_row_kind order[SN_MOST_SWEEPS]) {
    int count = 0;
    for (; count < rules->count; count++) order[count] = rules->order[count];
    for (int kind = 0; rules->count == 0 && kind < SN_ROW_KINDS; kind++) {
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        if (ops->sweep == NULL || kind == SN_ROWS_AREA) continue;
        order[count++] = (sn_row_kind)kind;
        if (ops->crushes) order[count++] = SN_ROWS_AREA;
    }
    return count;
}

int sn_scheme_sweeps(const sn_solver_settings *solver, sn_row_kind kind) {
    sn_row_kind order[SN_MOST_SWEEPS];
    int sweeps = 0, count = sn_scheme_order(sn_scheme_rules_of(solver), order);
    for (int i = 0; i < count; i++) sweeps += order[i] == kind;
    return sweeps;
}
