// The BSDF `vellus` of Mitsuba 3, variant scalar_rgb: the near field of Vellus through its C interface. build.py builds
// it against the headers of an installed wheel. The page "Mitsuba" of the book describes its parameters.

#include <mitsuba/core/properties.h>
#include <mitsuba/core/string.h>
#include <mitsuba/render/bsdf.h>

#include <vellus.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <mutex>

NAMESPACE_BEGIN(mitsuba)

// Mitsuba passes single arguments of 23 or 24 bits. The lobe and the second longitudinal number share one.
static float fraction(uint64_t bits, int count) {
    return static_cast<float>(bits & ((1ull << count) - 1)) * std::ldexp(1.f, -count);
}

// The even bits of a 24-bit number, as 12 bits.
static uint64_t even_bits(uint64_t x) {
    uint64_t result = 0;
    for (int i = 0; i < 12; ++i)
        result |= ((x >> (2 * i)) & 1) << i;
    return result;
}

// Mixes 64 bits (SplitMix64, Steele, Lea and Flood 2014).
static uint64_t mix(uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

// Four uniform numbers of three. The first number is divided: its even and odd bits become the high 12 bits of two
// numbers, so that both stay stratified. Twelve bits alone would miss rare lobes, so a mix of all three numbers fills
// the low 12 bits. The near field ignores the fifth.
static void split(float a, const float b[2], float u[5]) {
    uint32_t words[3];
    std::memcpy(&words[0], &a, 4);
    std::memcpy(&words[1], b, 8);
    const uint64_t low = mix(words[0] ^ mix(words[1] ^ mix(words[2])));
    const float clamped = std::fmin(std::fmax(a, 0.f), 1.f - 0x1p-24f);
    const uint64_t bits = static_cast<uint64_t>(clamped * 0x1p24f);
    u[0] = fraction(even_bits(bits >> 1) << 12 | (low & 0xfff), 24);
    u[2] = fraction(even_bits(bits) << 12 | (low >> 12 & 0xfff), 24);
    u[1] = std::fmin(std::fmax(b[0], 0.f), 1.f - 0x1p-24f);
    u[3] = std::fmin(std::fmax(b[1], 0.f), 1.f - 0x1p-24f);
    u[4] = 0.f;
}

struct FreeFiber {
    void operator()(VellusFiber *fiber) const { vellus_fiber_free(fiber); }
};

template <typename Float, typename Spectrum>
class VellusBSDF final : public BSDF<Float, Spectrum> {
public:
    MI_IMPORT_BASE(BSDF, m_flags, m_components)
    MI_IMPORT_TYPES()

    VellusBSDF(const Properties &props) : Base(props) {
        VellusFiber *fiber = nullptr;
        if (props.has_property("json")) {
            // A whole fibre. A second parameter stays unqueried, which Mitsuba reports.
            check(vellus_fiber_from_json(std::string(props.template get<std::string_view>("json")).c_str(), &fiber));
        } else {
            VellusParameters parameters;
            const std::string preset(props.template get<std::string_view>("preset", "red-fox"));
            check(preset == "hair" ? vellus_parameters_hair(&parameters)
                                   : vellus_parameters_preset(preset.c_str(), &parameters));
            // In the order of the table: a reflectance depends on the other parameters, so it comes last.
            for (size_t i = 0; i < vellus_parameter_count(); ++i) {
                VellusParameter row;
                check(vellus_parameter(i, &row));
                set(props, row, parameters);
            }
            for (const char *pigment : { "eumelanin", "pheomelanin" })
                set_numbers(props, pigment, parameters);
            if (parameters.aspect_ratio != 1)
                Throw("vellus: aspect_ratio = %f must be 1: curves of Mitsuba are round", parameters.aspect_ratio);
            check(vellus_fiber_from_parameters(&parameters, &fiber));
        }
        m_fiber.reset(fiber);
        m_components.push_back(BSDFFlags::Glossy | BSDFFlags::FrontSide | BSDFFlags::BackSide |
                               BSDFFlags::Anisotropic | BSDFFlags::NonSymmetric);
        m_flags = m_components[0];
    }

    std::pair<BSDFSample3f, Spectrum> sample(const BSDFContext &ctx, const SurfaceInteraction3f &si, Float sample1,
                                             const Point2f &sample2, Mask /*active*/) const override {
        BSDFSample3f bs = dr::zeros<BSDFSample3f>();
        if (!enabled(ctx))
            return { bs, 0.f };
        float wo[3], u[5];
        const float rest[2] = { sample2.x(), sample2.y() };
        split(sample1, rest, u);
        VellusSample sample;
        to_fiber(si.wi, wo);
        if (vellus_fiber_sample(m_fiber.get(), wo, vellus_window_near(offset(si.wi)), u, &sample) != VELLUS_STATUS_OK)
            return { bs, report() };
        bs.wo                = Vector3f(sample.wi[2], sample.wi[0], sample.wi[1]);
        bs.pdf               = sample.pdf;
        bs.eta               = 1.f;
        bs.sampled_type      = +BSDFFlags::Glossy;
        bs.sampled_component = 0;
        return { bs, Spectrum(sample.weight[0], sample.weight[1], sample.weight[2]) };
    }

    Spectrum eval(const BSDFContext &ctx, const SurfaceInteraction3f &si, const Vector3f &wo,
                  Mask active) const override {
        return eval_pdf(ctx, si, wo, active).first;
    }

    Float pdf(const BSDFContext &ctx, const SurfaceInteraction3f &si, const Vector3f &wo, Mask active) const override {
        return eval_pdf(ctx, si, wo, active).second;
    }

    std::pair<Spectrum, Float> eval_pdf(const BSDFContext &ctx, const SurfaceInteraction3f &si, const Vector3f &wi,
                                        Mask /*active*/) const override {
        if (!enabled(ctx))
            return { 0.f, 0.f };
        float from[3], to[3], rgb[3], pdf;
        to_fiber(si.wi, from);
        to_fiber(wi, to);
        const VellusWindow window = vellus_window_near(offset(si.wi));
        if (vellus_fiber_eval_pdf(m_fiber.get(), from, window, to, rgb, &pdf) != VELLUS_STATUS_OK)
            return { report(), 0.f };
        return { Spectrum(rgb[0], rgb[1], rgb[2]), pdf };
    }

    std::string to_string() const override {
        std::string json(1024, '\0');
        size_t length = 0;
        if (vellus_fiber_json(m_fiber.get(), json.data(), json.size(), &length) != VELLUS_STATUS_OK)
            length = 0;
        return "Vellus" + json.substr(0, length);
    }

    MI_DECLARE_CLASS(VellusBSDF)

private:
    static void check(VellusStatus status) {
        if (status != VELLUS_STATUS_OK)
            Throw("vellus: %s", vellus_last_error());
    }

    // A query can only fail on directions that are no unit vectors, which other parts of a scene can cause. The first
    // is reported, and the light is 0.
    static Float report() {
        static std::once_flag once;
        std::call_once(once, [] { Log(Warn, "vellus: %s", vellus_last_error()); });
        return 0.f;
    }

    static bool enabled(const BSDFContext &ctx) { return ctx.is_enabled(BSDFFlags::Glossy); }

    // Mitsuba's frame (s, t, n) has t along the fibre. Ours is (t, n, s).
    static void to_fiber(const Vector3f &w, float out[3]) {
        out[0] = w.y();
        out[1] = w.z();
        out[2] = w.x();
    }

    static Float offset(const Vector3f &w) {
        const Float across = std::sqrt(w.x() * w.x() + w.z() * w.z());
        return across > 0.f ? w.x() / across : 0.f;
    }

    // Sets a parameter that the scene has: a word, or numbers.
    static void set(const Properties &props, const VellusParameter &row, VellusParameters &parameters) {
        if (row.words && props.has_property(row.name)) {
            const std::string word(props.template get<std::string_view>(row.name));
            check(vellus_parameters_set_word(&parameters, row.name, word.c_str()));
        } else if (!row.words) {
            set_numbers(props, row.name, parameters);
        }
    }

    // A number, a vector, or an RGB colour.
    static void set_numbers(const Properties &props, const char *name, VellusParameters &parameters) {
        if (!props.has_property(name))
            return;
        float values[3];
        size_t count = 3;
        switch (props.type(name)) {
            case Properties::Type::Float:
            case Properties::Type::Integer:
                values[0] = static_cast<float>(props.template get<double>(name));
                count     = 1;
                break;
            case Properties::Type::Vector: {
                const auto v = props.template get<ScalarVector3f>(name);
                for (size_t i = 0; i < 3; ++i)
                    values[i] = v[i];
                break;
            }
            case Properties::Type::Color: {
                const auto v = props.template get<ScalarColor3f>(name);
                for (size_t i = 0; i < 3; ++i)
                    values[i] = v[i];
                break;
            }
            default:
                Throw("vellus: %s must be a number, a vector or an RGB colour", name);
        }
        check(vellus_parameters_set(&parameters, name, values, count));
    }

    std::unique_ptr<VellusFiber, FreeFiber> m_fiber;
};

NAMESPACE_END(mitsuba)

extern "C" MI_EXPORT void init_plugin(std::string_view name, mitsuba::PluginRegisterFn register_plugin) {
    using Plugin = mitsuba::VellusBSDF<float, mitsuba::Color<float, 3>>;
    register_plugin(name, "scalar_rgb", mitsuba::ObjectType::BSDF,
                    [](void *, const mitsuba::Properties &props) -> mitsuba::ref<mitsuba::Object> {
                        return mitsuba::ref<mitsuba::Object>(new Plugin(props));
                    });
}
