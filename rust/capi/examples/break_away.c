/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* A prepared contact breaks away, turns back and rests, from C.

   break_away FILE.mtbc      a file of Python's save(..., shift=True); prints, for each step, shift, friction along x, number
                             of points that stick, work of friction; then the last step again from the memory before it. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "mtb.h"

static void check(mtb_status status) {
    if (status != MTB_STATUS_OK) {
        fprintf(stderr, "%s\n", mtb_last_error_message());
        exit((int)status);
    }
}

static void step(uint64_t contact, uint64_t n, double along) {
    double velocity[2] = {1.0, 0.0}, shift[2] = {along, 0.0}, force[3], work;
    int32_t *states = malloc(n * sizeof *states);
    check(mtb_contact_step_shifted(contact, NULL, velocity, shift, NAN, force, NULL, NULL));
    check(mtb_contact_friction(contact, n, NULL, NULL, states, &work));
    int stuck = 0;
    for (uint64_t i = 0; i < n; i++) stuck += states[i] == 1;
    printf("%.17g %.17g %d %.17g\n", along, force[0], stuck, work);
    free(states);
}

int main(int count, char **arguments) {
    if (count != 2) {
        fprintf(stderr, "break_away FILE.mtbc\n");
        return 64;
    }
    uint64_t contact, n, size;
    check(mtb_contact_load(arguments[1], &contact));
    check(mtb_contact_size(contact, &n, NULL));
    check(mtb_contact_memory_size(contact, &size));
    double *memory = malloc(size * sizeof *memory);
    for (int k = 0; k < 12; k++) {
        if (k > 0) check(mtb_contact_memory(contact, size, memory));
        step(contact, n, k < 8 ? 3e-7 : k < 11 ? -6e-7 : 0.0);
    }
    check(mtb_contact_remember(contact, size, memory));
    step(contact, n, 0.0);
    free(memory);
    check(mtb_contact_free(contact));
    return 0;
}
