// Checks the golden vectors: `program FOLDER`. Prints the largest error, in tolerances.

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vellus.h"

enum { FIBERS = 100, FIELDS = 17, COLUMNS = 13 };

static const float DEGREE = 0.017453292519943295f;

// Reads one line of numbers after `skip` fields. Returns how many there are.
static int numbers(FILE *file, int skip, float *values, int most, char *word)
{
    char line[1024];
    if (!fgets(line, sizeof line, file))
        return 0;
    int count = 0, field = 0;
    for (char *at = strtok(line, ",\n"); at; at = strtok(NULL, ",\n"), field++) {
        if (field == 1 && word)
            strncpy(word, at, 31);
        if (field >= skip && count < most)
            values[count++] = strtof(at, NULL);
    }
    return count;
}

static FILE *table(const char *folder, const char *name)
{
    char path[4096], header[1024];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "r");
    if (!file || !fgets(header, sizeof header, file)) {
        fprintf(stderr, "cannot read %s\n", path);
        exit(1);
    }
    return file;
}

int main(int argc, char **argv)
{
    const char *folder = argc > 1 ? argv[1] : "vectors";
    static struct VellusFiber *fibers[FIBERS];
    FILE *file = table(folder, "fibers.csv");
    float x[FIELDS];
    for (int i = 0; i < FIBERS; i++) {
        char exit_name[32] = "";
        if (numbers(file, 2, x, FIELDS, exit_name) != 15)
            return 1;
        struct VellusParameters p;
        vellus_parameters_hair(&p);
        p.kappa = x[0];
        p.eta = x[1];
        p.alpha = x[2] * DEGREE;
        p.beta_m = x[3] * DEGREE;
        p.beta_n = x[4] * DEGREE;
        memcpy(p.sigma_ca, x + 5, sizeof p.sigma_ca);
        p.sigma_ms = x[8];
        memcpy(p.sigma_ma, x + 9, sizeof p.sigma_ma);
        p.g = x[12];
        p.layers = x[13];
        p.wet = x[14];
        p.exit = strcmp(exit_name, "open") ? VELLUS_EXIT_REFLECTING : VELLUS_EXIT_OPEN;
        if (vellus_fiber_from_parameters(&p, &fibers[i]) != VELLUS_STATUS_OK) {
            fprintf(stderr, "fibre %d: %s\n", i, vellus_last_error());
            return 1;
        }
    }
    fclose(file);
    file = table(folder, "queries.csv");
    float worst = 0.0f, q[COLUMNS];
    int count = 0;
    while (numbers(file, 0, q, COLUMNS, NULL) == COLUMNS) {
        struct VellusWindow window = q[1] == q[2] ? vellus_window_near(q[1]) : vellus_window_range(q[1], q[2]);
        struct VellusHit *hit = NULL;
        float rgb[3];
        if (vellus_hit_new(fibers[(int)q[0]], q + 3, window, &hit) != VELLUS_STATUS_OK
            || vellus_hit_eval(hit, q + 6, rgb) != VELLUS_STATUS_OK) {
            fprintf(stderr, "query %d: %s\n", count, vellus_last_error());
            return 1;
        }
        vellus_hit_free(hit);
        for (int c = 0; c < 3; c++)
            worst = fmaxf(worst, fabsf(rgb[c] - q[9 + c]) / q[12]);
        count++;
    }
    fclose(file);
    for (int i = 0; i < FIBERS; i++)
        vellus_fiber_free(fibers[i]);
    printf("%d queries, largest error %.2f tolerances\n", count, worst);
    return count == 2000 && worst <= 1.0f ? 0 : 1;
}
