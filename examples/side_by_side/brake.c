/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* Brake force, normal force and moment of a prepared shoe at three velocities: brake shoe.mtbc */

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

int main(int count, char **arguments) {
    const double speeds[3] = {30.0, 20.0, 10.0};
    uint64_t shoe;
    if (count != 2) return 64;
    check(mtb_contact_load(arguments[1], &shoe));
    for (int k = 0; k < 3; k++) {
        double velocity[2] = {speeds[k], 0.0}, force[3], moment[3];
        check(mtb_contact_step(shoe, NULL, velocity, NAN, force, moment, NULL));
        printf("%g %.17g %.17g %.17g\n", speeds[k], force[0], force[2], moment[1]);
    }
    check(mtb_contact_free(shoe));
    return 0;
}
