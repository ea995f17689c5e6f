/* Functional Mock-up Interface 3.0 (fmi-standard.org), co-simulation. */
#include "instance.h"

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef double fmi3Float64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);

typedef struct {
    simulation s;
    last_step last;
#if MACHINE_CONTACTS
    machine before, trial;
    bool returns_early;
#endif
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} instance;

static fmi3Status failed(instance *one, const char *message)
{
    if (one->log) one->log(one->environment, fmi3Error, "logStatusError", message);
    return fmi3Error;
}

EXPORT const char *fmi3GetVersion(void)
{
    return "3.0";
}

EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance given, fmi3Boolean on, size_t n, const fmi3String categories[])
{
    (void)given, (void)on, (void)n, (void)categories;
    return fmi3OK;
}

EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                                fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
                                                fmi3Boolean early, const fmi3ValueReference required[], size_t n,
                                                fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                                void *intermediate)
{
    (void)name, (void)visible, (void)logging, (void)required, (void)n;
    (void)intermediate;
    instance *one = calloc(1, sizeof *one);
    if (!one) return NULL;
    one->environment = environment;
    one->log = log;
#if MACHINE_CONTACTS
    one->returns_early = events && early;
#else
    (void)events, (void)early;
#endif
    const char *cause = opened(&one->s, &one->last, token, resources);
    if (!cause) return one;
    failed(one, cause);
    free(one);
    return NULL;
}

EXPORT void fmi3FreeInstance(fmi3Instance given)
{
    instance *one = given;
    if (one) closed(&one->s);
    free(one);
}

EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance given, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                              fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop)
{
    instance *one = given;
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    return same_time(&one->s.m, start) ? fmi3OK : failed(one, OTHER_START);
}

EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance given)
{
    instance *one = given;
    one->s.begun = true;
    return started(&one->s) ? fmi3OK : failed(one, NO_START);
}

EXPORT fmi3Status fmi3Terminate(fmi3Instance given)
{
    (void)given;
    return fmi3OK;
}

EXPORT fmi3Status fmi3Reset(fmi3Instance given)
{
    instance *one = given;
    reset(&one->s);
    one->last.made = false;
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetFloat64(fmi3Instance given, const fmi3ValueReference references[], size_t n,
                                 fmi3Float64 values[], size_t n_values)
{
    instance *one = given;
    if (n != n_values) return failed(one, "one number is needed for each variable");
    if (!started(&one->s)) return failed(one, NO_START);
    for (size_t k = 0; k < n; ++k) {
        const double *found = readable(&one->s.m, references[k]);
        if (!found) return failed(one, "no variable has this value reference");
        values[k] = *found;
    }
    return fmi3OK;
}

EXPORT fmi3Status fmi3SetFloat64(fmi3Instance given, const fmi3ValueReference references[], size_t n,
                                 const fmi3Float64 values[], size_t n_values)
{
    instance *one = given;
    if (n != n_values) return failed(one, "one number is needed for each variable");
    for (size_t k = 0; k < n; ++k) {
        const char *cause = set(&one->s, references[k], values[k]);
        if (cause) return failed(one, cause);
    }
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetFMUState(fmi3Instance given, fmi3FMUState *state)
{
    instance *one = given;
    if (!has_place(state, state_size(&one->s))) return failed(one, NO_MEMORY);
    write_state(&one->s, *state);
    return fmi3OK;
}

EXPORT fmi3Status fmi3SetFMUState(fmi3Instance given, fmi3FMUState state)
{
    instance *one = given;
    read_state(&one->s, state);
    one->last.made = false;
    return fmi3OK;
}

EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance given, fmi3FMUState *state)
{
    (void)given;
    free(*state);
    *state = NULL;
    return fmi3OK;
}

EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance given, fmi3FMUState state, size_t *size)
{
    (void)state;
    *size = state_size(&((instance *)given)->s);
    return fmi3OK;
}

EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance given, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    if (size != state_size(&((instance *)given)->s)) return failed(given, "a serialized state has another size");
    memcpy(bytes, state, size);
    return fmi3OK;
}

EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance given, const fmi3Byte bytes[], size_t size,
                                          fmi3FMUState *state)
{
    if (size != state_size(&((instance *)given)->s)) return failed(given, "a serialized state has another size");
    if (!has_place(state, size)) return failed(given, NO_MEMORY);
    memcpy(*state, bytes, size);
    return fmi3OK;
}

EXPORT fmi3Status fmi3DoStep(fmi3Instance given, fmi3Float64 begin, fmi3Float64 size, fmi3Boolean no_return,
                             fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached)
{
    instance *one = given;
    (void)no_return;
    *event = *terminate = *early = false;
    begin_step(&one->last, &one->s.m);
#if MACHINE_CONTACTS
    const double asked = begin + size;
    const int how = one->returns_early ? moved_to_event(&one->s.m, &one->before, &one->trial, begin, size, event)
                                       : moved(&one->s.m, begin, size);
    *early = *event && one->s.m.time < asked;
#else
    const int how = moved(&one->s.m, begin, size);
#endif
    *reached = one->s.m.time;
    if (how == 0) end_step(&one->last, &one->s.m);
    return how == 0 ? fmi3OK : failed(one, how == 1 ? NO_CONVERGENCE : OTHER_TIME);
}

/* Contact forces are penalties: at an event the importer may set inputs; no state jumps. */
EXPORT fmi3Status fmi3EnterEventMode(fmi3Instance given)
{
    (void)given;
    return fmi3OK;
}

EXPORT fmi3Status fmi3UpdateDiscreteStates(fmi3Instance given, fmi3Boolean *again, fmi3Boolean *terminate,
                                           fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *known,
                                           fmi3Float64 *next)
{
    (void)given;
    *again = *terminate = *nominals = *values = *known = false;
    *next = 0.0;
    return fmi3OK;
}

EXPORT fmi3Status fmi3EnterStepMode(fmi3Instance given)
{
    (void)given;
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetDirectionalDerivative(fmi3Instance given, const fmi3ValueReference unknowns[],
                                                size_t n_unknowns, const fmi3ValueReference knowns[],
                                                size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
                                                fmi3Float64 found[], size_t n_found)
{
    if (n_seed != n_knowns || n_found != n_unknowns) return failed(given, "one number is needed for each variable");
    instance *one = given;
    const char *cause = derivatives(&one->last, &one->s.m, unknowns, n_unknowns, knowns, n_knowns, seed, found);
    return cause ? failed(one, cause) : fmi3OK;
}

/* Functions that a co-simulation of this machine does not support. */
EXPORT fmi3Instance fmi3InstantiateModelExchange(void) { return NULL; }
EXPORT fmi3Instance fmi3InstantiateScheduledExecution(void) { return NULL; }
EXPORT fmi3Status fmi3GetFloat32(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetFloat32(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetInt8(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetInt8(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetUInt8(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetUInt8(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetInt16(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetInt16(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetUInt16(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetUInt16(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetInt32(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetInt32(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetUInt32(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetUInt32(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetInt64(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetInt64(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetUInt64(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetUInt64(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetBoolean(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetBoolean(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetString(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetString(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetBinary(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetBinary(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetClock(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetClock(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetNumberOfVariableDependencies(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetVariableDependencies(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetAdjointDerivative(void) { return fmi3Error; }
EXPORT fmi3Status fmi3EnterConfigurationMode(void) { return fmi3Error; }
EXPORT fmi3Status fmi3ExitConfigurationMode(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetIntervalDecimal(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetIntervalFraction(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetShiftDecimal(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetShiftFraction(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetIntervalDecimal(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetIntervalFraction(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetShiftDecimal(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetShiftFraction(void) { return fmi3Error; }
EXPORT fmi3Status fmi3EvaluateDiscreteStates(void) { return fmi3Error; }
EXPORT fmi3Status fmi3EnterContinuousTimeMode(void) { return fmi3Error; }
EXPORT fmi3Status fmi3CompletedIntegratorStep(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetTime(void) { return fmi3Error; }
EXPORT fmi3Status fmi3SetContinuousStates(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetContinuousStateDerivatives(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetEventIndicators(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetContinuousStates(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetNominalsOfContinuousStates(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetNumberOfEventIndicators(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetNumberOfContinuousStates(void) { return fmi3Error; }
EXPORT fmi3Status fmi3GetOutputDerivatives(void) { return fmi3Error; }
EXPORT fmi3Status fmi3ActivateModelPartition(void) { return fmi3Error; }
