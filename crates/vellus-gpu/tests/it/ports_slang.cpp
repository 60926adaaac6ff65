// Runs the compute shader that slangc made of the library, on the processor. `SHADER` is its file and `ENTRY` its entry
// point. Arguments: the number of queries, then pairs of a binding and the file of its buffer, `-` for the answers, in
// the order in which the HLSL declares them. The answers go to standard output.
#include SHADER

#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

struct Bound {
    void* data;
    size_t bytes;
};

int main(int count, char** arguments) {
    const unsigned queries = static_cast<unsigned>(std::stoul(arguments[1]));
    std::vector<std::vector<char>> contents;
    std::vector<Bound> buffers;
    size_t answers = 0;
    for (int k = 3; k < count; k += 2) {
        if (arguments[k] == std::string("-")) {
            answers = contents.size();
            contents.emplace_back(queries * size_t{ANSWER});
        } else {
            std::ifstream file(arguments[k], std::ios::binary);
            contents.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
        }
        buffers.push_back({contents.back().data(), contents.back().size()});
    }
    // Slang passes the buffers in this order, as pointers and sizes.
    ComputeVaryingInput groups = {};
    groups.endGroupID = {(queries + 63) / 64, 1, 1};
    ENTRY(&groups, nullptr, buffers.data());
    const std::vector<char>& found = contents[answers];
    return std::fwrite(found.data(), 1, found.size(), stdout) == found.size() ? 0 : 1;
}
