#version 450
// Paths of light in a ball of fur. Each thread adds a sample to its pixel.
#extension GL_GOOGLE_include_directive : require

layout(local_size_x = 8, local_size_y = 8) in;

// Points from `a` to `b`, radius in `a.w`. The ball's fur has one fibre: that of record 0.
struct Segment { vec4 a, b; };
layout(std430, binding = 0) readonly buffer Tables { vec4 tables[]; };
layout(std430, binding = 1) readonly buffer Fibers { vec4 fibers[]; };
layout(std430, binding = 2) readonly buffer Segments { Segment segments[]; };
// The segments of cell i of the grid are `items[starts[i]]` to `items[starts[i + 1] - 1]`.
layout(std430, binding = 3) readonly buffer Starts { uint starts[]; };
layout(std430, binding = 4) readonly buffer Items { uint items[]; };
layout(std430, binding = 5) buffer Image { vec4 image[]; };
layout(push_constant) uniform Frame { uint size, index, cells; float skin, extent; };

// What the library needs, and the library.
vec4 vellus_table(uint row) { return tables[row]; }
vec4 vellus_row(uint row) { return fibers[row]; }
#include "vellus.glsl"

const uint NONE = 0xffffffffu, SKIN = 0xfffffffeu, BOUNCES = 12u;
const vec3 LAMP = vec3(0.55, 0.65, 0.52), LAMP_LIGHT = vec3(2.6, 2.45, 2.25);

vec3 sky(vec3 d) { return mix(vec3(0.35, 0.33, 0.31), vec3(0.75, 0.85, 1.0), 0.5 + 0.5 * d.y); }

uint state;
float uniform_number() {
    state = state * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return float(((word >> 22) ^ word) >> 8) / 16777216.0;
}

// Where the ray enters a segment, or infinity.
float entered(Segment s, vec3 o, vec3 d) {
    vec3 axis = s.b.xyz - s.a.xyz, from = o - s.a.xyz;
    float length_ = length(axis);
    axis /= length_;
    vec3 across = d - dot(d, axis) * axis, off = from - dot(from, axis) * axis;
    float a = dot(across, across), b = dot(off, across), c = dot(off, off) - s.a.w * s.a.w;
    float root = b * b - a * c;
    if (root <= 0.0 || a == 0.0) return 1e30;
    float t = (-b - sqrt(root)) / a, along = dot(from, axis) + t * dot(d, axis);
    return t > 0.0 && along >= 0.0 && along <= length_ ? t : 1e30;
}

// The first segment that a ray enters, or the skin, or nothing; and the distance. The ray walks through the grid.
uint trace(vec3 o, vec3 d, out float nearest) {
    uint found = NONE;
    nearest = 1e30;
    float b = dot(o, d), root = b * b - dot(o, o) + skin * skin;
    if (root > 0.0 && -b - sqrt(root) > 0.0) {
        nearest = -b - sqrt(root);
        found = SKIN;
    }
    vec3 inverse_d = 1.0 / mix(d, vec3(1e-12), equal(d, vec3(0.0)));
    vec3 low = (-extent - o) * inverse_d, high = (extent - o) * inverse_d;
    vec3 first = min(low, high), last = max(low, high);
    float t = max(max(max(first.x, first.y), first.z), 0.0), end = min(min(last.x, last.y), last.z);
    if (t >= end) return found;
    float width = 2.0 * extent / float(cells);
    ivec3 cell = clamp(ivec3((o + t * d + extent) / width), ivec3(0), ivec3(cells - 1u));
    ivec3 step_ = ivec3(sign(inverse_d));
    vec3 next = ((vec3(cell) + vec3(greaterThan(step_, ivec3(0)))) * width - extent - o) * inverse_d;
    vec3 jump = abs(width * inverse_d);
    while (t < min(end, nearest)) {
        uint at = (uint(cell.z) * cells + uint(cell.y)) * cells + uint(cell.x);
        for (uint k = starts[at]; k < starts[at + 1u]; k++) {
            float distance_ = entered(segments[items[k]], o, d);
            if (distance_ < nearest) {
                nearest = distance_;
                found = items[k];
            }
        }
        int axis = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
        t = next[axis];
        next[axis] += jump[axis];
        cell[axis] += step_[axis];
        if (cell[axis] < 0 || cell[axis] >= int(cells)) break;
    }
    return found;
}

// The light that arrives along a ray.
vec3 radiance(vec3 o, vec3 d) {
    vec3 sum = vec3(0.0), share = vec3(1.0);
    for (uint bounce = 0u; bounce < BOUNCES; bounce++) {
        float t;
        uint found = trace(o, d, t);
        if (found == NONE) return sum + share * (bounce == 0u ? vec3(0.32, 0.36, 0.4) : sky(d));
        if (found == SKIN) return sum;
        // The frame of the fibre: x along it from root to tip, y toward the eye, z across. Then wo has no z.
        Segment s = segments[found];
        vec3 x = normalize(s.b.xyz - s.a.xyz), at = o + t * d, center = s.a.xyz + dot(at - s.a.xyz, x) * x;
        vec3 y = normalize(-d - dot(-d, x) * x), z = cross(x, y);
        mat3 frame = mat3(x, y, z);
        // h: the sine of the angle from the surface normal to wo, about x.
        VellusHit hit;
        vellus_hit(hit, 0u, -d * frame, clamp(-dot(at - center, z) / s.a.w, -1.0, 1.0));
        // The lamp. A path leaves from the side of the fibre that faces its direction, one radius from the axis.
        vec3 lamp = normalize(LAMP), out_ = center + normalize(lamp - dot(lamp, x) * x) * s.a.w * 1.001;
        if (trace(out_, lamp, t) == NONE) sum += share * LAMP_LIGHT * vellus_eval(hit, lamp * frame).rgb;
        vec4 u = vec4(uniform_number(), uniform_number(), uniform_number(), uniform_number());
        VellusSample drawn = vellus_sample(hit, u);
        if (drawn.pdf <= 0.0) return sum;
        share *= drawn.weight;
        d = frame * drawn.wi;
        o = center + normalize(d - dot(d, x) * x) * s.a.w * 1.001;
    }
    return sum;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, uvec2(size)))) return;
    uint at = pixel.y * size + pixel.x;
    state = (at * 9781u + index) * 6271u + 1u;
    uniform_number();
    vec2 place = (vec2(pixel) + vec2(uniform_number(), uniform_number())) / float(size) * 2.0 - 1.0;
    image[at] += vec4(radiance(vec3(0.0, 0.0, 5.0), normalize(vec3(0.29 * place.x, -0.29 * place.y, -1.0))), 1.0);
}
