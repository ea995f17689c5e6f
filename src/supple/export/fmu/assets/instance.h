/* An instance of the machine for co-simulation: what FMI 2 and FMI 3 share. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include "machine.h"

#include <stddef.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TOKEN "$token" /* of this machine */
#define GIVEN_AT $given_at
#define GIVEN (MACHINE_PARAMETERS + MACHINE_INPUTS) /* they stand in this order */
#define OUTPUTS_AT offsetof(machine, output)

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

/* Parameters that can be changed after the start. */
static const bool TUNABLE[MACHINE_PARAMETERS + 1] = {$tunable};

/* A machine, and where its instance stands. */
typedef struct {
    machine m;
    bool begun;   /* initialization is over */
    bool changed; /* a parameter was, and the start has not been made from it */
} simulation;

static void reset(simulation *one)
{
    machine_init(&one->m);
    one->begun = one->changed = false;
}

/* The start that the parameters give; false where there is none. */
static bool started(simulation *one)
{
    if (!one->changed) return true;
    one->changed = false;
    return machine_start(&one->m) == 0;
}

#if MACHINE_INPUTS
void machine_derivative(const machine *m, double end, const double *direction, double *rates);
#endif

/* The last communication step: from this machine to that time. */
typedef struct {
#if MACHINE_INPUTS
    machine from;
#endif
    double to;
    bool made;
} last_step;

static void begin_step(last_step *last, const machine *m)
{
#if MACHINE_INPUTS
    last->from = *m;
#else
    (void)m;
#endif
    last->made = false;
}

static void end_step(last_step *last, const machine *m)
{
    last->to = m->time;
    last->made = true;
}

/* Derivatives of outputs at the end of the last step along a direction of its inputs; why there are none, or NULL. */
static const char *derivatives(const last_step *last, const unsigned unknowns[], size_t n_unknowns,
                               const unsigned knowns[], size_t n_knowns, const double seed[], double found[])
{
#if MACHINE_INPUTS
    double direction[MACHINE_INPUTS] = {0}, rates[MACHINE_OUTPUTS];
    if (!last->made) return "derivatives are those of a step: make one first";
    for (size_t k = 0; k < n_knowns; ++k) {
        if (!(knowns[k] > MACHINE_PARAMETERS && knowns[k] <= GIVEN)) return "derivatives are with respect to inputs";
        direction[knowns[k] - 1 - MACHINE_PARAMETERS] += seed[k];
    }
    machine_derivative(&last->from, last->to, direction, rates);
    for (size_t k = 0; k < n_unknowns; ++k) {
        if (!(unknowns[k] > GIVEN && unknowns[k] <= GIVEN + MACHINE_OUTPUTS)) return "derivatives are those of outputs";
        found[k] = rates[unknowns[k] - 1 - GIVEN];
        if (!isfinite(found[k])) return "an output has no derivative here";
    }
    return NULL;
#else
    (void)last, (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)found;
    return "a machine without inputs has no derivatives";
#endif
}

/* Value references: 0 is the time, then come parameters, inputs and outputs. */
static const double *readable(const machine *m, unsigned reference)
{
    if (reference == 0) return &m->time;
    if (reference <= GIVEN) return (const double *)((const char *)m + GIVEN_AT) + (reference - 1);
    if (reference <= GIVEN + MACHINE_OUTPUTS)
        return (const double *)((const char *)m + OUTPUTS_AT) + (reference - 1 - GIVEN);
    return NULL;
}

/* Why a value was not set; NULL where it was. */
static const char *set(simulation *one, unsigned reference, double value)
{
    const bool parameter = reference >= 1 && reference <= MACHINE_PARAMETERS;
    if (!(reference >= 1 && reference <= GIVEN)) return "only parameters and inputs can be set";
    if (!isfinite(value)) return "a parameter or an input must be a finite number";
    if (parameter && one->begun && !TUNABLE[reference - 1]) return "the start depends on this parameter: set it before";
    *(double *)readable(&one->m, reference) = value;
    one->changed = one->changed || (parameter && !one->begun);
    return NULL;
}

static bool same_time(double a, double b)
{
    return fabs(a - b) <= 1e-6 * MACHINE_STEP;
}

/* To `begin + size`; 0 where the machine got there. */
static int moved(machine *m, double begin, double size)
{
    if (!same_time(begin, m->time) || !(size >= 0.0)) return 2;
    return size > 0.0 ? machine_advance(m, begin + size) : 0;
}

#if MACHINE_CONTACTS
#define HALVINGS 10 /* of the step within which a contact changes */

/* The same, but only to where a stop or contact begins or ends to touch, then *event; two machines are needed. */
static int moved_to_event(machine *m, machine *before, machine *trial, double begin, double size, bool *event)
{
    if (!same_time(begin, m->time) || !(size >= 0.0)) return 2;
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

/* A machine is copied into the place of a state, which is made where there is none; false: no memory is left. */
static bool kept(void **state, const void *from)
{
    if (!*state) *state = malloc(sizeof(simulation));
    if (*state) memcpy(*state, from, sizeof(simulation));
    return *state != NULL;
}

static const char *const NO_START = "friction and the forces of joints do not converge at the start";
static const char *const NO_CONVERGENCE = "Newton's iteration failed with the smallest step: loads far beyond what "
                                          "the machine carries, or a prescribed motion that jumps";
static const char *const OTHER_TIME = "a step must begin at the time that the machine has reached, and go forward";
static const char *const OTHER_START = "the machine begins at the time at which its case does";

#endif
