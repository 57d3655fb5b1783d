/* A drained triaxial test in ten lines. Build it by: cc -O2 -o simulate simulate.c */
#include <stdio.h>
#include <stdlib.h>

int main(int count, char **argument) {
    double strength = atof(argument[1]), reference_strain = atof(argument[2]), dilatancy = atof(argument[3]);
    FILE *curve = fopen("curve.csv", "w");
    fprintf(curve, "eps_a [%%],ratio,eps_v [%%]\n");
    for (int row = 0; row <= 32; row++) {
        double strain = 0.005 * row, mobilised = strain / (reference_strain + strain);
        fprintf(curve, "%.17g,%.17g,%.17g\n", 100 * strain, 1 + strength * mobilised, 100 * (0.15 * reference_strain - dilatancy * strain) * mobilised);
    }
    return fclose(curve);
}
