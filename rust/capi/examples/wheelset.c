/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* A wheelset on its sinusoidal path from C: 20 m long, 4 mm to either side, at 30 m/s.

   wheelset FILE.mtbw      prints, for each step, way, y, yaw, height and roll found, force, moment, heat and
                           number of patches; then each patch of the last one: side, normal force, creepages,
                           points along x and y, and for each point pressure, traction, slip velocity, status. */

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
    if (count != 2) {
        fprintf(stderr, "wheelset FILE.mtbw\n");
        return 64;
    }
    uint64_t wheels;
    double axle[3];
    check(mtb_wheels_load(arguments[1], &wheels));
    check(mtb_wheels_reference_point(wheels, axle));

    const double speed = 30.0, amplitude = 4e-3, wave = 2.0 * acos(-1.0) / 20.0;
    const double spin = speed / axle[2];
    mtb_wheel_step step;
    for (int k = 0; k < 20; k++) {
        double way = k, y = amplitude * sin(wave * way), yaw = amplitude * wave * cos(wave * way);
        double rate = -wave * wave * speed * y; /* of the yaw */
        double pose[6] = {way, y, NAN, NAN, 0.0, yaw};
        /* it turns about its axle, which yaws, and rolls by what the first of two steps finds */
        double velocity[6] = {speed, speed * yaw, 0.0, -spin * yaw, spin, rate};
        check(mtb_wheels_step(wheels, pose, velocity, &step));
        velocity[5] += spin * step.pose[3];
        check(mtb_wheels_step(wheels, pose, velocity, &step));
        printf("%.17g %.17g %.17g %.17g %.17g", way, y, yaw, step.pose[2], step.pose[3]);
        for (int c = 0; c < 3; c++) printf(" %.17g", step.force[c]);
        for (int c = 0; c < 3; c++) printf(" %.17g", step.moment[c]);
        printf(" %.17g %d\n", step.friction_power, (int)step.patches);
    }

    for (uint64_t index = 0; index < step.patches; index++) {
        mtb_wheel_patch patch;
        check(mtb_wheels_patch(wheels, index, &patch));
        printf("%d %.17g %.17g %.17g %.17g %d %d\n", (int)patch.side, patch.normal_force, patch.creepage[0],
               patch.creepage[1], patch.creepage[2], (int)patch.nx, (int)patch.ny);
        uint64_t n = patch.nx * patch.ny;
        double *field = malloc(5 * n * sizeof *field);
        int32_t *status = malloc(n * sizeof *status);
        check(mtb_wheels_fields(wheels, index, n, field, field + n, field + 3 * n, status));
        for (uint64_t i = 0; i < n; i++) {
            for (int c = 0; c < 5; c++) printf("%.17g ", field[c * n + i]);
            printf("%d\n", (int)status[i]);
        }
        free(field);
        free(status);
    }
    check(mtb_wheels_free(wheels));
    return 0;
}
