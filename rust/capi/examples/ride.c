/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* A ride of a prepared contact from C: slows down, turns back, tilts; two threads share the matrices.

   ride FILE.mtbc      prints, for each step, velocity, force and moment; then pressures of the last one. */

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#include "mtb.h"

static void check(mtb_status status) {
    if (status != MTB_STATUS_OK) {
        fprintf(stderr, "%s\n", mtb_last_error_message());
        exit((int)status);
    }
}

static void step(uint64_t contact, double speed, double pitch, double force[3], double moment[3]) {
    double pose[6] = {NAN, NAN, NAN, NAN, pitch, NAN};
    double velocity[2] = {speed, 0.0};
    check(mtb_contact_step(contact, pose, velocity, NAN, force, moment, NULL));
}

static void *second(void *handle) {
    double force[3], moment[3];
    for (int k = 0; k < 20; k++) step(*(uint64_t *)handle, 20.0 - k, 0.0, force, moment);
    return NULL;
}

int main(int count, char **arguments) {
    if (count != 2) {
        fprintf(stderr, "ride FILE.mtbc\n");
        return 64;
    }
    uint64_t contact, copy, n, m;
    check(mtb_contact_load(arguments[1], &contact));
    check(mtb_contact_copy(contact, &copy));
    check(mtb_contact_size(contact, &n, &m));

    pthread_t thread;
    pthread_create(&thread, NULL, second, &copy);
    for (int k = 0; k < 20; k++) {
        double force[3], moment[3];
        double speed = k < 15 ? 30.0 - 2.0 * k : -1.0, pitch = 1e-6 * k;
        step(contact, speed, pitch, force, moment);
        printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", speed, pitch, force[0], force[1],
               force[2], moment[0], moment[1], moment[2]);
    }
    pthread_join(thread, NULL);

    double *pressure = malloc(n * sizeof *pressure);
    check(mtb_contact_pressure(contact, n, pressure));
    for (uint64_t i = 0; i < n; i++) printf("%.17g\n", pressure[i]);
    free(pressure);
    check(mtb_contact_free(copy));
    check(mtb_contact_free(contact));
    return 0;
}
