/* Functional Mock-up Interface 2.0 (fmi-standard.org), co-simulation. */
#include "instance.h"

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment environment;
} fmi2CallbackFunctions;

typedef struct {
    simulation s;
    last_step last;
    const fmi2CallbackFunctions *callbacks;
} instance;

static fmi2Status failed(instance *one, const char *message)
{
    const fmi2CallbackFunctions *own = one->callbacks;
    if (own && own->logger) own->logger(own->environment, "machine", fmi2Error, "logStatusError", "%s", message);
    return fmi2Error;
}

EXPORT const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

EXPORT const char *fmi2GetVersion(void)
{
    return "2.0";
}

EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component given, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    (void)given, (void)on, (void)n, (void)categories;
    return fmi2OK;
}

EXPORT fmi2Component fmi2Instantiate(fmi2String name, int type, fmi2String token, fmi2String resources,
                                     const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)visible, (void)logging;
    if (type != 1) return NULL; /* co-simulation */
    instance *one = calloc(1, sizeof *one);
    if (!one) return NULL;
    one->callbacks = callbacks;
    const char *cause = opened(&one->s, &one->last, token, resources);
    if (!cause) return one;
    failed(one, cause);
    free(one);
    return NULL;
}

EXPORT void fmi2FreeInstance(fmi2Component given)
{
    instance *one = given;
    if (one) closed(&one->s);
    free(one);
}

EXPORT fmi2Status fmi2SetupExperiment(fmi2Component given, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                      fmi2Real start, fmi2Boolean has_stop, fmi2Real stop)
{
    instance *one = given;
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    return same_time(&one->s.m, start) ? fmi2OK : failed(one, OTHER_START);
}

EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component given)
{
    (void)given;
    return fmi2OK;
}

EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component given)
{
    instance *one = given;
    one->s.begun = true;
    return started(&one->s) ? fmi2OK : failed(one, NO_START);
}

EXPORT fmi2Status fmi2Terminate(fmi2Component given)
{
    (void)given;
    return fmi2OK;
}

EXPORT fmi2Status fmi2Reset(fmi2Component given)
{
    instance *one = given;
    reset(&one->s);
    one->last.made = false;
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetReal(fmi2Component given, const fmi2ValueReference references[], size_t n,
                              fmi2Real values[])
{
    instance *one = given;
    if (!started(&one->s)) return failed(one, NO_START);
    for (size_t k = 0; k < n; ++k) {
        const double *found = readable(&one->s.m, references[k]);
        if (!found) return failed(one, "no variable has this value reference");
        values[k] = *found;
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2SetReal(fmi2Component given, const fmi2ValueReference references[], size_t n,
                              const fmi2Real values[])
{
    instance *one = given;
    for (size_t k = 0; k < n; ++k) {
        const char *cause = set(&one->s, references[k], values[k]);
        if (cause) return failed(one, cause);
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetFMUstate(fmi2Component given, fmi2FMUstate *state)
{
    instance *one = given;
    if (!has_place(state, state_size(&one->s))) return failed(one, NO_MEMORY);
    write_state(&one->s, *state);
    return fmi2OK;
}

EXPORT fmi2Status fmi2SetFMUstate(fmi2Component given, fmi2FMUstate state)
{
    instance *one = given;
    read_state(&one->s, state);
    one->last.made = false;
    return fmi2OK;
}

EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component given, fmi2FMUstate *state)
{
    (void)given;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component given, fmi2FMUstate state, size_t *size)
{
    (void)state;
    *size = state_size(&((instance *)given)->s);
    return fmi2OK;
}

EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component given, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    if (size != state_size(&((instance *)given)->s)) return failed(given, "a serialized state has another size");
    memcpy(bytes, state, size);
    return fmi2OK;
}

EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component given, const fmi2Byte bytes[], size_t size,
                                          fmi2FMUstate *state)
{
    if (size != state_size(&((instance *)given)->s)) return failed(given, "a serialized state has another size");
    if (!has_place(state, size)) return failed(given, NO_MEMORY);
    memcpy(*state, bytes, size);
    return fmi2OK;
}

EXPORT fmi2Status fmi2DoStep(fmi2Component given, fmi2Real begin, fmi2Real size, fmi2Boolean no_return)
{
    instance *one = given;
    (void)no_return;
    begin_step(&one->last, &one->s.m);
    const int how = moved(&one->s.m, begin, size);
    if (how == 0) end_step(&one->last, &one->s.m);
    return how == 0 ? fmi2OK : failed(one, how == 1 ? NO_CONVERGENCE : OTHER_TIME);
}

EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component given, const fmi2ValueReference unknowns[],
                                               size_t n_unknowns, const fmi2ValueReference knowns[],
                                               size_t n_knowns, const fmi2Real seed[], fmi2Real found[])
{
    instance *one = given;
    const char *cause = derivatives(&one->last, &one->s.m, unknowns, n_unknowns, knowns, n_knowns, seed, found);
    return cause ? failed(one, cause) : fmi2OK;
}

/* Functions that a co-simulation of this machine does not support. */
EXPORT fmi2Status fmi2GetInteger(void) { return fmi2Error; }
EXPORT fmi2Status fmi2SetInteger(void) { return fmi2Error; }
EXPORT fmi2Status fmi2GetBoolean(void) { return fmi2Error; }
EXPORT fmi2Status fmi2SetBoolean(void) { return fmi2Error; }
EXPORT fmi2Status fmi2GetString(void) { return fmi2Error; }
EXPORT fmi2Status fmi2SetString(void) { return fmi2Error; }
EXPORT fmi2Status fmi2SetRealInputDerivatives(void) { return fmi2Error; }
EXPORT fmi2Status fmi2GetRealOutputDerivatives(void) { return fmi2Error; }
EXPORT fmi2Status fmi2CancelStep(void) { return fmi2Error; }
EXPORT fmi2Status fmi2GetStatus(void) { return fmi2Error; }
EXPORT fmi2Status fmi2GetRealStatus(void) { return fmi2Error; }
EXPORT fmi2Status fmi2GetIntegerStatus(void) { return fmi2Error; }
EXPORT fmi2Status fmi2GetBooleanStatus(void) { return fmi2Error; }
EXPORT fmi2Status fmi2GetStringStatus(void) { return fmi2Error; }
