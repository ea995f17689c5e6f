/* The machine of machine.c, for the functions of the FMI interface. */
#ifndef SIMULATION_H
#define SIMULATION_H

#include "machine.h"

#include <stddef.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TOKEN "$token" /* instantiation token of this machine */
#define PARAMETERS(m) MACHINE_PARAMETERS
#define INPUTS(m) MACHINE_INPUTS
#define OUTPUTS(m) MACHINE_OUTPUTS
#define STEP(m) MACHINE_STEP

/* Parameters that can be changed after the start. */
static const bool TUNABLE[MACHINE_PARAMETERS + 1] = {$tunable};

/* A machine, and the state of its instance. */
typedef struct {
    machine m;
    bool begun;   /* initialization is over */
    bool changed; /* a parameter was changed, and the start not yet recomputed */
} simulation;

/* The last communication step: the machine at its start, and the time at its end. */
typedef struct {
#if MACHINE_INPUTS
    machine from;
#endif
    double to;
    bool made;
    double direction[MACHINE_INPUTS + 1], rates[MACHINE_OUTPUTS];
} last_step;

static void reset(simulation *one)
{
    machine_init(&one->m);
    one->begun = one->changed = false;
}

/* Prepares the machine; returns an error message, or NULL. */
static const char *opened(simulation *one, last_step *last, const char *token, const char *resources)
{
    (void)last, (void)resources;
    if (!token || strcmp(token, TOKEN) != 0) return "the instantiation token belongs to another machine";
    reset(one);
    return NULL;
}

static void closed(simulation *one)
{
    (void)one;
}

/* Recomputes the start after a change of parameters; false if it does not converge. */
static bool started(simulation *one)
{
    if (!one->changed) return true;
    one->changed = false;
    return machine_start(&one->m) == 0;
}

static const double *given_of(const machine *m)
{
    return (const double *)((const char *)m + $given_at); /* parameters, then inputs */
}

static const double *outputs_of(const machine *m)
{
    return m->output;
}

static size_t state_size(const simulation *one)
{
    return sizeof *one;
}

static void write_state(const simulation *one, void *state)
{
    memcpy(state, one, sizeof *one);
}

static void read_state(simulation *one, const void *state)
{
    memcpy(one, state, sizeof *one);
}

/* Advances to `begin + size`, later than the time of the machine; returns 0, or 1 if it fails. */
static int stepped(machine *m, double begin, double size)
{
    return machine_advance(m, begin + size);
}

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

#if MACHINE_INPUTS
void machine_derivative(const machine *m, double end, const double *direction, double *rates);
#endif

/* Derivatives of the outputs at the end of the last step along `last->direction` of the inputs. */
static void differentiate(last_step *last, const machine *m)
{
    (void)m;
#if MACHINE_INPUTS
    machine_derivative(&last->from, last->to, last->direction, last->rates);
#else
    (void)last;
#endif
}

#endif
