/* Bad input for every function: each call must return its status with a message, crash nothing and leak nothing. Then
 * one fibre and one hit in several threads, as often as the argument says. The Rust test builds this program, and runs
 * it under valgrind. */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vellus.h>

static int failures = 0;

static void expect(int line, VellusStatus status, VellusStatus expected, const char *part)
{
    const char *message = vellus_last_error();
    if (status != expected || (expected != VELLUS_STATUS_OK && !strstr(message, part))) {
        printf("line %d: status %d, expected %d; message '%s', expected '%s'\n", line, (int)status, (int)expected,
               message, part);
        failures++;
    }
}

#define CHECK(condition)                                                                                               \
    if (!(condition))                                                                                                  \
    printf("line %d: %s\n", __LINE__, #condition), failures++
#define OK(call) expect(__LINE__, call, VELLUS_STATUS_OK, "")
#define NULL_POINTER(call, part) expect(__LINE__, call, VELLUS_STATUS_NULL, part)
#define RANGE(call, part) expect(__LINE__, call, VELLUS_STATUS_RANGE, part)
#define TEXT(call, part) expect(__LINE__, call, VELLUS_STATUS_TEXT, part)
#define SPACE(call, part) expect(__LINE__, call, VELLUS_STATUS_SPACE, part)
#define STRIDE(call, part) expect(__LINE__, call, VELLUS_STATUS_STRIDE, part)

static const float WO[3] = {0.36f, 0.48f, 0.8f}, WI[3] = {-0.48f, 0.64f, 0.6f};
static const float U[5] = {0.1f, 0.2f, 0.3f, 0.4f, 0.5f};

static void fibers(void)
{
    VellusFiber *fiber = NULL;
    VellusParameters p;
    NULL_POINTER(vellus_fiber_from_preset(NULL, &fiber), "name is a null pointer");
    NULL_POINTER(vellus_fiber_from_preset("cat", NULL), "out is a null pointer");
    TEXT(vellus_fiber_from_preset("unicorn", &fiber), "unknown preset 'unicorn'");
    TEXT(vellus_fiber_from_preset("\xff", &fiber), "not UTF-8");
    NULL_POINTER(vellus_fiber_from_json(NULL, &fiber), "json");
    TEXT(vellus_fiber_from_json("", &fiber), "json");
    TEXT(vellus_fiber_from_json("{\"kapa\": 0.5}", &fiber), "kapa");
    TEXT(vellus_fiber_from_json("{\"kappa\": NaN}", &fiber), "json");
    RANGE(vellus_fiber_from_json("{\"kappa\": 2}", &fiber), "kappa = 2 is out of range");
    char *deep = malloc((1 << 20) + 2);
    memset(deep, '[', (1 << 20) + 1);
    deep[(1 << 20) + 1] = 0;
    TEXT(vellus_fiber_from_json(deep, &fiber), "at most 1048576");
    deep[1 << 20] = 0;
    TEXT(vellus_fiber_from_json(deep, &fiber), "json");
    free(deep);

    NULL_POINTER(vellus_parameters_hair(NULL), "parameters");
    NULL_POINTER(vellus_parameters_preset("cat", NULL), "parameters");
    NULL_POINTER(vellus_parameters_preset(NULL, &p), "name");
    OK(vellus_parameters_hair(&p));
    NULL_POINTER(vellus_parameters_set(NULL, "eta", WO, 1), "parameters");
    NULL_POINTER(vellus_parameters_set(&p, NULL, WO, 1), "name");
    NULL_POINTER(vellus_parameters_set(&p, "eta", NULL, 1), "values");
    TEXT(vellus_parameters_set(&p, "colour", WO, 1), "unknown parameter 'colour'");
    TEXT(vellus_parameters_set(&p, "kappa", WO, 3), "takes one number, not 3");
    TEXT(vellus_parameters_set(&p, "sigma_ca", WO, SIZE_MAX), "at most 3");
    TEXT(vellus_parameters_set(&p, "sigma_ca", WO, 0), "not 0");
    const float large = 5.0f;
    RANGE(vellus_parameters_set(&p, "eta", &large, 1), "eta = 5");
    const float green[3] = {0.1f, 0.5f, 0.1f}, black[3] = {0, 0, 0};
    float rgb[3] = {7, 7, 7};
    NULL_POINTER(vellus_parameters_set_word(NULL, "exit", "open"), "parameters");
    NULL_POINTER(vellus_parameters_set_word(&p, NULL, "open"), "name");
    NULL_POINTER(vellus_parameters_set_word(&p, "exit", NULL), "word");
    TEXT(vellus_parameters_set_word(&p, "exit", "closed"), "unknown exit 'closed'");
    TEXT(vellus_parameters_set_word(&p, "eta", "open"), "eta takes one number");
    VellusParameter row;
    NULL_POINTER(vellus_parameter(0, NULL), "parameter");
    RANGE(vellus_parameter(vellus_parameter_count(), &row), "there are");
    OK(vellus_parameter(0, &row));
    CHECK(strcmp(row.name, "kappa") == 0 && !row.words && row.channels == 1 && row.low == 0 && !row.is_color);

    NULL_POINTER(vellus_parameters_nearest_reflectance(NULL, green, rgb), "parameters");
    NULL_POINTER(vellus_parameters_nearest_reflectance(&p, NULL, rgb), "reflectance");
    NULL_POINTER(vellus_parameters_nearest_reflectance(&p, green, NULL), "nearest");
    RANGE(vellus_parameters_nearest_reflectance(&p, black, rgb), "reflectance.r = 0");
    NULL_POINTER(vellus_fiber_coat_color(NULL, rgb), "fiber");
    if (rgb[0] != 7 || vellus_species_name(vellus_species_count()) != NULL || vellus_species_name(SIZE_MAX) != NULL)
        printf("a refused call wrote a colour, or a species does not exist\n"), failures++;
    NULL_POINTER(vellus_fiber_from_parameters(NULL, &fiber), "parameters");
    NULL_POINTER(vellus_fiber_from_parameters(&p, NULL), "out");
    float *fields[] = {&p.eta,      &p.kappa,       &p.alpha,    &p.beta_m,      &p.beta_n, &p.sigma_ca[1],
                       &p.sigma_ms, &p.sigma_ma[2], &p.g,        &p.layers,      &p.medulla_pigment,
                       &p.wet, &p.aspect_ratio, &p.medulla_air};
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
        const float kept = *fields[i];
        const float wrong[] = {NAN, INFINITY, -INFINITY, -1e9f, 1e9f};
        for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
            *fields[i] = wrong[k];
            RANGE(vellus_fiber_from_parameters(&p, &fiber), "is out of range");
        }
        *fields[i] = kept;
    }
    p.exit = 7;
    RANGE(vellus_fiber_from_parameters(&p, &fiber), "exit = 7");
    p.exit = VELLUS_EXIT_OPEN;
    if (fiber != NULL)
        printf("a refused call wrote a handle\n"), failures++;
    OK(vellus_fiber_from_parameters(&p, &fiber));
    NULL_POINTER(vellus_fiber_coat_color(fiber, NULL), "rgb");

    char small[8], text[1024];
    size_t length = 0;
    NULL_POINTER(vellus_fiber_json(NULL, text, sizeof text, &length), "fiber");
    NULL_POINTER(vellus_fiber_json(fiber, NULL, 10, &length), "json");
    NULL_POINTER(vellus_fiber_json(fiber, text, sizeof text, NULL), "length");
    SPACE(vellus_fiber_json(fiber, small, sizeof small, &length), "capacity is 8");
    SPACE(vellus_fiber_json(fiber, NULL, 0, &length), "capacity is 0");
    OK(vellus_fiber_json(fiber, text, length + 1, &length));
    VellusFiber *copy = NULL;
    OK(vellus_fiber_from_json(text, &copy));
    VellusParameters q;
    NULL_POINTER(vellus_fiber_parameters(NULL, &q), "fiber");
    NULL_POINTER(vellus_fiber_parameters(copy, NULL), "parameters");
    OK(vellus_fiber_parameters(copy, &q));
    if (memcmp(&p, &q, sizeof p) != 0)
        printf("JSON changed the parameters\n"), failures++;
    vellus_fiber_free(copy);
    vellus_fiber_free(fiber);
    vellus_fiber_free(NULL);
    vellus_hit_free(NULL);
}

static void shaders(const VellusFiber *fiber)
{
    size_t count = 0;
    float rows[2][4] = {{7}};
    NULL_POINTER(vellus_shader_tables(NULL, 1, &count), "rows");
    NULL_POINTER(vellus_shader_tables(rows[0], 2, NULL), "count");
    NULL_POINTER(vellus_shader_fiber(NULL, rows[0], 2, &count), "fiber");
    NULL_POINTER(vellus_shader_fiber(fiber, NULL, 2, &count), "rows");
    NULL_POINTER(vellus_shader_fiber(fiber, rows[0], 2, NULL), "count");
    NULL_POINTER(vellus_shader_color(NULL, rows[0], 2, &count), "fiber");
    NULL_POINTER(vellus_shader_color(fiber, NULL, 2, &count), "rows");
    NULL_POINTER(vellus_shader_color(fiber, rows[0], 2, NULL), "count");
    NULL_POINTER(vellus_shader_far_table(NULL, rows[0], 2, &count), "fiber");
    NULL_POINTER(vellus_shader_far_table(fiber, NULL, 2, &count), "rows");
    NULL_POINTER(vellus_shader_far_table(fiber, rows[0], 2, NULL), "count");
    STRIDE(vellus_shader_fiber(fiber, (float *)((char *)rows + 2), 1, &count), "rows is not a multiple of 4");
    CHECK(count == 0);
    SPACE(vellus_shader_far_table(fiber, NULL, 0, &count), "the capacity is 0");
    CHECK(count > 1000);
    SPACE(vellus_shader_tables(rows[0], 2, &count), "the capacity is 2");
    SPACE(vellus_shader_fiber(fiber, rows[0], 2, &count), "rows, but the capacity is 2");
    CHECK(rows[0][0] == 7);
    float *whole = malloc(count * sizeof *rows);
    OK(vellus_shader_fiber(fiber, whole, count, &count));
    free(whole);
}

static void frames(void)
{
    const VellusFrame good = {{0, 1, 0}, {1, 2, 3}, 0.5f};
    const float at[3] = {1, 2, 3.5f}, far_away[3] = {INFINITY, 0, 0}, none[3] = {0, 0, 0};
    float v[3], x;
    OK(vellus_frame_to_local(&good, WO, v));
    NULL_POINTER(vellus_frame_to_local(NULL, WO, v), "frame");
    NULL_POINTER(vellus_frame_to_local(&good, NULL, v), "world");
    NULL_POINTER(vellus_frame_to_local(&good, WO, NULL), "local");
    NULL_POINTER(vellus_frame_to_world(NULL, WO, v), "frame");
    NULL_POINTER(vellus_frame_to_world(&good, NULL, v), "local");
    NULL_POINTER(vellus_frame_to_world(&good, WO, NULL), "world");
    NULL_POINTER(vellus_frame_outward(NULL, WO, v), "frame");
    NULL_POINTER(vellus_frame_outward(&good, NULL, v), "world");
    NULL_POINTER(vellus_frame_outward(&good, WO, NULL), "outward");
    NULL_POINTER(vellus_frame_offset(NULL, at, WO, &x), "frame");
    NULL_POINTER(vellus_frame_offset(&good, NULL, WO, &x), "position");
    NULL_POINTER(vellus_frame_offset(&good, at, NULL, &x), "wo");
    NULL_POINTER(vellus_frame_offset(&good, at, WO, NULL), "h is");
    NULL_POINTER(vellus_frame_offset_flat(NULL, at, WO, &x), "frame");
    NULL_POINTER(vellus_frame_offset_flat(&good, NULL, WO, &x), "position");
    NULL_POINTER(vellus_frame_offset_flat(&good, at, NULL, &x), "wo");
    NULL_POINTER(vellus_frame_offset_flat(&good, at, WO, NULL), "h is");
    NULL_POINTER(vellus_frame_pixel_width(NULL, 1, &x), "frame");
    NULL_POINTER(vellus_frame_pixel_width(&good, 1, NULL), "width");
    RANGE(vellus_frame_to_local(&good, none, v), "world = (0, 0, 0) is not a unit vector");
    RANGE(vellus_frame_to_world(&good, none, v), "local = (");
    RANGE(vellus_frame_offset(&good, far_away, WO, &x), "position = (inf, 0, 0) is not finite");
    RANGE(vellus_frame_offset_flat(&good, at, at, &x), "wo = (");
    RANGE(vellus_frame_pixel_width(&good, -1, &x), "footprint = -1");
    RANGE(vellus_frame_pixel_width(&good, NAN, &x), "footprint = NaN");
    VellusFrame bad = good;
    bad.tangent[0] = 1;
    RANGE(vellus_frame_outward(&bad, WO, v), "frame.tangent = (1, 1, 0) is not a unit vector");
    bad = good, bad.center[2] = NAN;
    RANGE(vellus_frame_offset(&bad, at, WO, &x), "frame.center = (1, 2, NaN)");
    const float radii[] = {0, -1, NAN, INFINITY};
    for (int i = 0; i < 4; i++) {
        bad = good, bad.radius = radii[i];
        RANGE(vellus_frame_offset_flat(&bad, at, WO, &x), "frame.radius = ");
    }
}

static void queries(const VellusFiber *fiber)
{
    const float wrong[][3] = {{NAN, 0, 0}, {0, INFINITY, 0}, {0, 0, 0}, {1, 1, 1}};
    const VellusWindow near = vellus_window_near(0.3f);
    const VellusWindow windows[] = {vellus_window_near(NAN), vellus_window_cell(0, -1, 0), vellus_window_cell(0, 1, 1),
                                    vellus_window_pixel(0, NAN), {0.5f, 0.25f}, {-2, 0}, {0, INFINITY}};
    float rgb[3], pdf, lobes[VELLUS_LOBES * 3];
    char bytes[64];
    VellusSample sample;
    VellusHit *hit = NULL;
    NULL_POINTER(vellus_fiber_eval(NULL, WO, near, WI, rgb), "fiber");
    NULL_POINTER(vellus_fiber_eval(fiber, NULL, near, WI, rgb), "wo");
    NULL_POINTER(vellus_fiber_eval(fiber, WO, near, NULL, rgb), "wi");
    NULL_POINTER(vellus_fiber_eval(fiber, WO, near, WI, NULL), "rgb");
    NULL_POINTER(vellus_fiber_pdf(fiber, WO, near, WI, NULL), "pdf");
    NULL_POINTER(vellus_fiber_eval_pdf(fiber, WO, near, WI, rgb, NULL), "pdf");
    NULL_POINTER(vellus_fiber_eval_pdf(fiber, WO, near, WI, NULL, &pdf), "rgb");
    NULL_POINTER(vellus_fiber_eval_lobes(fiber, WO, near, WI, NULL), "lobes");
    NULL_POINTER(vellus_fiber_energy(fiber, WO, near, NULL), "lobes");
    NULL_POINTER(vellus_fiber_sample(fiber, WO, near, NULL, &sample), "u is");
    NULL_POINTER(vellus_fiber_sample(fiber, WO, near, U, NULL), "sample");
    NULL_POINTER(vellus_hit_new(NULL, WO, near, &hit), "fiber");
    NULL_POINTER(vellus_hit_new(fiber, WO, near, NULL), "out");
    STRIDE(vellus_fiber_eval(fiber, (float *)(bytes + 1), near, WI, rgb), "address of wo is not a multiple of 4");
    for (int i = 0; i < 4; i++) {
        RANGE(vellus_fiber_eval(fiber, wrong[i], near, WI, rgb), "wo = (");
        RANGE(vellus_fiber_eval(fiber, WO, near, wrong[i], rgb), "is not a unit vector");
        RANGE(vellus_fiber_energy(fiber, wrong[i], near, lobes), "wo");
        RANGE(vellus_hit_new(fiber, wrong[i], near, &hit), "wo");
    }
    for (size_t i = 0; i < sizeof windows / sizeof *windows; i++)
        RANGE(vellus_hit_new(fiber, WO, windows[i], &hit), i < 4 ? "the window was made from NaN" : "the window from");
    const float u[5] = {0.1f, 0.2f, 1.0f, 0.4f, 0.5f}, nan_u[5] = {0.1f, 0.2f, 0.3f, 0.4f, NAN};
    RANGE(vellus_fiber_sample(fiber, WO, near, u, &sample), "u[2] = 1");
    RANGE(vellus_fiber_sample(fiber, WO, near, nan_u, &sample), "u[4] = NaN");

    OK(vellus_hit_new(fiber, WO, vellus_window_far(), &hit));
    NULL_POINTER(vellus_hit_eval(NULL, WI, rgb), "hit");
    NULL_POINTER(vellus_hit_eval(hit, NULL, rgb), "wi");
    NULL_POINTER(vellus_hit_eval(hit, WI, NULL), "rgb");
    NULL_POINTER(vellus_hit_pdf(hit, WI, NULL), "pdf");
    NULL_POINTER(vellus_hit_eval_pdf(hit, WI, NULL, &pdf), "rgb");
    NULL_POINTER(vellus_hit_eval_lobes(hit, WI, NULL), "lobes");
    NULL_POINTER(vellus_hit_energy(hit, NULL), "lobes");
    NULL_POINTER(vellus_hit_lobe_probabilities(hit, NULL), "probabilities");
    NULL_POINTER(vellus_hit_sample(hit, U, NULL), "sample");
    RANGE(vellus_hit_eval(hit, wrong[0], rgb), "wi = (NaN");
    RANGE(vellus_hit_sample(hit, u, &sample), "u[2]");
    vellus_hit_free(hit);
}

/* Those that the other functions leave out: a null pointer for each pointer of each function. */
static void null_pointers(const VellusFiber *fiber)
{
    const VellusWindow near = vellus_window_range(0.3f, 0.3f);
    float x[VELLUS_LOBES * 3];
    VellusSample s;
    VellusHit *hit = NULL;
    NULL_POINTER(vellus_fiber_from_json("{}", NULL), "out");
    NULL_POINTER(vellus_fiber_pdf(NULL, WO, near, WI, x), "fiber");
    NULL_POINTER(vellus_fiber_pdf(fiber, NULL, near, WI, x), "wo");
    NULL_POINTER(vellus_fiber_pdf(fiber, WO, near, NULL, x), "wi");
    NULL_POINTER(vellus_fiber_eval_pdf(NULL, WO, near, WI, x, x + 3), "fiber");
    NULL_POINTER(vellus_fiber_eval_pdf(fiber, NULL, near, WI, x, x + 3), "wo");
    NULL_POINTER(vellus_fiber_eval_pdf(fiber, WO, near, NULL, x, x + 3), "wi");
    NULL_POINTER(vellus_fiber_eval_lobes(NULL, WO, near, WI, x), "fiber");
    NULL_POINTER(vellus_fiber_eval_lobes(fiber, NULL, near, WI, x), "wo");
    NULL_POINTER(vellus_fiber_eval_lobes(fiber, WO, near, NULL, x), "wi");
    NULL_POINTER(vellus_fiber_energy(NULL, WO, near, x), "fiber");
    NULL_POINTER(vellus_fiber_energy(fiber, NULL, near, x), "wo");
    NULL_POINTER(vellus_fiber_sample(NULL, WO, near, U, &s), "fiber");
    NULL_POINTER(vellus_fiber_sample(fiber, NULL, near, U, &s), "wo");
    NULL_POINTER(vellus_hit_new(fiber, NULL, near, &hit), "wo");
    OK(vellus_hit_new(fiber, WO, near, &hit));
    NULL_POINTER(vellus_hit_pdf(NULL, WI, x), "hit");
    NULL_POINTER(vellus_hit_pdf(hit, NULL, x), "wi");
    NULL_POINTER(vellus_hit_eval_pdf(NULL, WI, x, x + 3), "hit");
    NULL_POINTER(vellus_hit_eval_pdf(hit, NULL, x, x + 3), "wi");
    NULL_POINTER(vellus_hit_eval_pdf(hit, WI, x, NULL), "pdf");
    NULL_POINTER(vellus_hit_eval_lobes(NULL, WI, x), "hit");
    NULL_POINTER(vellus_hit_eval_lobes(hit, NULL, x), "wi");
    NULL_POINTER(vellus_hit_energy(NULL, x), "hit");
    NULL_POINTER(vellus_hit_lobe_probabilities(NULL, x), "hit");
    NULL_POINTER(vellus_hit_sample(NULL, U, &s), "hit");
    NULL_POINTER(vellus_hit_sample(hit, NULL, &s), "u is");

    const VellusQueries good = {.count = 1, .wo = {WO, 12}, .h = {U, 0}, .wi = {WI, 12}, .u = {U, 20}};
    const VellusValues values = {.rgb = {x, 12}};
    const VellusSamples samples = {.pdf = {x, 4}};
    NULL_POINTER(vellus_fiber_sample_array(NULL, &good, &samples), "fiber");
    NULL_POINTER(vellus_fiber_sample_array(fiber, NULL, &samples), "queries");
    NULL_POINTER(vellus_fiber_sample_array(fiber, &good, NULL), "samples");
    NULL_POINTER(vellus_hit_eval_array(NULL, &good, &values), "hit");
    NULL_POINTER(vellus_hit_eval_array(hit, NULL, &values), "queries");
    NULL_POINTER(vellus_hit_eval_array(hit, &good, NULL), "values");
    NULL_POINTER(vellus_hit_sample_array(NULL, &good, &samples), "hit");
    NULL_POINTER(vellus_hit_sample_array(hit, NULL, &samples), "queries");
    NULL_POINTER(vellus_hit_sample_array(hit, &good, NULL), "samples");
    VellusParameters p;
    OK(vellus_fiber_parameters(fiber, &p));
    NULL_POINTER(vellus_parameters_eval_array(NULL, 0, &good, &values), "parameters");
    NULL_POINTER(vellus_parameters_eval_array(&p, 0, NULL, &values), "queries");
    NULL_POINTER(vellus_parameters_eval_array(&p, 0, &good, NULL), "values");
    NULL_POINTER(vellus_parameters_sample_array(NULL, 0, &good, &samples), "parameters");
    NULL_POINTER(vellus_parameters_sample_array(&p, 0, NULL, &samples), "queries");
    NULL_POINTER(vellus_parameters_sample_array(&p, 0, &good, NULL), "samples");
    STRIDE(vellus_parameters_eval_array(&p, sizeof p - 4, &good, &values), "parameters");
    OK(vellus_parameters_eval_array(&p, sizeof p, &good, &values));
    OK(vellus_parameters_sample_array(&p, 0, &good, &samples));
    p.kappa = 2;
    RANGE(vellus_parameters_eval_array(&p, 0, &good, &values), "query 0: kappa = 2");
    OK(vellus_hit_eval_array(hit, &good, &values));
    OK(vellus_hit_sample_array(hit, &good, &samples));
    const float nan_wi[3] = {NAN, 0, 0}, nan_u[5] = {NAN, 0, 0, 0, 0};
    VellusQueries bad = good;
    bad.wi.data = nan_wi;
    bad.u.data = nan_u;
    RANGE(vellus_hit_eval_array(hit, &bad, &values), "query 0: wi");
    RANGE(vellus_hit_sample_array(hit, &bad, &samples), "query 0: u[0]");
    bad = good, bad.wi.stride = bad.u.stride = 2;
    STRIDE(vellus_hit_eval_array(hit, &bad, &values), "queries.wi");
    STRIDE(vellus_hit_sample_array(hit, &bad, &samples), "queries.u");
    vellus_hit_free(hit);
    if (vellus_abi_version() != VELLUS_ABI_VERSION || strlen(vellus_version()) < 5)
        printf("wrong version\n"), failures++;
}

static void arrays(const VellusFiber *fiber)
{
    float *wo = malloc(30 * sizeof(float)), *rgb = malloc(30 * sizeof(float));
    int32_t lobe;
    float h = 0.25f, window[2] = {-0.5f, 0.5f};
    for (int i = 0; i < 10; i++)
        memcpy(wo + 3 * i, WO, sizeof WO);
    const VellusQueries good = {10, {wo, 12}, {&h, 0}, {NULL, 0}, {WI, 0}, {U, 0}};
    const VellusValues values = {.rgb = {rgb, 12}};
    OK(vellus_fiber_eval_array(fiber, &good, &values));
    OK(vellus_fiber_sample_array(fiber, &good, &(VellusSamples){.wi = {rgb, 12}}));
    OK(vellus_fiber_eval_array(fiber, &(VellusQueries){0}, &(VellusValues){0}));
    NULL_POINTER(vellus_fiber_eval_array(NULL, &good, &values), "fiber");
    NULL_POINTER(vellus_fiber_eval_array(fiber, NULL, &values), "queries");
    NULL_POINTER(vellus_fiber_eval_array(fiber, &good, NULL), "values");
    NULL_POINTER(vellus_fiber_eval_array(fiber, &good, &(VellusValues){0}), "all pointers");
    NULL_POINTER(vellus_fiber_sample_array(fiber, &good, &(VellusSamples){0}), "all pointers");
    VellusQueries bad = good;
    bad.h.data = NULL;
    NULL_POINTER(vellus_fiber_eval_array(fiber, &bad, &values), "both queries.h and queries.window");
    bad.window = (VellusInput){window, 0};
    OK(vellus_fiber_eval_array(fiber, &bad, &values));
    window[0] = 0.75f;
    RANGE(vellus_fiber_eval_array(fiber, &bad, &values), "query 0: the window from 0.75 to 0.5");
    bad.h = good.h;
    RANGE(vellus_fiber_eval_array(fiber, &bad, &values), "not both");
    bad = good, bad.wo.data = NULL;
    NULL_POINTER(vellus_fiber_eval_array(fiber, &bad, &values), "queries.wo");
    bad = good, bad.wi.data = NULL;
    NULL_POINTER(vellus_fiber_eval_array(fiber, &bad, &values), "queries.wi");
    bad = good, bad.u.data = NULL;
    NULL_POINTER(vellus_fiber_sample_array(fiber, &bad, &(VellusSamples){.wi = {rgb, 12}}), "queries.u");
    const size_t strides[] = {1, 4, 8, 11, 13, SIZE_MAX, SIZE_MAX - 3, SIZE_MAX / 4};
    for (size_t i = 0; i < sizeof strides / sizeof *strides; i++) {
        bad = good, bad.wo.stride = strides[i];
        STRIDE(vellus_fiber_eval_array(fiber, &bad, &values), "queries.wo");
        STRIDE(vellus_fiber_eval_array(fiber, &good, &(VellusValues){.rgb = {rgb, strides[i]}}), "values.rgb");
    }
    STRIDE(vellus_fiber_eval_array(fiber, &good, &(VellusValues){.rgb = {rgb, 0}}), "values.rgb: a stride of 0");
    STRIDE(vellus_fiber_sample_array(fiber, &good, &(VellusSamples){.lobe = {&lobe, 2}}), "samples.lobe");
    bad = good, bad.wo.data = (float *)((char *)wo + 2);
    STRIDE(vellus_fiber_eval_array(fiber, &bad, &values), "queries.wo: the address");
    bad = good, bad.count = SIZE_MAX;
    STRIDE(vellus_fiber_eval_array(fiber, &bad, &values), "address space");
    h = NAN;
    RANGE(vellus_fiber_eval_array(fiber, &good, &values), "query 0: h = NaN");
    h = 0.25f;
    wo[3 * 7 + 1] = NAN;
    memset(rgb, 0, 30 * sizeof(float));
    RANGE(vellus_fiber_eval_array(fiber, &good, &values), "query 7: wo");
    for (int i = 0; i < 30; i++) {
        if (rgb[i] != 0)
            printf("a refused call wrote results\n"), failures++, i = 30;
    }
    free(wo);
    free(rgb);
}

typedef struct Shared {
    const VellusFiber *fiber;
    const VellusHit *hit;
    float expected[3];
    int same;
    int rounds;
} Shared;

static void *worker(void *pointer)
{
    Shared *shared = pointer;
    for (int i = 0; i < shared->rounds; i++) {
        float a[3], b[3];
        shared->same &= vellus_fiber_eval(shared->fiber, WO, vellus_window_far(), WI, a) == VELLUS_STATUS_OK;
        shared->same &= vellus_hit_eval(shared->hit, WI, b) == VELLUS_STATUS_OK;
        shared->same &= !memcmp(a, shared->expected, sizeof a) && !memcmp(b, shared->expected, sizeof b);
        /* Each thread has its own message. */
        shared->same &= vellus_hit_eval(NULL, WI, b) == VELLUS_STATUS_NULL;
        shared->same &= !strcmp(vellus_last_error(), "hit is a null pointer");
    }
    return NULL;
}

static void threads(const VellusFiber *fiber, int rounds)
{
    enum { THREADS = 8 };
    pthread_t ids[THREADS];
    Shared shared[THREADS];
    VellusHit *hit = NULL;
    float expected[3];
    OK(vellus_hit_new(fiber, WO, vellus_window_far(), &hit));
    OK(vellus_hit_eval(hit, WI, expected));
    for (int i = 0; i < THREADS; i++) {
        shared[i] = (Shared){fiber, hit, {expected[0], expected[1], expected[2]}, 1, rounds};
        pthread_create(&ids[i], NULL, worker, &shared[i]);
    }
    for (int i = 0; i < THREADS; i++) {
        pthread_join(ids[i], NULL);
        if (!shared[i].same)
            printf("thread %d has other results\n", i), failures++;
    }
    vellus_hit_free(hit);
}

int main(int argc, char **argv)
{
    VellusFiber *fiber = NULL;
    fibers();
    frames();
    OK(vellus_fiber_from_preset("red-fox", &fiber));
    /* For few rounds a rough fibre, whose far field is a small table. */
    VellusFiber *rough = NULL;
    OK(vellus_fiber_from_json("{\"kappa\": 0, \"beta_n\": 60, \"beta_m\": 60}", &rough));
    shaders(argc > 1 ? rough : fiber);
    vellus_fiber_free(rough);
    queries(fiber);
    null_pointers(fiber);
    arrays(fiber);
    threads(fiber, argc > 1 ? atoi(argv[1]) : 200);
    /* A hit lives longer than its fibre. */
    VellusHit *hit = NULL;
    float before[3], after[3];
    OK(vellus_hit_new(fiber, WO, vellus_window_near(0.3f), &hit));
    OK(vellus_hit_eval(hit, WI, before));
    vellus_fiber_free(fiber);
    OK(vellus_hit_eval(hit, WI, after));
    if (memcmp(before, after, sizeof before) != 0)
        printf("the hit changed when its fibre was freed\n"), failures++;
    vellus_hit_free(hit);
    printf("%d failures\n", failures);
    return failures != 0;
}
