/* $title
 *
 * A machine as plain C99, printed by supple $version from the equations that it marches. No memory is
 * allocated, nothing but libm is called, and machines share nothing: each thread may step its own.
 *
 * parameters: m.parameter[], set before machine_start, or between steps where the start does not depend on them
$parameters
 *
 * inputs: m.input[], set between steps
$inputs
 *
 * outputs: m.output[], at the time m.time
$outputs
 */
#ifndef MACHINE_H
#define MACHINE_H

#include <stdbool.h>
#include <stdint.h>

#define MACHINE_PARAMETERS $n_parameters
#define MACHINE_INPUTS $n_inputs
#define MACHINE_OUTPUTS $n_outputs
#define MACHINE_CONTACTS $n_contacts /* stops and contacts: m.touching[] */
#define MACHINE_STEP $step /* size of a step, as the case has it */
#define MACHINE_DURATION $duration /* of the run of the case */

/* Everything that a machine is between two steps. It has no pointers: to keep a state, copy it. */
typedef struct {
$members
} machine;

typedef struct {
    const char *name, *unit, *description;
    double start;
} machine_variable;

extern const machine_variable machine_parameters[], machine_inputs[], machine_outputs[];

/* The machine at the start of its run. */
void machine_init(machine *m);

/* The start of the run with other parameters, and inputs as they are set; machine_init has those of the case.
 * Returns 0, or 1 where friction and the forces of joints do not converge. */
int machine_start(machine *m);

/* To the time `end`, by equal steps of MACHINE_STEP at most; outputs are then those at `end`. Inputs act as
 * they are, until `end`. Returns 0, or 1 where Newton's iteration failed with the smallest step: the machine
 * then stands before the step that failed, and does not go on; copy an earlier state back. */
int machine_advance(machine *m, double end);

/* One step of MACHINE_STEP. */
int machine_step(machine *m);

#endif
