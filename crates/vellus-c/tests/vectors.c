// Checks the golden vectors, one by one and all in one call: `program FOLDER`. Prints the largest error, in tolerances.

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vellus.h"

enum { FIBERS = 100, QUERIES = 2000, FIELDS = 17, COLUMNS = 13 };

static const float DEGREE = 0.017453292519943295f;

// A query with its fibre, as a renderer with textured fur has it.
typedef struct Query {
    VellusParameters fiber;
    float window[2], wo[3], wi[3], rgb[3], value[3], tolerance;
} Query;

static float error_of(const float *rgb, const float *value, float tolerance)
{
    float worst = 0.0f;
    for (int c = 0; c < 3; c++)
        worst = fmaxf(worst, fabsf(rgb[c] - value[c]) / tolerance);
    return worst;
}

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
    static struct VellusParameters parameters[FIBERS];
    static Query all[QUERIES];
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
        parameters[i] = p;
        if (vellus_fiber_from_parameters(&p, &fibers[i]) != VELLUS_STATUS_OK) {
            fprintf(stderr, "fibre %d: %s\n", i, vellus_last_error());
            return 1;
        }
    }
    fclose(file);
    file = table(folder, "queries.csv");
    float worst = 0.0f, q[COLUMNS];
    int count = 0;
    while (count < QUERIES && numbers(file, 0, q, COLUMNS, NULL) == COLUMNS) {
        struct VellusWindow window = q[1] == q[2] ? vellus_window_near(q[1]) : vellus_window_range(q[1], q[2]);
        struct VellusHit *hit = NULL;
        float rgb[3];
        if (vellus_hit_new(fibers[(int)q[0]], q + 3, window, &hit) != VELLUS_STATUS_OK
            || vellus_hit_eval(hit, q + 6, rgb) != VELLUS_STATUS_OK) {
            fprintf(stderr, "query %d: %s\n", count, vellus_last_error());
            return 1;
        }
        vellus_hit_free(hit);
        worst = fmaxf(worst, error_of(rgb, q + 9, q[12]));
        Query *query = &all[count++];
        query->fiber = parameters[(int)q[0]];
        memcpy(query->window, q + 1, sizeof query->window);
        memcpy(query->wo, q + 3, sizeof query->wo);
        memcpy(query->wi, q + 6, sizeof query->wi);
        memcpy(query->value, q + 9, sizeof query->value);
        query->tolerance = q[12];
    }
    fclose(file);
    for (int i = 0; i < FIBERS; i++)
        vellus_fiber_free(fibers[i]);
    const VellusQueries queries = {
        .count = count,
        .wo = {all[0].wo, sizeof(Query)},
        .window = {all[0].window, sizeof(Query)},
        .wi = {all[0].wi, sizeof(Query)},
    };
    const VellusValues values = {.rgb = {all[0].rgb, sizeof(Query)}};
    if (vellus_parameters_eval_array(&all[0].fiber, sizeof(Query), &queries, &values) != VELLUS_STATUS_OK) {
        fprintf(stderr, "%s\n", vellus_last_error());
        return 1;
    }
    for (int i = 0; i < count; i++)
        worst = fmaxf(worst, error_of(all[i].rgb, all[i].value, all[i].tolerance));
    printf("%d queries, largest error %.2f tolerances\n", count, worst);
    return count == QUERIES && worst <= 1.0f ? 0 : 1;
}
