"""Registers and instructions of both fields and of the reduced model, as compilers for AMD's and NVIDIA's GPUs count.

    vellus shaders shaders
    python lab/shaders/registers.py shaders

`--tracer FILE.wgsl` counts the path tracer of a scene instead, for AMD: the example `tracer` of vellus-gpu writes it.

No GPU is needed. For AMD: Mesa's driver RADV, the package `vulkan` of Python, and `naga` (naga-cli). For NVIDIA:
`slangc`, and the packages nvidia-cuda-nvrtc-cu12, nvidia-cuda-nvcc-cu12 and nvidia-cuda-runtime-cu12 of Python.
"""

import argparse
import ctypes
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ICD = "/usr/share/vulkan/icd.d/radeon_icd.x86_64.json"
# What a kernel computes: the calls in the near field. The far field has the same names with `far_`.
KERNELS = {
    "value and density": "answer.value = vellus_eval(&hit, query.wi);",
    "sample": "let drawn = vellus_sample(&hit, query.u); answer.direction = vec4<f32>(drawn.wi, drawn.pdf);"
    " answer.weight = vec4<f32>(drawn.weight, f32(drawn.lobe));",
}
# The reduced model has no queries.
REDUCED = """
struct Query { wo: vec3<f32>, wi: vec3<f32>, fur: VellusFur }
@group(0) @binding(0) var<storage, read> queries: array<Query>;
@group(0) @binding(1) var<storage, read_write> answers: array<vec3<f32>>;
@compute @workgroup_size(64) fn run(@builtin(global_invocation_id) id: vec3<u32>) {
    var hit: VellusReduced;
    vellus_reduced_hit(&hit, queries[id.x].fur, queries[id.x].wo);
    answers[id.x] = vellus_reduced_eval(&hit, queries[id.x].wi);
}
"""
KERNELS["both"] = " ".join(KERNELS.values())


def kernels(folder: Path):
    """The text of each kernel, with its name and entry point."""
    library = (folder / "vellus.wgsl").read_text()
    for field, far in (("near", ""), ("far", "far_")):
        text = library if not far else library + (folder / "vellus-far.wgsl").read_text()
        queries = (folder / ("far-queries.wgsl" if far else "queries.wgsl")).read_text()
        head, rest = re.fullmatch(r"(.*?_hit\([^\n]*\n)(.*)", queries, re.S).groups()
        for name, calls in KERNELS.items():
            calls = re.sub(r"vellus_(eval|sample)", rf"vellus_{far}\1", calls)
            body = f"var answer: Answer;\n{calls}\nanswers[id.x] = answer;\n}}\n"
            kernel = f"{text}\n{head}{body}"
            yield f"{field}, {name}", kernel, f"run_{far}queries"
            if (field, name) == ("near", "value and density"):
                hit = "vellus_hit_colored(&hit, query.fiber, 256u, VellusPigment(query.u.xyz, query.u.yzw),"
                kernel = kernel.replace("vellus_hit(&hit, query.fiber,", hit)
                yield "near, value and density of other absorption", kernel, "run_queries"
    yield "reduced, value", (folder / "vellus-reduced.wgsl").read_text() + REDUCED, "run"


def amd(spirv: Path, entry: str, family: str):
    """Compiles a kernel with RADV in this process, which prints what the compiler counts. Needs no GPU."""
    os.environ.update(NODEVICE_SELECT="1", RADV_FORCE_FAMILY=family, VK_ICD_FILENAMES=ICD)
    os.environ.update(RADV_DEBUG="shaderstats,nocache")
    import vulkan as vk

    version = vk.VkApplicationInfo(apiVersion=vk.VK_MAKE_VERSION(1, 2, 0))
    instance = vk.vkCreateInstance(vk.VkInstanceCreateInfo(pApplicationInfo=version), None)
    queue = vk.VkDeviceQueueCreateInfo(queueFamilyIndex=0, queueCount=1, pQueuePriorities=[1.0])
    gpu = vk.vkEnumeratePhysicalDevices(instance)[0]
    device = vk.vkCreateDevice(gpu, vk.VkDeviceCreateInfo(pQueueCreateInfos=[queue]), None)
    code = spirv.read_bytes()
    module = vk.vkCreateShaderModule(device, vk.VkShaderModuleCreateInfo(codeSize=len(code), pCode=code), None)
    kind, stage = vk.VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, vk.VK_SHADER_STAGE_COMPUTE_BIT
    buffers = [
        vk.VkDescriptorSetLayoutBinding(binding=k, descriptorType=kind, descriptorCount=1, stageFlags=stage)
        for k in range(16)
    ]
    layout = vk.vkCreateDescriptorSetLayout(device, vk.VkDescriptorSetLayoutCreateInfo(pBindings=buffers), None)
    layout = vk.vkCreatePipelineLayout(device, vk.VkPipelineLayoutCreateInfo(pSetLayouts=[layout]), None)
    shader = vk.VkPipelineShaderStageCreateInfo(stage=stage, module=module, pName=entry)
    made = vk.VkComputePipelineCreateInfo(stage=shader, layout=layout)
    vk.vkCreateComputePipelines(device, vk.VK_NULL_HANDLE, 1, [made], None)
    # The driver has no GPU to close.
    sys.stderr.flush()
    os._exit(0)


def nvidia(cuda: Path, architecture: str) -> str:
    """What ptxas counts for CUDA C++."""
    import nvidia

    packages = Path(next(iter(nvidia.__path__)))
    nvrtc = ctypes.CDLL(str(packages / "cuda_nvrtc/lib/libnvrtc.so.12"))
    program, size = ctypes.c_void_p(), ctypes.c_size_t()
    nvrtc.nvrtcCreateProgram(ctypes.byref(program), cuda.read_bytes(), b"kernel.cu", 0, None, None)
    options = [f"--gpu-architecture={architecture}", "-default-device", f"-I{packages}/cuda_runtime/include"]
    array = (ctypes.c_char_p * len(options))(*(option.encode() for option in options))
    if nvrtc.nvrtcCompileProgram(program, len(options), array) != 0:
        return "NVRTC refuses it"
    nvrtc.nvrtcGetPTXSize(program, ctypes.byref(size))
    text = ctypes.create_string_buffer(size.value)
    nvrtc.nvrtcGetPTX(program, text)
    ptx = cuda.with_suffix(".ptx")
    ptx.write_bytes(text.value)
    command = [packages / "cuda_nvcc/bin/ptxas", "-v", f"-arch={architecture}", ptx, "-o", "/dev/null"]
    told = subprocess.run(command, capture_output=True, text=True, check=True).stderr
    return ", ".join(re.findall(r"\d+ registers|\d+ bytes (?:stack frame|spill stores)", told))


def count(wgsl: Path, entry: str, family: str) -> dict:
    """What RADV counts for an entry point."""
    spirv = wgsl.with_suffix(".spv")
    subprocess.run(["naga", wgsl, spirv], check=True)
    again = [sys.executable, __file__, spirv, "--entry", entry, "--family", family]
    told = subprocess.run(again, capture_output=True, text=True, check=True).stderr
    return dict(re.findall(r"^(VGPRs|Spilled VGPRs|Scratch size|Instructions): (\d+)", told, re.M))


def main():
    """Prints a line for each kernel and compiler."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("folder", type=Path, nargs="?")
    options.add_argument("--tracer", type=Path)
    options.add_argument("--family", default="navi21")
    options.add_argument("--architecture", default="sm_90")
    options.add_argument("--entry", help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.entry:
        amd(given.folder, given.entry, given.family)
    if given.tracer:
        for entry in re.findall(r"@workgroup_size\(64\)\nfn (\w+)", given.tracer.read_text()):
            print(f"{given.tracer}: {entry}: {given.family}: {count(given.tracer, entry, given.family)}", flush=True)
        return
    for name, text, entry in kernels(given.folder):
        with tempfile.TemporaryDirectory() as folder:
            wgsl, hlsl, cuda = (Path(folder) / f"kernel.{end}" for end in ("wgsl", "hlsl", "cu"))
            wgsl.write_text(text)
            print(f"{name}: {given.family}: {count(wgsl, entry, given.family)}", flush=True)
            subprocess.run(["naga", wgsl, hlsl], check=True)
            slang = [os.environ.get("VELLUS_SLANGC", "slangc"), hlsl, "-lang", "slang", "-target", "cuda"]
            subprocess.run([*slang, "-stage", "compute", "-entry", entry, "-o", cuda], check=True)
            print(f"{name}: {given.architecture}: {nvidia(cuda, given.architecture)}", flush=True)


if __name__ == "__main__":
    main()
