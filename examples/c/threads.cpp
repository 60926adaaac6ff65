// One fibre from JSON, used by several threads: each evaluates a part of an array of directions of the far field. Then a
// wrong fibre, whose message is shown. README.md in this folder says how to build it.
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>
#include <vellus.h>

static void check(VellusStatus status)
{
    if (status != VELLUS_STATUS_OK)
        throw std::runtime_error(vellus_last_error());
}

struct Free {
    void operator()(VellusFiber *fiber) const { vellus_fiber_free(fiber); }
    void operator()(VellusHit *hit) const { vellus_hit_free(hit); }
};
using Fiber = std::unique_ptr<VellusFiber, Free>;
using Hit = std::unique_ptr<VellusHit, Free>;

static Fiber from_json(const char *json)
{
    VellusFiber *fiber = nullptr;
    check(vellus_fiber_from_json(json, &fiber));
    return Fiber(fiber);
}

static Hit prepare(const Fiber &fiber, const float *wo, VellusWindow window)
{
    VellusHit *hit = nullptr;
    check(vellus_hit_new(fiber.get(), wo, window, &hit));
    return Hit(hit);
}

int main()
{
    try {
        const Fiber fiber = from_json(R"({"preset": "cat", "melanin": [1.3, 0.2], "beta_n": 12})");
        const float wo[3] = {0.36f, 0.48f, 0.8f};
        const Hit hit = prepare(fiber, wo, vellus_window_far());

        constexpr std::size_t threads = 4, each = 10;
        std::vector<float> directions, rgb(3 * threads * each);
        for (std::size_t i = 0; i < threads * each; i++) {
            const float sign = i % 2 ? 1.0f : -1.0f;
            const float swapped[2][3] = {{0.48f * sign, -0.6f, 0.64f}, {0.8f, 0.36f * sign, -0.48f}};
            directions.insert(directions.end(), swapped[i % 4 / 2], swapped[i % 4 / 2] + 3);
        }
        std::vector<VellusStatus> statuses(threads);
        std::vector<std::thread> workers;
        for (std::size_t part = 0; part < threads; part++) {
            workers.emplace_back([&, part] {
                VellusQueries queries{};
                queries.count = each;
                queries.wi = {&directions[3 * part * each], 3 * sizeof(float)};
                VellusValues values{};
                values.rgb = {&rgb[3 * part * each], 3 * sizeof(float)};
                statuses[part] = vellus_hit_eval_array(hit.get(), &queries, &values);
            });
        }
        for (std::thread &worker : workers)
            worker.join();
        for (VellusStatus status : statuses)
            check(status);
        for (std::size_t i = 0; i < rgb.size(); i += 3)
            std::printf("far %a %a %a\n", double(rgb[i]), double(rgb[i + 1]), double(rgb[i + 2]));

        try {
            from_json(R"({"kappa": 2})");
        } catch (const std::runtime_error &error) {
            std::printf("refused: %s\n", error.what());
        }
        return 0;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 1;
    }
}
