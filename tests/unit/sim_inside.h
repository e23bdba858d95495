/* sim_inside.h -- for tests that look into a state: what the back ends remember, and what muscles are told. */
#ifndef SIM_INSIDE_H
#define SIM_INSIDE_H

#include "../../lib/sim/qn.h"
#include "../../lib/sim/xpbd.h"
#include "sim_scene.h"

static inline sn_qn *qn_of(const simulation *s) { return sn_qn_of(&s->state->groups[0]); }
static inline sn_xpbd *xpbd_of(const simulation *s) { return sn_xpbd_of(&s->state->muscles[0]); }
static inline sn_inputs *inputs_of(const simulation *s) { return s->state->muscles[0].inputs; }
static inline sn_objective objective_of(const simulation *s, double h) {
    return (sn_objective){.group = &s->model->groups[0], .state = &s->state->groups[0], .h = h};
}

#endif
