// Draws a ball of fur with a compute shader of Vulkan: `furball FOLDER OUT.ppm [SIZE] [SAMPLES]`. FOLDER has the files
// of `vellus shaders` and furball.spv. The exit code is 2 if there is no device.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>
#include <vulkan/vulkan.h>

constexpr float SKIN = 0.85f, EXTENT = 1.4f;
constexpr uint32_t CELLS = 96, STRANDS = 24000, PARTS = 4, BINDINGS = 6;
constexpr float WIDTH = 2.0f * EXTENT / CELLS;

struct NoDevice : std::runtime_error { using runtime_error::runtime_error; };

static void check(VkResult result, const char *what)
{
    if (result != VK_SUCCESS)
        throw std::runtime_error(std::string(what) + ": VkResult " + std::to_string(result));
}

static std::vector<char> read(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    if (!file)
        throw std::runtime_error("cannot read " + path);
    return {std::istreambuf_iterator<char>(file), {}};
}

template <class T> static std::vector<char> bytes(const std::vector<T> &values)
{
    const char *data = reinterpret_cast<const char *>(values.data());
    return {data, data + values.size() * sizeof(T)};
}

struct Vec { float x, y, z; };
static Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static Vec operator*(float s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
static float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Vec unit(Vec a) { return 1.0f / std::sqrt(dot(a, a)) * a; }

struct Segment { Vec a; float radius; Vec b; float unused; };

static uint32_t state = 1;
// Uniform in [-1, 1).
static float random_number()
{
    state = state * 747796405u + 2891336453u;
    const uint32_t word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
    return float(((word >> 22) ^ word) >> 8) / 8388608.0f - 1.0f;
}

// Strands that stand on a ball, combed down and to the right, and bent by their weight: chains of cylinders.
static std::vector<Segment> strands()
{
    std::vector<Segment> segments;
    for (uint32_t i = 0; i < STRANDS; i++) {
        // Points of a spiral are evenly spread over the ball.
        const float y = 1.0f - 2.0f * (float(i) + 0.5f) / STRANDS, r = std::sqrt(1.0f - y * y);
        const float around = 2.399963f * float(i) + 0.02f * random_number();
        const Vec normal = {r * std::cos(around), y, r * std::sin(around)}, down = {0.45f, -1.0f, 0.2f};
        const Vec comb = down + -dot(down, normal) * normal;
        const Vec stray = {random_number(), random_number(), random_number()};
        // Neighbours form locks: waves over the ball turn them in the same direction.
        const Vec lock = {std::sin(9.0f * normal.y + 4.0f * normal.z), std::sin(8.0f * normal.z + 5.0f * normal.x),
                          std::sin(10.0f * normal.x + 3.0f * normal.y)};
        const float part = (0.36f + 0.06f * random_number()) / PARTS;
        Vec at = SKIN * normal, way = unit(normal + 0.35f * comb + 0.18f * stray + 0.2f * lock);
        for (uint32_t k = 0; k < PARTS; k++) {
            const Vec end = at + part * way;
            segments.push_back({at, 0.0055f * (1.0f - 0.2f * float(k)), end, 0.0f});
            at = end;
            way = unit(way + 0.3f * comb);
        }
    }
    return segments;
}

// The segments in each cell of a grid over the box of the ball.
static void grid(const std::vector<Segment> &segments, std::vector<uint32_t> &starts, std::vector<uint32_t> &items)
{
    std::vector<std::vector<uint32_t>> cells(CELLS * CELLS * CELLS);
    const auto cell = [](float x) { return uint32_t(std::clamp((x + EXTENT) / WIDTH, 0.0f, CELLS - 1.0f)); };
    const Vec corner = {-EXTENT, -EXTENT, -EXTENT};
    for (uint32_t i = 0; i < segments.size(); i++) {
        const float r = segments[i].radius;
        const Vec a = segments[i].a, b = segments[i].b, axis = b + -1.0f * a;
        for (uint32_t z = cell(std::min(a.z, b.z) - r); z <= cell(std::max(a.z, b.z) + r); z++)
            for (uint32_t y = cell(std::min(a.y, b.y) - r); y <= cell(std::max(a.y, b.y) + r); y++)
                for (uint32_t x = cell(std::min(a.x, b.x) - r); x <= cell(std::max(a.x, b.x) + r); x++) {
                    // Only where the ball around the cell reaches the segment.
                    const Vec to = WIDTH * Vec{x + 0.5f, y + 0.5f, z + 0.5f} + corner + -1.0f * a;
                    const Vec off = to + -std::clamp(dot(to, axis) / dot(axis, axis), 0.0f, 1.0f) * axis;
                    if (std::sqrt(dot(off, off)) <= r + 0.87f * WIDTH)
                        cells[(z * CELLS + y) * CELLS + x].push_back(i);
                }
    }
    starts = {0};
    for (const auto &list : cells) {
        items.insert(items.end(), list.begin(), list.end());
        starts.push_back(uint32_t(items.size()));
    }
}

// The constants of the shader.
struct Frame { uint32_t size, index, cells; float skin, extent; };

// A device with a compute queue. The process ends soon, and takes all objects with it.
struct Gpu {
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t family = 0;

    Gpu()
    {
        const VkApplicationInfo application = {
            VK_STRUCTURE_TYPE_APPLICATION_INFO, nullptr, "furball", 0, nullptr, 0, VK_API_VERSION_1_1};
        const VkInstanceCreateInfo info = {
            VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, nullptr, 0, &application, 0, nullptr, 0, nullptr};
        VkInstance instance;
        uint32_t count = 1;
        // VK_INCOMPLETE: there are more devices than the first.
        if (vkCreateInstance(&info, nullptr, &instance) != VK_SUCCESS ||
            vkEnumeratePhysicalDevices(instance, &count, &physical) < 0 || count == 0)
            throw NoDevice("there is no device for Vulkan");
        vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
        std::vector<VkQueueFamilyProperties> families(count);
        vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
        while (family < count && !(families[family].queueFlags & VK_QUEUE_COMPUTE_BIT))
            family++;
        const float priority = 1.0f;
        const VkDeviceQueueCreateInfo queues = {
            VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, family, 1, &priority};
        const VkDeviceCreateInfo create = {
            VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, nullptr, 0, 1, &queues, 0, nullptr, 0, nullptr, nullptr};
        if (family == count || vkCreateDevice(physical, &create, nullptr, &device) != VK_SUCCESS)
            throw NoDevice("the device for Vulkan cannot compute");
        vkGetDeviceQueue(device, family, 0, &queue);
    }

    // A buffer that both processors see, with its contents. Returns where they are.
    char *buffer(const std::vector<char> &contents, VkBuffer &buffer) const
    {
        const VkBufferCreateInfo info = {
            VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, nullptr, 0, contents.size(), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
            VK_SHARING_MODE_EXCLUSIVE, 0, nullptr};
        check(vkCreateBuffer(device, &info, nullptr, &buffer), "vkCreateBuffer");
        VkMemoryRequirements needs;
        vkGetBufferMemoryRequirements(device, buffer, &needs);
        VkPhysicalDeviceMemoryProperties memories;
        vkGetPhysicalDeviceMemoryProperties(physical, &memories);
        const uint32_t wanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
        VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size, 0};
        // Every device has such a memory for every buffer.
        while (!(needs.memoryTypeBits & (1u << allocate.memoryTypeIndex)) ||
               (memories.memoryTypes[allocate.memoryTypeIndex].propertyFlags & wanted) != wanted)
            allocate.memoryTypeIndex++;
        VkDeviceMemory memory;
        check(vkAllocateMemory(device, &allocate, nullptr, &memory), "vkAllocateMemory");
        check(vkBindBufferMemory(device, buffer, memory, 0), "vkBindBufferMemory");
        void *mapped;
        check(vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
        std::memcpy(mapped, contents.data(), contents.size());
        return static_cast<char *>(mapped);
    }

    // Runs the shader once for each sample.
    void run(const std::vector<char> &code, const VkBuffer *buffers, Frame frame, uint32_t samples) const
    {
        const VkShaderModuleCreateInfo module_info = {
            VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, nullptr, 0, code.size(),
            reinterpret_cast<const uint32_t *>(code.data())};
        VkShaderModule module;
        check(vkCreateShaderModule(device, &module_info, nullptr, &module), "vkCreateShaderModule");
        VkDescriptorSetLayoutBinding bindings[BINDINGS];
        for (uint32_t i = 0; i < BINDINGS; i++)
            bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
        const VkDescriptorSetLayoutCreateInfo set_info = {
            VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, nullptr, 0, BINDINGS, bindings};
        VkDescriptorSetLayout set_layout;
        check(vkCreateDescriptorSetLayout(device, &set_info, nullptr, &set_layout), "vkCreateDescriptorSetLayout");
        const VkPushConstantRange constants = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(Frame)};
        const VkPipelineLayoutCreateInfo layout_info = {
            VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, nullptr, 0, 1, &set_layout, 1, &constants};
        VkPipelineLayout layout;
        check(vkCreatePipelineLayout(device, &layout_info, nullptr, &layout), "vkCreatePipelineLayout");
        const VkPipelineShaderStageCreateInfo stage = {
            VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, VK_SHADER_STAGE_COMPUTE_BIT, module,
            "main", nullptr};
        const VkComputePipelineCreateInfo pipeline_info = {
            VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO, nullptr, 0, stage, layout, VK_NULL_HANDLE, 0};
        VkPipeline pipeline;
        check(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &pipeline_info, nullptr, &pipeline), "the pipeline");

        const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, BINDINGS};
        const VkDescriptorPoolCreateInfo pool_info = {
            VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr, 0, 1, 1, &size};
        VkDescriptorPool pool;
        check(vkCreateDescriptorPool(device, &pool_info, nullptr, &pool), "vkCreateDescriptorPool");
        const VkDescriptorSetAllocateInfo allocate = {
            VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, pool, 1, &set_layout};
        VkDescriptorSet set;
        check(vkAllocateDescriptorSets(device, &allocate, &set), "vkAllocateDescriptorSets");
        VkDescriptorBufferInfo whole[BINDINGS];
        for (uint32_t i = 0; i < BINDINGS; i++)
            whole[i] = {buffers[i], 0, VK_WHOLE_SIZE};
        // It begins with binding 0, and goes on with the next ones.
        const VkWriteDescriptorSet write = {
            VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, set, 0, 0, BINDINGS, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
            nullptr, whole, nullptr};
        vkUpdateDescriptorSets(device, 1, &write, 0, nullptr);

        const VkCommandPoolCreateInfo commands_info = {
            VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
            family};
        VkCommandPool commands;
        check(vkCreateCommandPool(device, &commands_info, nullptr, &commands), "vkCreateCommandPool");
        const VkCommandBufferAllocateInfo command_info = {
            VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, commands, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
        VkCommandBuffer command;
        check(vkAllocateCommandBuffers(device, &command_info, &command), "vkAllocateCommandBuffers");
        for (frame.index = 0; frame.index < samples; frame.index++) {
            const VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr, 0, nullptr};
            check(vkBeginCommandBuffer(command, &begin), "vkBeginCommandBuffer");
            vkCmdBindPipeline(command, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
            vkCmdBindDescriptorSets(command, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
            vkCmdPushConstants(command, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof frame, &frame);
            vkCmdDispatch(command, (frame.size + 7) / 8, (frame.size + 7) / 8, 1);
            // The processor reads the sums.
            const VkMemoryBarrier barrier = {
                VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_SHADER_WRITE_BIT, VK_ACCESS_HOST_READ_BIT};
            vkCmdPipelineBarrier(command, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                                 &barrier, 0, nullptr, 0, nullptr);
            check(vkEndCommandBuffer(command), "vkEndCommandBuffer");
            const VkSubmitInfo submit = {
                VK_STRUCTURE_TYPE_SUBMIT_INFO, nullptr, 0, nullptr, nullptr, 1, &command, 0, nullptr};
            check(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
            // One sample at a time: a long command could be taken for a hang.
            check(vkQueueWaitIdle(queue), "vkQueueWaitIdle");
        }
    }
};

int main(int argc, char **argv)
try {
    if (argc < 3)
        throw std::runtime_error("usage: furball FOLDER OUT.ppm [SIZE] [SAMPLES]");
    const std::string folder = std::string(argv[1]) + "/";
    const uint32_t size = argc > 3 ? std::clamp(std::atoi(argv[3]), 1, 4096) : 256;
    const uint32_t samples = argc > 4 ? std::clamp(std::atoi(argv[4]), 1, 65536) : 16;
    const std::vector<Segment> segments = strands();
    std::vector<uint32_t> starts, items;
    grid(segments, starts, items);
    const std::vector<char> contents[BINDINGS] = {
        read(folder + "tables.bin"), read(folder + "fox.bin"), bytes(segments), bytes(starts), bytes(items),
        std::vector<char>(size_t{16} * size * size)};
    const Gpu gpu;
    VkBuffer buffers[BINDINGS];
    const char *image = nullptr;
    for (uint32_t i = 0; i < BINDINGS; i++)
        image = gpu.buffer(contents[i], buffers[i]);
    gpu.run(read(folder + "furball.spv"), buffers, {size, 0, CELLS, SKIN, EXTENT}, samples);

    // The sums of the samples, as sRGB.
    std::string picture = "P6\n" + std::to_string(size) + " " + std::to_string(size) + "\n255\n";
    for (size_t i = 0; i < size_t{size} * size; i++) {
        float sum[4];
        std::memcpy(sum, image + 16 * i, sizeof sum);
        for (int c = 0; c < 3; c++) {
            const float x = std::clamp(sum[c] / sum[3], 0.0f, 1.0f);
            const float shown = x < 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
            picture += char(uint8_t(255.0f * shown + 0.5f));
        }
    }
    // Under another name first, so that the file is never incomplete.
    const std::string part = std::string(argv[2]) + ".part";
    if (!(std::ofstream(part, std::ios::binary) << picture).flush() || std::rename(part.c_str(), argv[2]) != 0)
        throw std::runtime_error(std::string("cannot write ") + argv[2]);
    return 0;
} catch (const NoDevice &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
