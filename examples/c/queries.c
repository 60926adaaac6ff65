/* Queries of the near field, of windows and of the far field, one at a time and as arrays. Floating-point numbers are
 * printed in hexadecimal, which loses no bit. README.md in this folder says how to build it. */
#include <stdio.h>
#include <stdlib.h>
#include <vellus.h>

/* Ends the program with the library's message if a call failed. */
static void check(VellusStatus status)
{
    if (status != VELLUS_STATUS_OK) {
        fprintf(stderr, "error %d: %s\n", (int)status, vellus_last_error());
        exit(EXIT_FAILURE);
    }
}

static void print(const char *name, const float *numbers, size_t count)
{
    printf("%s", name);
    for (size_t i = 0; i < count; i++)
        printf(" %a", (double)numbers[i]);
    printf("\n");
}

/* A fibre from a preset whose colour is changed. */
static VellusFiber *colored_fox(void)
{
    VellusParameters parameters;
    check(vellus_parameters_preset("red-fox", &parameters));
    parameters.sigma_ca[0] = 0.2f;
    parameters.sigma_ca[1] = 0.4f;
    parameters.sigma_ca[2] = 0.8f;
    const float degrees = 4.0f; /* Parameters by name have the units of files: angles in degrees. */
    check(vellus_parameters_set(&parameters, "alpha", &degrees, 1));
    VellusFiber *fiber;
    check(vellus_fiber_from_parameters(&parameters, &fiber));
    return fiber;
}

/* All queries of one direction and one window. */
static void one_at_a_time(const VellusFiber *fiber, const char *name, VellusWindow window)
{
    const float wo[3] = {0.36f, 0.48f, 0.8f}, wi[3] = {-0.48f, 0.64f, 0.6f};
    const float u[5] = {0.1f, 0.2f, 0.3f, 0.4f, 0.5f};
    float rgb[3], pdf, lobes[VELLUS_LOBES * 3];
    printf("window %s\n", name);
    check(vellus_fiber_eval(fiber, wo, window, wi, rgb));
    print("eval", rgb, 3);
    check(vellus_fiber_pdf(fiber, wo, window, wi, &pdf));
    print("pdf", &pdf, 1);
    check(vellus_fiber_energy(fiber, wo, window, lobes));
    print("energy", lobes, VELLUS_LOBES * 3);

    /* A hit is prepared once for many queries. */
    VellusHit *hit;
    check(vellus_hit_new(fiber, wo, window, &hit));
    check(vellus_hit_eval_pdf(hit, wi, rgb, &pdf));
    print("hit", rgb, 3);
    print("hit_pdf", &pdf, 1);
    check(vellus_hit_eval_lobes(hit, wi, lobes));
    print("lobes", lobes, VELLUS_LOBES * 3);
    VellusSample sample;
    check(vellus_hit_sample(hit, u, &sample));
    print("sample", sample.wi, 3);
    print("sample_pdf", &sample.pdf, 1);
    print("weight", sample.weight, 3);
    printf("lobe %d\n", (int)sample.lobe);
    vellus_hit_free(hit);
}

/* One query in the caller's own layout. */
typedef struct Query {
    float wo[3];
    float wi[3];
    float u[5];
    float h;
    float rgb[3]; /* results */
    float pdf;
    VellusSample sample;
} Query;

enum { COUNT = 21 }; /* not a multiple of 8 */

static void arrays(const VellusFiber *fiber)
{
    Query q[COUNT];
    for (int i = 0; i < COUNT; i++) {
        /* Unit vectors from Pythagorean quadruples, with alternating signs. */
        const float sign = i % 2 ? 1.0f : -1.0f;
        q[i] = (Query){.wo = {0.36f * sign, 0.48f, 0.8f}, .wi = {0.48f, -0.6f * sign, 0.64f}};
        q[i].h = (float)i / 16.0f - 0.5f;
        for (int k = 0; k < 5; k++)
            q[i].u[k] = (float)((7 * i + 11 * k) % 32) / 32.0f;
    }
    const VellusQueries queries = {
        .count = COUNT,
        .wo = {q[0].wo, sizeof(Query)},
        .h = {&q[0].h, sizeof(Query)},
        .wi = {q[0].wi, sizeof(Query)},
        .u = {q[0].u, sizeof(Query)},
    };
    const VellusValues values = {.rgb = {q[0].rgb, sizeof(Query)}, .pdf = {&q[0].pdf, sizeof(Query)}};
    check(vellus_fiber_eval_array(fiber, &queries, &values));
    const VellusSamples samples = {
        .wi = {q[0].sample.wi, sizeof(Query)},
        .pdf = {&q[0].sample.pdf, sizeof(Query)},
        .weight = {q[0].sample.weight, sizeof(Query)},
        .lobe = {&q[0].sample.lobe, sizeof(Query)},
    };
    check(vellus_fiber_sample_array(fiber, &queries, &samples));
    for (int i = 0; i < COUNT; i++) {
        print("array", q[i].rgb, 3);
        print("array_pdf", &q[i].pdf, 1);
        print("array_sample", q[i].sample.wi, 3);
        print("array_weight", q[i].sample.weight, 3);
    }
}

int main(void)
{
    if (vellus_abi_version() != VELLUS_ABI_VERSION) {
        fprintf(stderr, "the header has ABI %d, the library has %u\n", VELLUS_ABI_VERSION, vellus_abi_version());
        return EXIT_FAILURE;
    }
    VellusFiber *fiber = colored_fox();
    one_at_a_time(fiber, "near", vellus_window_near(0.3f));
    one_at_a_time(fiber, "cell", vellus_window_cell(0.3f, 0.5f, 0.25f));
    one_at_a_time(fiber, "range", vellus_window_range(-0.25f, 0.75f));
    one_at_a_time(fiber, "far", vellus_window_far());
    arrays(fiber);
    vellus_fiber_free(fiber);
    return EXIT_SUCCESS;
}
