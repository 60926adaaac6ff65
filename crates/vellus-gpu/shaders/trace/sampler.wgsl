// Random numbers: Owen-scrambled Sobol' points, padded four dimensions at a time (Burley 2020, Practical Hash-based
// Owen Scrambling). They depend only on the pixel, the index of the sample and the seed.

struct Sampler {
    index: u32,
    seed: u32,
    count: u32,
}

fn hash(number: u32) -> u32 {
    // The hash lowbias32 by Chris Wellons.
    var x = number;
    x ^= x >> 16u;
    x *= 0x7feb352du;
    x ^= x >> 15u;
    x *= 0x846ca68bu;
    return x ^ (x >> 16u);
}

// Owen's scrambling of the bits of a number, from the highest to the lowest: the hash of Laine and Karras on the
// reversed bits.
fn scramble(number: u32, seed: u32) -> u32 {
    var x = reverseBits(number);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverseBits(x);
}

// One dimension of the Sobol' sequence.
fn sobol(index: u32, dimension: u32) -> u32 {
    if dimension == 0u {
        return reverseBits(index);
    }
    var sum = 0u;
    var rest = index;
    var bit = 0u;
    while rest != 0u {
        if (rest & 1u) == 1u {
            sum ^= SOBOL_DIRECTIONS[(dimension - 1u) * 16u + bit];
        }
        rest >>= 1u;
        bit++;
    }
    return sum;
}

fn new_sampler(pixel: vec2<u32>, index: u32, seed: u32) -> Sampler {
    let block = index >> 16u;
    return Sampler(index & 0xffffu, hash(pixel.x ^ hash(pixel.y ^ hash(seed ^ hash(block)))), 0u);
}

// The next four numbers in [0, 1).
fn next4(sampler: ptr<function, Sampler>) -> vec4<f32> {
    let count = (*sampler).count;
    (*sampler).count = count + 1u;
    let seed = hash((*sampler).seed ^ (count * 0x9e3779b9u));
    // The order of the points is scrambled too: the low 16 bits of the index, as a number from 0 to 1.
    let index = scramble((*sampler).index << 16u, seed) >> 16u;
    var u: vec4<f32>;
    for (var d = 0u; d < 4u; d++) {
        let bits = scramble(sobol(index, d), hash(seed ^ (d + 1u)));
        u[d] = f32(bits >> 8u) * (1.0 / 16777216.0);
    }
    return u;
}

// A number in [0, 1) that uses no dimension.
fn chance(sampler: ptr<function, Sampler>) -> f32 {
    let bits = hash((*sampler).seed ^ hash((*sampler).index ^ ((*sampler).count * 0x85ebca6bu)));
    return f32(bits >> 8u) * (1.0 / 16777216.0);
}
