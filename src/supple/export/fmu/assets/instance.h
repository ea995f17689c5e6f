/* An instance of the machine for co-simulation: what FMI 2 and FMI 3 share. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include "machine.h"

#include <stddef.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TOKEN "$token" /* of this machine */
#define INPUTS_AT $inputs_at
#define OUTPUTS_AT offsetof(machine, output)

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

/* Value references: 0 is the time, then come the inputs, then the outputs. */
static const double *readable(const machine *m, unsigned reference)
{
    if (reference == 0) return &m->time;
    if (reference <= MACHINE_INPUTS) return (const double *)((const char *)m + INPUTS_AT) + (reference - 1);
    if (reference <= MACHINE_INPUTS + MACHINE_OUTPUTS)
        return (const double *)((const char *)m + OUTPUTS_AT) + (reference - 1 - MACHINE_INPUTS);
    return NULL;
}

static double *writable(machine *m, unsigned reference)
{
    return reference >= 1 && reference <= MACHINE_INPUTS ? (double *)readable(m, reference) : NULL;
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

/* A machine is copied into the place of a state, which is made where there is none; false: no memory is left. */
static bool kept(void **state, const void *from)
{
    if (!*state) *state = malloc(sizeof(machine));
    if (*state) memcpy(*state, from, sizeof(machine));
    return *state != NULL;
}

static const char *const NO_CONVERGENCE = "Newton's iteration failed with the smallest step: loads far beyond what "
                                          "the machine carries, or a prescribed motion that jumps";
static const char *const OTHER_TIME = "a step must begin at the time that the machine has reached, and go forward";
static const char *const OTHER_START = "the machine begins at the time at which its case does";

#endif
