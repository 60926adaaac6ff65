// Runs the compute shader in GLSL with OpenGL, without a window. Without arguments it says whether there is an OpenGL.
// Arguments: the file of the shader, the number of queries, then pairs of a binding and the file of its buffer, `-` for
// the answers. The answers go to standard output.
#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

using Pointer = void*;
static Pointer (*address)(const char*);

// A function of EGL or OpenGL by its name. Types of both are numbers and pointers.
template <class Result, class... Arguments>
static Result call(const char* name, Arguments... arguments) {
    const Pointer found = address(name);
    if (!found) {
        std::fprintf(stderr, "there is no function %s\n", name);
        std::exit(1);
    }
    return reinterpret_cast<Result (*)(Arguments...)>(found)(arguments...);
}

[[noreturn]] static void fail(const char* what) {
    std::fprintf(stderr, "%s\n", what);
    std::exit(1);
}

static std::vector<char> read(const char* path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

static void open() {
    const Pointer library = dlopen("libEGL.so.1", RTLD_NOW);
    if (!library) fail("there is no libEGL.so.1");
    address = reinterpret_cast<Pointer (*)(const char*)>(dlsym(library, "eglGetProcAddress"));
    const Pointer none = nullptr;
    const int* const no_list = nullptr;
    // EGL_PLATFORM_SURFACELESS_MESA, EGL_OPENGL_API, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE, and the version.
    const Pointer display = call<Pointer>("eglGetPlatformDisplayEXT", 0x31DD, none, no_list);
    if (!call<unsigned>("eglInitialize", display, none, none)) fail("EGL has no display without a window");
    call<unsigned>("eglBindAPI", 0x30A2);
    const int wanted[] = {0x3040, 8, 0x3033, 0, 0x3038}, version[] = {0x3098, 4, 0x30FB, 3, 0x3038};
    Pointer config = nullptr;
    int count = 0;
    call<unsigned>("eglChooseConfig", display, &wanted[0], &config, 1, &count);
    const Pointer context = call<Pointer>("eglCreateContext", display, config, none, &version[0]);
    if (!call<unsigned>("eglMakeCurrent", display, none, none, context)) fail("there is no OpenGL 4.3");
}

// Fails with the log of a shader or program.
static void check(const char* kind, unsigned object, unsigned status) {
    int good = 0;
    call<void>((std::string("glGet") + kind + "iv").c_str(), object, status, &good);
    char log[4096] = "";
    call<void>((std::string("glGet") + kind + "InfoLog").c_str(), object, int{sizeof log}, Pointer{}, &log[0]);
    if (!good) fail(log);
}

int main(int count, char** arguments) {
    open();
    if (count == 1) return std::puts(call<const char*>("glGetString", 0x1F01u)) < 0;
    const std::vector<char> source = read(arguments[1]);
    const char* text = source.data();
    const int length = static_cast<int>(source.size());
    const unsigned shader = call<unsigned>("glCreateShader", 0x91B9u), program = call<unsigned>("glCreateProgram");
    call<void>("glShaderSource", shader, 1, &text, &length);
    call<void>("glCompileShader", shader);
    check("Shader", shader, 0x8B81);
    call<void>("glAttachShader", program, shader);
    call<void>("glLinkProgram", program);
    check("Program", program, 0x8B82);
    call<void>("glUseProgram", program);

    const unsigned queries = static_cast<unsigned>(std::stoul(arguments[2])), storage = 0x90D2;
    std::vector<char> answers(queries * size_t{ANSWER});
    unsigned answered = 0;
    for (int k = 3; k + 1 < count; k += 2) {
        const bool is_answer = arguments[k + 1] == std::string("-");
        const std::vector<char> bytes = is_answer ? answers : read(arguments[k + 1]);
        unsigned buffer = 0;
        call<void>("glGenBuffers", 1, &buffer);
        call<void>("glBindBuffer", storage, buffer);
        call<void>("glBufferData", storage, static_cast<long>(bytes.size()), bytes.data(), 0x88E4u);
        call<void>("glBindBufferBase", storage, static_cast<unsigned>(std::stoul(arguments[k])), buffer);
        if (is_answer) answered = buffer;
    }
    call<void>("glDispatchCompute", (queries + 63) / 64, 1u, 1u);
    call<void>("glMemoryBarrier", 0xFFFFFFFFu);
    call<void>("glBindBuffer", storage, answered);
    call<void>("glGetBufferSubData", storage, 0l, static_cast<long>(answers.size()), answers.data());
    if (call<unsigned>("glGetError")) fail("OpenGL reports an error");
    return std::fwrite(answers.data(), 1, answers.size(), stdout) == answers.size() ? 0 : 1;
}
