/*
 * backend.c -- which back end steps: decided here and nowhere else.
 */
#include "backend.h"

const sn_backend *sn_backend_of(const sn_scene *scene) {
    switch (scene->solver.method) {
    case SN_SOLVER_XPBD:
        return &sn_backend_xpbd;
    case SN_SOLVER_QN:
        return &sn_backend_qn;
    }
    return &sn_backend_xpbd;
}
