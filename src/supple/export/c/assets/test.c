/* Compares the machine with values recorded at export, then measures the time per step. */
#include "machine.h"

#include <math.h>
#include <stdio.h>
#include <time.h>

/* Rows of time and outputs. */
static const double recorded[][MACHINE_OUTPUTS + 1] = {
$rows
};

/* For each output, the largest value of its sensor. */
static const double sizes[] = {$sizes};

static double seconds(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

int main(void)
{
    static machine m, half_way;
    const int rows = (int)(sizeof recorded / sizeof recorded[0]);
    double worst = 0.0;
    machine_init(&m);
    for (int row = 0; row < rows; ++row) {
        if (machine_advance(&m, recorded[row][0])) {
            printf("no convergence at t = %g\n", m.time);
            return 1;
        }
        for (int k = 0; k < MACHINE_OUTPUTS; ++k) {
            const double error = fabs(m.output[k] - recorded[row][k + 1]) / sizes[k];
            if (!(error <= worst)) worst = error;
        }
        if (row == rows / 2) half_way = m; /* a copy saves the state .. */
    }
    const machine end = m;
    m = half_way; /* .. and restores it */
    for (int row = rows / 2 + 1; row < rows; ++row) machine_advance(&m, recorded[row][0]);
    for (int k = 0; k < MACHINE_OUTPUTS; ++k)
        if (m.output[k] != end.output[k]) {
            printf("the outputs after restoring a state differ\n");
            return 1;
        }

    double slowest = 0.0;
    int steps = 0;
    machine_init(&m);
    const double begin = seconds();
    while (steps < 1000) {
        const double before = seconds();
        if (machine_step(&m)) break;
        slowest = fmax(slowest, seconds() - before);
        ++steps;
    }
    printf("largest difference %.2g of a sensor's largest value\n", worst);
    printf("%d steps, %.2f us each, the slowest %.0f us\n", steps, (seconds() - begin) / (steps ? steps : 1) * 1e6,
           slowest * 1e6);
    return worst <= $agreement ? 0 : 1;
}
