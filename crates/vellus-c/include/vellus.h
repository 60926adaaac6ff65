// The C interface of Vellus: reflectance of hair and fur after Yan, Jensen and Ramamoorthi 2017.
//
// The conventions of every function:
// - A call returns VELLUS_STATUS_OK, or another status. Then it writes no result, and vellus_last_error() says why.
// - A pointer is null, or points to as many values as its function says. Null gives VELLUS_STATUS_NULL, except where
//   it is allowed. Text ends with a zero byte. Memory for results must not overlap memory that the same call reads.
// - Every function may be called from several threads at once, if no two of them write to the same memory. Handles
//   never change: any number of threads may use the same handle. Only freeing one needs care: no call may use it.
// - The fibre's frame: x runs along the fibre from root to tip. All directions are unit vectors away from the fibre.
//   h is the sine of the angle from the surface normal to the direction wo, about the x axis.
// - Values are f times the cosine of the inclination to the fibre's normal plane. Multiply them by no other cosine.

#ifndef VELLUS_H
#define VELLUS_H

// cbindgen made this file from the crate vellus-c. Do not change it by hand.

#include <stddef.h>
#include <stdint.h>

// The version of the binary interface. It grows when a function, a struct or a number changes in a way that breaks
// programs. A program compares it with vellus_abi_version() when it starts.
#define VELLUS_ABI_VERSION 1

// The number of lobes.
#define VELLUS_LOBES 6

// The result of a call. After any value but VELLUS_STATUS_OK, vellus_last_error() has a message, and the call has
// written no result.
typedef enum VellusStatus {
  // The call succeeded.
  VELLUS_STATUS_OK = 0,
  // A pointer is null that must not be.
  VELLUS_STATUS_NULL = 1,
  // A number is not finite or is out of range, or a direction is not a unit vector.
  VELLUS_STATUS_RANGE = 2,
  // Text is not UTF-8, JSON is wrong, a name is unknown, or a parameter has another number of channels.
  VELLUS_STATUS_TEXT = 3,
  // A stride is too small or not a multiple of 4 bytes, an address is not a multiple of the size of what it points
  // to, or an array is larger than the address space.
  VELLUS_STATUS_STRIDE = 4,
  // The caller's memory for text or rows is too small.
  VELLUS_STATUS_SPACE = 5,
  // The library was built for instructions that this processor does not have.
  VELLUS_STATUS_INSTRUCTIONS = 6,
  // A defect of the library. Please report it with the message.
  VELLUS_STATUS_INTERNAL = 7,
} VellusStatus;

// The lobes, in the order of every array of lobes.
typedef enum VellusLobe {
  // Reflected by the cuticle.
  VELLUS_LOBE_R = 0,
  // Transmitted straight through.
  VELLUS_LOBE_TT = 1,
  // Reflected once inside.
  VELLUS_LOBE_TRT = 2,
  // Scattered by the medulla in its first pass.
  VELLUS_LOBE_TTS = 3,
  // Scattered by the medulla in its second pass.
  VELLUS_LOBE_TRTS = 4,
  // All higher orders.
  VELLUS_LOBE_REST = 5,
} VellusLobe;

// How light that the medulla scattered leaves the fibre: the values of VellusParameters.exit.
typedef enum VellusExit {
  // The cuticle does not reflect scattered light, as in the paper.
  VELLUS_EXIT_OPEN = 0,
  // The cuticle reflects scattered light from inside, as in a simulated fibre. This is the default.
  VELLUS_EXIT_REFLECTING = 1,
} VellusExit;

// A fibre, checked and prepared for queries. It never changes: any number of threads may use it at the same time.
typedef struct VellusFiber VellusFiber;

// A hit of a fibre, prepared for many queries. It never changes: any number of threads may use it at the same time. It
// takes 1.9 KB, with a window wider than the near field 11 KB.
typedef struct VellusHit VellusHit;

// The range of offsets that a hit is averaged over, from `low` to `high`, both in [−1, 1]. The near field has low =
// high = h. Make one with the functions vellus_window_*, or fill it in. Every query checks it.
typedef struct VellusWindow {
  // The smallest offset.
  float low;
  // The largest offset.
  float high;
} VellusWindow;

// A fibre at a hit, in the renderer's space ("world"). All numbers are those of the curve beside the hit. The frame's
// other two axes are across the fibre, and the same for the same tangent.
typedef struct VellusFrame {
  // A unit vector along the fibre, from root to tip: the x axis.
  float tangent[3];
  // The point of the axis.
  float center[3];
  // The radius, above 0, in the units of `center`. Files often have widths, which are twice as large.
  float radius;
} VellusFrame;

// The parameters of a fibre. Angles are in radians. Absorption and scattering are per fibre radius. Colours are RGB.
// Start with vellus_parameters_hair() or vellus_parameters_preset(), then change fields.
typedef struct VellusParameters {
  // Refractive index of cortex and medulla, in [1, 3].
  float eta;
  // Radius of the medulla over that of the fibre, in [0, 0.99]. 0 is a hair without medulla.
  float kappa;
  // Shift of the R highlight toward the root, in ±45 degrees. Scales that open toward the tip and are tilted by δ
  // shift it by 2δ at h = 0, and by about 1.33δ in the far field.
  float alpha;
  // Longitudinal roughness: a standard deviation, 0.1 to 90 degrees.
  float beta_m;
  // Azimuthal roughness: a standard deviation, 0.1 to 90 degrees.
  float beta_n;
  // Absorption in the cortex, in [0, 1000].
  float sigma_ca[3];
  // Scattering in the medulla, in [0, 1000].
  float sigma_ms;
  // Absorption in the medulla, in [0, 1000].
  float sigma_ma[3];
  // Anisotropy of the scattering in the medulla (Henyey and Greenstein), in [0, 0.95].
  float g;
  // Layers of the cuticle, in [0, 20]. 0.5 is nearly one dielectric interface.
  float layers;
  // Share of water around the fibre, in [0, 1]. Colours are those of dry fur.
  float wet;
  // The shorter axis of the section over the longer one, in [0.4, 1]. The longer axis is y of the fibre's frame.
  float aspect_ratio;
  // The share of air in the medulla, in [0, 1]: its index is 1 + (1 - medulla_air)(eta - 1).
  float medulla_air;
  // sigma_ma over sigma_ca for a colour given as reflectance or melanin, in [0, 10].
  float medulla_pigment;
  // A VellusExit.
  int32_t exit;
} VellusParameters;

// A parameter of the table: what an interface shows. The texts belong to the library.
typedef struct VellusParameter {
  // The name for vellus_parameters_set() or vellus_parameters_set_word().
  const char *name;
  // The words for it in an interface.
  const char *label;
  // One line of explanation.
  const char *description;
  // The words of a choice, with commas between them. Null for numbers.
  const char *words;
  // The smallest value, angles in degrees.
  double low;
  // The largest value.
  double high;
  // The numbers of a value: 1, 2 (melanin) or 3 (RGB).
  uint32_t channels;
  // 1 if it gives the colour: set it after all others.
  int32_t is_color;
} VellusParameter;

// A sampled direction.
typedef struct VellusSample {
  // The direction, a unit vector in the fibre's frame.
  float wi[3];
  // Its density per solid angle, over all lobes. 0 if no direction was drawn: all other numbers are 0 then, and the
  // path ends.
  float pdf;
  // f·cos θᵢ over the density, RGB.
  float weight[3];
  // The VellusLobe it was drawn from, or −1.
  int32_t lobe;
} VellusSample;

// Numbers that a call reads for each query. `data` points to the first query's numbers, which lie side by side. The
// numbers of query i are `i * stride` bytes further on. A stride of 0 gives all queries the same numbers.
typedef struct VellusInput {
  // The numbers of the first query.
  const float *data;
  // The distance of two queries in bytes: 0, or a multiple of 4 that is at least the size of one query's numbers.
  size_t stride;
} VellusInput;

// The input of many queries. Set fields that a function does not need to zero.
typedef struct VellusQueries {
  // The number of queries. 0 is allowed.
  size_t count;
  // Unit vectors to where the path came from: 3 numbers. Hits ignore it, because it is theirs.
  struct VellusInput wo;
  // Offsets of the near field: 1 number, clamped to [−1, 1]. Give either this or `window`. Hits ignore both.
  struct VellusInput h;
  // Windows: 2 numbers, the low and the high offset.
  struct VellusInput window;
  // Unit vectors to the light: 3 numbers. Only eval reads it.
  struct VellusInput wi;
  // Uniform numbers in [0, 1): 5 numbers. Only sample reads it.
  struct VellusInput u;
} VellusQueries;

// Memory that a call writes its results to. `data` points to the first query's place, and that of query i is `i *
// stride` bytes further on. A null pointer means that this result is not wanted.
typedef struct VellusOutput {
  // The place of the first query.
  float *data;
  // The distance of two queries in bytes: a multiple of 4 that is at least the size of one query's numbers.
  size_t stride;
} VellusOutput;

// The results of vellus_*_eval_array(). At least one is wanted.
typedef struct VellusValues {
  // f·cos θᵢ, the sum of all lobes: 3 numbers.
  struct VellusOutput rgb;
  // The density per solid angle: 1 number.
  struct VellusOutput pdf;
  // f·cos θᵢ of each lobe: VELLUS_LOBES × 3 numbers.
  struct VellusOutput lobes;
} VellusValues;

// As VellusOutput, for the numbers of lobes.
typedef struct VellusOutputLobes {
  // The place of the first query.
  int32_t *data;
  // The distance of two queries in bytes: a multiple of 4, at least 4.
  size_t stride;
} VellusOutputLobes;

// The results of vellus_*_sample_array(), as those of VellusSample. At least one is wanted.
typedef struct VellusSamples {
  // Directions: 3 numbers.
  struct VellusOutput wi;
  // Densities: 1 number. 0 if no direction was drawn.
  struct VellusOutput pdf;
  // Weights: 3 numbers.
  struct VellusOutput weight;
  // Lobes: 1 number. −1 if no direction was drawn.
  struct VellusOutputLobes lobe;
} VellusSamples;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The message of the last call that failed on this thread: one line of UTF-8. It is empty before the first failure. It
// belongs to the library, and stays valid until the next call fails on this thread, or the thread ends. A call that
// succeeds does not change it.
const char *vellus_last_error(void);

// The VELLUS_ABI_VERSION that the library was built with.
uint32_t vellus_abi_version(void);

// The version of Vellus, such as "0.1.0".
const char *vellus_version(void);

// The near field at the offset `h`, clamped to [−1, 1]. Queries refuse the result of NaN.
struct VellusWindow vellus_window_near(float h);

// All offsets from `h1` to `h2`, in either order, clamped to [−1, 1]. Queries refuse the result of NaN.
struct VellusWindow vellus_window_range(float h1,
                                        float h2);

// The whole width of the fibre: the far field.
struct VellusWindow vellus_window_far(void);

// What a pixel sees of the fibre. The fibre's width is divided into cells of `width` fibre radii, shifted by `u`. The
// window is the cell with the offset `h`. `width` ≥ 0: the diameter of the pixel at the hit in fibre radii; `u`: a
// uniform number in [0, 1). Queries refuse the result of other numbers.
struct VellusWindow vellus_window_cell(float h,
                                       float width,
                                       float u);

// The window of a pixel as in the paper: `width` ≥ 0 fibre radii, centred on `h`. Its average over hits is not the far
// field; vellus_window_cell() has no such bias. Queries refuse the result of other numbers.
struct VellusWindow vellus_window_pixel(float h,
                                        float width);

// A direction in the fibre's frame, as queries take it: from the unit vector `world` to `local` (3 numbers).
enum VellusStatus vellus_frame_to_local(const struct VellusFrame *frame,
                                        const float *world,
                                        float *local);

// A direction in world space, such as a sampled one: from the unit vector `local` to `world` (3 numbers).
enum VellusStatus vellus_frame_to_world(const struct VellusFrame *frame,
                                        const float *local,
                                        float *world);

// The component of the unit vector `world` across the fibre, with unit length, to `outward` (3 numbers). A ray in this
// direction starts at center + 1.001 · radius · outward.
enum VellusStatus vellus_frame_outward(const struct VellusFrame *frame,
                                       const float *world,
                                       float *outward);

// The offset h in [−1, 1] of a hit on a round curve or a mesh of it, to `*h`. `position` is the hit on the surface,
// and `wo` a unit vector to where the path came from, both in world space.
enum VellusStatus vellus_frame_offset(const struct VellusFrame *frame,
                                      const float *position,
                                      const float *wo,
                                      float *h);

// As vellus_frame_offset(), for a hit on a flat curve that faces the camera, as wide as the fibre.
enum VellusStatus vellus_frame_offset_flat(const struct VellusFrame *frame,
                                           const float *position,
                                           const float *wo,
                                           float *h);

// The width of a pixel in fibre radii, at most 4, to `*width`: for vellus_window_cell(). `footprint` ≥ 0 is the
// diameter of the pixel at the hit, in world units, perpendicular to the camera's axis.
enum VellusStatus vellus_frame_pixel_width(const struct VellusFrame *frame,
                                           float footprint,
                                           float *width);

// The parameters of a hair without medulla and without absorption.
enum VellusStatus vellus_parameters_hair(struct VellusParameters *parameters);

// The number of species.
size_t vellus_species_count(void);

// The name of a species, such as "red-fox". It belongs to the library. Null for an index that is too large.
const char *vellus_species_name(size_t index);

// The parameters of a preset: "red-fox" or "red-fox-published". The species are bobcat, cat, deer, dog, mouse, rabbit,
// raccoon, red-fox, springbok and human: see vellus_species_name().
enum VellusStatus vellus_parameters_preset(const char *name,
                                           struct VellusParameters *parameters);

// Sets a parameter by its name in files, to `count` numbers in the units of files: angles in degrees. The names are
// those of the fields, and "reflectance", "melanin", "eumelanin", "pheomelanin" and "hair_reflectance". A
// channel is "sigma_ca.r". One number sets all channels of a colour. A reflectance depends on the other parameters, so
// set it last; one that no pigment gives becomes the nearest, see vellus_parameters_nearest_reflectance(). All
// parameters must be in their ranges.
enum VellusStatus vellus_parameters_set(struct VellusParameters *parameters,
                                        const char *name,
                                        const float *values,
                                        size_t count);

// Sets a parameter that is a choice by its name in files, to a word: "exit" to "open" or "reflecting". All parameters
// must be in their ranges.
enum VellusStatus vellus_parameters_set_word(struct VellusParameters *parameters,
                                             const char *name,
                                             const char *word);

// The number of parameters: those of VellusParameters, then the other ways to give a colour.
size_t vellus_parameter_count(void);

// The parameter with this index, in an order in which all can be set: colours come last.
enum VellusStatus vellus_parameter(size_t index, struct VellusParameter *parameter);

// The reflectance that vellus_parameters_set() gives a fibre for `reflectance`, to `nearest` (3 numbers each). They
// differ if no pigment gives the reflectance: the cuticle reflects light before pigment can absorb it.
enum VellusStatus vellus_parameters_nearest_reflectance(const struct VellusParameters *parameters,
                                                        const float *reflectance,
                                                        float *nearest);

// f·cos θᵢ, the sum of all lobes, to `rgb` (3 numbers). `wo` and `wi` are unit vectors (3 numbers) in the fibre's
// frame, x along the fibre from root to tip, both away from the fibre: `wo` to where the path came from, `wi` to the
// light. The bits are those of Bcsdf::at(wo, window).eval(wi).total() in Rust.
enum VellusStatus vellus_fiber_eval(const struct VellusFiber *fiber,
                                    const float *wo,
                                    struct VellusWindow window,
                                    const float *wi,
                                    float *rgb);

// The density per solid angle with which vellus_fiber_sample() draws `wi`, to `*pdf`.
enum VellusStatus vellus_fiber_pdf(const struct VellusFiber *fiber,
                                   const float *wo,
                                   struct VellusWindow window,
                                   const float *wi,
                                   float *pdf);

// vellus_fiber_eval() and vellus_fiber_pdf() together, at little more than the cost of one.
enum VellusStatus vellus_fiber_eval_pdf(const struct VellusFiber *fiber,
                                        const float *wo,
                                        struct VellusWindow window,
                                        const float *wi,
                                        float *rgb,
                                        float *pdf);

// f·cos θᵢ of each lobe, to `lobes` (VELLUS_LOBES × 3 numbers): RGB of R, then RGB of TT, and so on.
enum VellusStatus vellus_fiber_eval_lobes(const struct VellusFiber *fiber,
                                          const float *wo,
                                          struct VellusWindow window,
                                          const float *wi,
                                          float *lobes);

// The share of the light that each lobe carries, to `lobes` (VELLUS_LOBES × 3 numbers): the integral of f·cos θᵢ.
enum VellusStatus vellus_fiber_energy(const struct VellusFiber *fiber,
                                      const float *wo,
                                      struct VellusWindow window,
                                      float *lobes);

// Draws a direction. `u`: five uniform numbers in [0, 1). The near field ignores the last.
enum VellusStatus vellus_fiber_sample(const struct VellusFiber *fiber,
                                      const float *wo,
                                      struct VellusWindow window,
                                      const float *u,
                                      struct VellusSample *sample);

// Makes a fibre from a preset: "red-fox" or "red-fox-published"; see vellus_parameters_preset(). The caller frees
// `*out`.
enum VellusStatus vellus_fiber_from_preset(const char *name,
                                           struct VellusFiber **out);

// Makes a fibre from JSON, as the command `vellus fiber` reads and writes it: a map of parameters by name, angles in
// degrees, and optionally "preset" and "exit". The text has at most 1 MiB. The caller frees `*out`.
enum VellusStatus vellus_fiber_from_json(const char *json,
                                         struct VellusFiber **out);

// Makes a fibre from parameters. The caller frees `*out`.
enum VellusStatus vellus_fiber_from_parameters(const struct VellusParameters *parameters,
                                               struct VellusFiber **out);

// Frees a fibre. Null is allowed. No other thread may use the handle any more. Hits of the fibre stay valid.
void vellus_fiber_free(struct VellusFiber *fiber);

// The parameters of a fibre.
enum VellusStatus vellus_fiber_parameters(const struct VellusFiber *fiber,
                                          struct VellusParameters *parameters);

// The colour of a dense coat of such fibres in white light, to `rgb` (3 numbers): a reflectance in [0, 1].
enum VellusStatus vellus_fiber_coat_color(const struct VellusFiber *fiber,
                                          float *rgb);

// Writes a fibre as JSON, with a zero byte at its end, to `json`, which has space for `capacity` bytes. `*length` gets
// the number of bytes without the zero byte, also with VELLUS_STATUS_SPACE. To ask for it alone, pass 0 as
// `capacity`; `json` may then be null.
enum VellusStatus vellus_fiber_json(const struct VellusFiber *fiber,
                                    char *json,
                                    size_t capacity,
                                    size_t *length);

// Prepares a hit: `wo`, a unit vector (3 numbers), and the window. The caller frees `*out`. It may live longer than
// the fibre's handle.
enum VellusStatus vellus_hit_new(const struct VellusFiber *fiber,
                                 const float *wo,
                                 struct VellusWindow window,
                                 struct VellusHit **out);

// Frees a hit. Null is allowed. No other thread may use the handle any more.
void vellus_hit_free(struct VellusHit *hit);

// As vellus_fiber_eval().
enum VellusStatus vellus_hit_eval(const struct VellusHit *hit, const float *wi, float *rgb);

// As vellus_fiber_pdf().
enum VellusStatus vellus_hit_pdf(const struct VellusHit *hit, const float *wi, float *pdf);

// As vellus_fiber_eval_pdf().
enum VellusStatus vellus_hit_eval_pdf(const struct VellusHit *hit,
                                      const float *wi,
                                      float *rgb,
                                      float *pdf);

// As vellus_fiber_eval_lobes().
enum VellusStatus vellus_hit_eval_lobes(const struct VellusHit *hit, const float *wi, float *lobes);

// As vellus_fiber_energy().
enum VellusStatus vellus_hit_energy(const struct VellusHit *hit, float *lobes);

// The probability with which sampling chooses each lobe, to `probabilities` (VELLUS_LOBES numbers).
enum VellusStatus vellus_hit_lobe_probabilities(const struct VellusHit *hit, float *probabilities);

// As vellus_fiber_sample().
enum VellusStatus vellus_hit_sample(const struct VellusHit *hit,
                                    const float *u,
                                    struct VellusSample *sample);

// f·cos θᵢ and density of many queries of one fibre, each with its own hit. All input is checked before the first
// result is written. With `h` it takes eight queries at once: the bits are those of Bcsdf::at8 and NearHit::eval_pdf8
// in Rust, and may differ in the last ones from single queries. They do not depend on a query's place in the array.
// With `window` they are those of single queries. The call uses one thread; divide an array to use more.
enum VellusStatus vellus_fiber_eval_array(const struct VellusFiber *fiber,
                                          const struct VellusQueries *queries,
                                          const struct VellusValues *values);

// Draws a direction for each of many hits of one fibre. As vellus_fiber_eval_array(): with `h` the bits are those of
// Bcsdf::at8 and NearHit::sample8 in Rust, with `window` those of single samples.
enum VellusStatus vellus_fiber_sample_array(const struct VellusFiber *fiber,
                                            const struct VellusQueries *queries,
                                            const struct VellusSamples *samples);

// f·cos θᵢ and density of many queries, each with its own fibre and its own hit. `parameters` points to those of the
// first query, and those of query i are `i * stride` bytes further on. A stride of 0 gives all queries the same. All
// input is checked before the first result is written. The bits are those of single queries. Neighbours with the same
// parameters share the work of a fibre, so sort queries by fibre.
enum VellusStatus vellus_parameters_eval_array(const struct VellusParameters *parameters,
                                               size_t stride,
                                               const struct VellusQueries *queries,
                                               const struct VellusValues *values);

// Draws a direction for each of many hits, each of its own fibre. As vellus_parameters_eval_array().
enum VellusStatus vellus_parameters_sample_array(const struct VellusParameters *parameters,
                                                 size_t stride,
                                                 const struct VellusQueries *queries,
                                                 const struct VellusSamples *samples);

// f·cos θᵢ and density of many directions `wi` of one hit. The bits are those of Hit::eval_pdf8 in Rust.
enum VellusStatus vellus_hit_eval_array(const struct VellusHit *hit,
                                        const struct VellusQueries *queries,
                                        const struct VellusValues *values);

// Draws many directions of one hit. The bits are those of Hit::sample8 in Rust.
enum VellusStatus vellus_hit_sample_array(const struct VellusHit *hit,
                                          const struct VellusQueries *queries,
                                          const struct VellusSamples *samples);

// The tables that all fibres share in shaders, to `rows`, which has space for `capacity` rows of 4 numbers: the buffer
// that `vellus_table` reads. `*count` gets the number of rows, also with VELLUS_STATUS_SPACE. To get only that number,
// pass 0 as `capacity`; `rows` may then be null. The shaders must be those of the same version, see vellus_version().
enum VellusStatus vellus_shader_tables(float *rows,
                                       size_t capacity,
                                       size_t *count);

// The record of a fibre in shaders: what the buffer that `vellus_row` reads has for it. Arguments as for
// vellus_shader_tables(). All fibres have the same number of rows, and a buffer holds them one after another.
enum VellusStatus vellus_shader_fiber(const struct VellusFiber *fiber,
                                      float *rows,
                                      size_t capacity,
                                      size_t *count);

// What a fibre needs beside its record for other absorption at each hit, `vellus_hit_colored`: rows in the buffer of
// the records, whose first one the shader gets. Arguments as for vellus_shader_tables().
enum VellusStatus vellus_shader_color(const struct VellusFiber *fiber,
                                      float *rows,
                                      size_t capacity,
                                      size_t *count);

// The far field of a fibre in shaders: a table that `vellus_far_row` reads. Arguments as for vellus_shader_tables().
// Its size depends on the fibre: 18 MB at most. Each call makes the table again, also one that asks for the number of
// rows.
enum VellusStatus vellus_shader_far_table(const struct VellusFiber *fiber,
                                          float *rows,
                                          size_t capacity,
                                          size_t *count);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* VELLUS_H */
