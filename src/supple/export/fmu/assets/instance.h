/* A co-simulation instance: the part common to FMI 2 and FMI 3, and to all machines (simulation.h). */
#ifndef INSTANCE_H
#define INSTANCE_H

#include "simulation.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

#define GIVEN(m) (PARAMETERS(m) + INPUTS(m)) /* values that can be set, in this order */

/* Computes derivatives of outputs at the end of the last step along a direction of the inputs; returns an error
 * message, or NULL. */
static const char *derivatives(last_step *last, const machine *m, const unsigned unknowns[], size_t n_unknowns,
                               const unsigned knowns[], size_t n_knowns, const double seed[], double found[])
{
    const size_t parameters = PARAMETERS(m), inputs = INPUTS(m), given = GIVEN(m);
    if (inputs == 0) return "the machine has no inputs, hence no derivatives";
    if (!last->made) return "derivatives are computed for the last step: call DoStep first";
    for (size_t k = 0; k < inputs; ++k) last->direction[k] = 0.0;
    for (size_t k = 0; k < n_knowns; ++k) {
        if (!(knowns[k] > parameters && knowns[k] <= given)) return "derivatives exist with respect to inputs only";
        last->direction[knowns[k] - 1 - parameters] += seed[k];
    }
    differentiate(last, m);
    for (size_t k = 0; k < n_unknowns; ++k) {
        if (!(unknowns[k] > given && unknowns[k] <= given + OUTPUTS(m))) return "derivatives exist of outputs only";
        found[k] = last->rates[unknowns[k] - 1 - given];
        if (!isfinite(found[k])) return "the derivative of an output is not finite here";
    }
    return NULL;
}

/* Address of a variable. Value references: 0 is the time, followed by parameters, inputs and outputs. */
static const double *readable(const machine *m, unsigned reference)
{
    if (reference == 0) return &m->time;
    if (reference <= GIVEN(m)) return given_of(m) + (reference - 1);
    if (reference <= GIVEN(m) + OUTPUTS(m)) return outputs_of(m) + (reference - 1 - GIVEN(m));
    return NULL;
}

/* Sets a value; returns an error message, or NULL. */
static const char *set(simulation *one, unsigned reference, double value)
{
    const bool parameter = reference >= 1 && reference <= PARAMETERS(&one->m);
    if (!(reference >= 1 && reference <= GIVEN(&one->m))) return "only parameters and inputs can be set";
    if (!isfinite(value)) return "a parameter or an input must be a finite number";
    if (parameter && one->begun && !TUNABLE[reference - 1]) return "the start depends on this parameter: set it earlier";
    *(double *)readable(&one->m, reference) = value;
    one->changed = one->changed || (parameter && !one->begun);
    return NULL;
}

static bool same_time(const machine *m, double time)
{
    return fabs(time - m->time) <= 1e-6 * STEP(m);
}

/* Advances to `begin + size`; returns 0, or 1 if it fails, or 2 if `begin` is not the time of the machine. */
static int moved(machine *m, double begin, double size)
{
    if (!same_time(m, begin) || !(size >= 0.0)) return 2;
    return size > 0.0 ? stepped(m, begin, size) : 0;
}

#if MACHINE_CONTACTS
#define HALVINGS 10 /* bisections of the step in which a contact changes */

/* Advances as `moved`, but stops where a stop or contact closes or opens and then sets *event. `before` and
 * `trial` are working memory. */
static int moved_to_event(machine *m, machine *before, machine *trial, double begin, double size, bool *event)
{
    if (!same_time(m, begin) || !(size >= 0.0)) return 2;
    const double first = m->time, whole = begin + size - first;
    const double steps = ceil(whole / MACHINE_STEP * (1.0 - 1e-12));
    for (double k = 1.0; k <= steps; ++k) {
        *before = *m;
        if (machine_advance(m, k == steps ? begin + size : first + whole * (k / steps))) return 1;
        if (memcmp(before->touching, m->touching, sizeof m->touching) == 0) continue;
        double low = before->time;
        for (int halving = 0; halving < HALVINGS; ++halving) {
            const double middle = 0.5 * (low + m->time);
            *trial = *before;
            if (machine_advance(trial, middle)) break;
            if (memcmp(before->touching, trial->touching, sizeof m->touching) == 0)
                low = middle;
            else
                *m = *trial;
        }
        *event = true;
        return 0;
    }
    return 0;
}
#endif

/* Allocates a state if there is none; false if memory is exhausted. */
static bool has_place(void **state, size_t size)
{
    if (!*state) *state = malloc(size);
    return *state != NULL;
}

static const char *const NO_MEMORY = "out of memory";
static const char *const NO_START = "friction and joint forces do not converge at the start: check parameters and inputs";
static const char *const NO_CONVERGENCE = "Newton's iteration failed with the smallest step: check for excessive "
                                          "loads, or jumps of a prescribed motion";
static const char *const OTHER_TIME = "a step must begin at the current time of the machine, and not go backward";
static const char *const OTHER_START = "the start time must be that of the case";

#endif
