#include "machine.h"

$head
$before

$parameters

$inputs

$outputs

static const machine START = {
    $start
};

void machine_init(machine *m)
{
    *m = START;
}

$begin

int machine_advance(machine *m, double end)
{
$body
    return m->failed ? 1 : 0;
}

int machine_step(machine *m)
{
    return machine_advance(m, m->time + MACHINE_STEP);
}
