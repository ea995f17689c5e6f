/* A linear machine for the functions of the FMI interface. Its matrices are in resources/linear.bin:
 *
 *   x' = A x + B (u - u_0),   w = w_0 + C x + D (u - u_0)
 *
 * Inputs are constant within a communication step. The step is exact for any size h:
 * x becomes F x + G (u - u_0), with [F G; 0 1] = exp(h [A B; 0 0]). This file is the same for all machines. */
#ifndef SIMULATION_H
#define SIMULATION_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if defined(_WIN32)
#include <windows.h>
#endif

typedef struct {
    size_t states, inputs, outputs;
    double time, start, step; /* time now; start and time step of the case */
    double *numbers;          /* storage of all arrays below */
    const double *first_input, *rest, *first_state, *a, *b, *c, *d;
    double *input, *output, *x; /* contiguous; with the time, the complete state */
    double *change, *power;     /* (n, n), n = states + inputs: exp - 1 for steps of `size`, and working memory */
    double *work;               /* (states) */
    double size;
} machine;

#define PARAMETERS(m) ((void)(m), (size_t)0)
#define INPUTS(m) (m)->inputs
#define OUTPUTS(m) (m)->outputs
#define STEP(m) (m)->step
#define MACHINE_CONTACTS 0

static const bool TUNABLE[] = {false}; /* there are no parameters */

typedef struct {
    machine m;
    bool begun, changed;
} simulation;

/* The last communication step; its matrices are stored in the machine. */
typedef struct {
    bool made;
    double *direction, *rates;
} last_step;

static void read_outputs(machine *m)
{
    for (size_t k = 0; k < m->outputs; ++k) {
        double sum = m->rest[k];
        for (size_t j = 0; j < m->states; ++j) sum += m->c[k * m->states + j] * m->x[j];
        for (size_t j = 0; j < m->inputs; ++j) sum += m->d[k * m->inputs + j] * (m->input[j] - m->first_input[j]);
        m->output[k] = sum;
    }
}

static void reset(simulation *one)
{
    machine *m = &one->m;
    m->time = m->start;
    memcpy(m->input, m->first_input, m->inputs * sizeof(double));
    memcpy(m->x, m->first_state, m->states * sizeof(double));
    read_outputs(m);
    one->begun = one->changed = false;
}

static FILE *opened_file(const char *path)
{
#if defined(_WIN32)
    wchar_t wide[4096];
    if (!MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 4096)) return NULL;
    return _wfopen(wide, L"rb");
#else
    return fopen(path, "rb");
#endif
}

/* Opens linear.bin; `resources` is a folder (FMI 3) or its URI, file:///.. (FMI 2). */
static FILE *numbers_of(const char *resources)
{
    static const char name[] = "/linear.bin";
    const bool is_uri = strncmp(resources, "file:", 5) == 0;
    if (is_uri) {
        resources += 5;
        if (strncmp(resources, "//", 2) == 0) resources += 2;
        if (strncmp(resources, "localhost/", 10) == 0) resources += 9;
        if (resources[0] == '/' && resources[1] && resources[2] == ':') ++resources; /* /C:/.. */
    }
    char *path = malloc(strlen(resources) + sizeof name), *end = path;
    if (!path) return NULL;
    for (const char *from = resources; *from; ++from) {
        unsigned byte;
        if (is_uri && *from == '%' && sscanf(from + 1, "%2x", &byte) == 1) {
            *end++ = (char)byte;
            from += 2;
        } else
            *end++ = *from;
    }
    memcpy(end, name, sizeof name);
    FILE *found = opened_file(path);
    free(path);
    return found;
}

/* Reads the sizes and arrays of the machine with this token; the file must end after them. */
static bool is_read(machine *m, last_step *last, FILE *file, const char *token)
{
    enum { TOKEN_SIZE = 32, HEAD = 6, MOST = 20000 };
    char own[TOKEN_SIZE];
    double head[HEAD];
    if (strlen(token) != TOKEN_SIZE || fread(own, 1, TOKEN_SIZE, file) != TOKEN_SIZE) return false;
    if (memcmp(own, token, TOKEN_SIZE) != 0 || fread(head, sizeof *head, HEAD, file) != HEAD) return false;
    if (head[0] != 1.0) return false; /* format version, and byte order */
    for (int k = 1; k < 4; ++k)
        if (!(head[k] >= 0.0 && head[k] <= MOST)) return false;
    const size_t x = m->states = (size_t)head[1], i = m->inputs = (size_t)head[2], o = m->outputs = (size_t)head[3];
    m->start = head[4], m->step = head[5];
    const size_t given = i + o + x + x * x + x * i + o * x + o * i, n = x + i;
    double *at = m->numbers = calloc(given + (i + o + x) + 2 * n * n + x + i + o + 1, sizeof(double));
    if (!at || fread(at, sizeof(double), given, file) != given || fgetc(file) != EOF) return false;
    m->first_input = at, at += i;
    m->rest = at, at += o;
    m->first_state = at, at += x;
    m->a = at, at += x * x;
    m->b = at, at += x * i;
    m->c = at, at += o * x;
    m->d = at, at += o * i;
    m->input = at, at += i;
    m->output = at, at += o;
    m->x = at, at += x;
    m->change = at, at += n * n;
    m->power = at, at += n * n;
    m->work = at, at += x;
    last->direction = at, at += i;
    last->rates = at;
    return true;
}

static void closed(simulation *one)
{
    free(one->m.numbers);
}

/* Reads the machine; returns an error message, or NULL. */
static const char *opened(simulation *one, last_step *last, const char *token, const char *resources)
{
    FILE *file = token && resources ? numbers_of(resources) : NULL;
    if (!file) return "the file linear.bin is missing in the resources folder: export the FMU again";
    const bool good = is_read(&one->m, last, file, token);
    fclose(file);
    if (good) {
        reset(one);
        return NULL;
    }
    closed(one);
    return "linear.bin is damaged or belongs to another machine: export the FMU again";
}

static bool started(simulation *one)
{
    (void)one;
    return true;
}

static const double *given_of(const machine *m)
{
    return m->input;
}

static const double *outputs_of(const machine *m)
{
    return m->output;
}

/* A serialized state: time, whether initialization is over, inputs, outputs and states. */
static size_t state_size(const simulation *one)
{
    return (2 + one->m.inputs + one->m.outputs + one->m.states) * sizeof(double);
}

static void write_state(const simulation *one, void *state)
{
    const double head[2] = {one->m.time, one->begun ? 1.0 : 0.0};
    memcpy(state, head, sizeof head);
    memcpy((char *)state + sizeof head, one->m.input, state_size(one) - sizeof head);
}

static void read_state(simulation *one, const void *state)
{
    double head[2];
    memcpy(head, state, sizeof head);
    one->m.time = head[0], one->begun = head[1] != 0.0;
    memcpy(one->m.input, (const char *)state + sizeof head, state_size(one) - sizeof head);
}

/* E = exp(h [A B; 0 0]) - 1 by its Taylor series for h / 2^k, then k times E <- 2 E + E E. Leaving the 1 out
 * preserves the digits of slow motions beside fast ones. False: out of memory, or a number that is not finite. */
static bool has_exponential(machine *m, double h)
{
    enum { TERMS = 16 };
    if (h == m->size) return true;
    m->size = 0.0;
    const size_t x = m->states, i = m->inputs, n = x + i;
    double *own = m->change, *product = m->power, *unit = calloc(n * x + 1, sizeof(double));
    if (!unit) return false;
    double norm = 0.0;
    for (size_t r = 0; r < x; ++r) {
        double sum = 0.0;
        for (size_t c = 0; c < n; ++c) {
            unit[r * n + c] = c < x ? m->a[r * x + c] : m->b[r * i + (c - x)];
            if (c < x) sum += fabs(unit[r * n + c]); /* inputs are constant: they count only in the rows of states */
        }
        norm = fmax(norm, sum);
    }
    int halvings = 0;
    double part = h;
    for (; norm * part > 0.5 && halvings < 1000; ++halvings) part *= 0.5;
    for (size_t k = 0; k < x * n; ++k) unit[k] *= part;
    /* Horner: E = X (1 + X/2 (1 + X/3 (..))); only the first rows of X are not zero. */
    for (size_t k = 0; k < x * n; ++k) own[k] = unit[k] / TERMS;
    for (int term = TERMS - 1; term >= 1; --term) {
        for (size_t r = 0; r < x; ++r) {
            double *row = product + r * n;
            for (size_t c = 0; c < n; ++c) row[c] = unit[r * n + c];
            for (size_t k = 0; k < x; ++k)
                for (size_t c = 0; c < n; ++c) row[c] += unit[r * n + k] * own[k * n + c];
        }
        for (size_t k = 0; k < x * n; ++k) own[k] = product[k] / term;
    }
    for (int halving = 0; halving < halvings; ++halving) {
        for (size_t r = 0; r < x; ++r) {
            double *row = product + r * n;
            for (size_t c = 0; c < n; ++c) row[c] = 2.0 * own[r * n + c];
            for (size_t k = 0; k < x; ++k)
                for (size_t c = 0; c < n; ++c) row[c] += own[r * n + k] * own[k * n + c];
        }
        memcpy(own, product, x * n * sizeof(double));
    }
    free(unit);
    for (size_t k = 0; k < x * n; ++k)
        if (!isfinite(own[k])) return false;
    m->size = h;
    return true;
}

/* Advances to `begin + size`, later than the time of the machine; returns 0, or 1 if it fails. */
static int stepped(machine *m, double begin, double size)
{
    const size_t x = m->states, n = x + m->inputs;
    if (!has_exponential(m, size)) return 1;
    for (size_t r = 0; r < x; ++r) {
        const double *row = m->change + r * n;
        double sum = 0.0;
        for (size_t k = 0; k < x; ++k) sum += row[k] * m->x[k];
        for (size_t k = 0; k < m->inputs; ++k) sum += row[x + k] * (m->input[k] - m->first_input[k]);
        m->work[r] = sum;
    }
    for (size_t r = 0; r < x; ++r) m->x[r] += m->work[r];
    m->time = begin + size;
    read_outputs(m);
    return 0;
}

static void begin_step(last_step *last, const machine *m)
{
    (void)m;
    last->made = false;
}

static void end_step(last_step *last, const machine *m)
{
    last->made = m->size > 0.0;
}

/* Derivatives of the outputs at the end of the last step along `last->direction` of the inputs: C G + D. */
static void differentiate(last_step *last, const machine *m)
{
    const size_t x = m->states, n = x + m->inputs;
    for (size_t r = 0; r < x; ++r) {
        m->work[r] = 0.0;
        for (size_t k = 0; k < m->inputs; ++k) m->work[r] += m->change[r * n + x + k] * last->direction[k];
    }
    for (size_t k = 0; k < m->outputs; ++k) {
        double sum = 0.0;
        for (size_t j = 0; j < x; ++j) sum += m->c[k * x + j] * m->work[j];
        for (size_t j = 0; j < m->inputs; ++j) sum += m->d[k * m->inputs + j] * last->direction[j];
        last->rates[k] = sum;
    }
}

#endif
