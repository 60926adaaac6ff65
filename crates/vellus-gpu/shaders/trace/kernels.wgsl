// The kernels of the path tracer. A path waits in memory between them. So the search for hits, which takes most of the
// time, does not need the registers of scattering, and threads that run together do the same (Laine et al. 2013,
// Megakernels Considered Harmful).

// A path, and what its ray hits.
struct State {
    path: Path,
    sampler: Sampler,
    time: f32,
    hit: Hit,
}

// Lists of paths: those with a ray to trace, those with a hit of a strand, and others with a traced ray.
const RAYS = 0u;
const STRANDS = 1u;
const OTHERS = 2u;

fn listed(which: u32, k: u32) -> u32 {
    return lists[which * arrayLength(&work) + k];
}

fn list(which: u32, i: u32) {
    let k = atomicAdd(&counts[which], 1u);
    lists[which * arrayLength(&work) + k] = i;
}

// One thread for each sample.
@compute @workgroup_size(64)
fn begin_paths(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&work) {
        return;
    }
    var path: Path;
    var sampler: Sampler;
    begin_path(&path, &sampler, id.x);
    states[id.x].path = path;
    states[id.x].sampler = sampler;
    states[id.x].time = path_time;
    list(RAYS, id.x);
}

// Finds what the next ray of each path hits: that of its last shadow ray, if there are any.
@compute @workgroup_size(64)
fn trace_rays(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= atomicLoad(&counts[RAYS]) {
        return;
    }
    let i = listed(RAYS, id.x);
    path_time = states[i].time;
    let shadows = states[i].path.shadows;
    var ray = states[i].path.ray;
    var casters = NONE;
    if shadows > 0u {
        ray = states[i].path.waiting[shadows - 1u].ray;
        if HAS_LINKS {
            casters = casters_of(states[i].path.waiting[shadows - 1u].which);
        }
    }
    let hit = hit_scene(ray, shadows > 0u, casters);
    states[i].hit = hit;
    list(select(OTHERS, STRANDS, shadows == 0u && hit.kind == 1u), i);
}

// Empties the list that was read. One thread, after the rays are traced and after the hits are shaded.
@compute @workgroup_size(1)
fn empty_lists() {
    let shaded = atomicLoad(&counts[3]) == 1u;
    atomicStore(&counts[3], select(1u, 0u, shaded));
    if shaded {
        atomicStore(&counts[STRANDS], 0u);
        atomicStore(&counts[OTHERS], 0u);
    } else {
        atomicStore(&counts[RAYS], 0u);
    }
}

// Lets a path wait for its next ray, or ends it.
fn go_on(path: ptr<function, Path>, i: u32) {
    (*path).rays += 1u;
    if HAS_LINKS && (*path).shadows == 0u && (*path).through != NONE {
        find_through(path);
    }
    if (*path).goes_on == 0u && (*path).shadows == 0u {
        end_path(path);
        return;
    }
    states[i].path = *path;
    list(RAYS, i);
}

// Shades the hits of strands.
@compute @workgroup_size(64)
fn shade_strands(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= atomicLoad(&counts[STRANDS]) {
        return;
    }
    let i = listed(STRANDS, id.x);
    path_time = states[i].time;
    var path = states[i].path;
    var sampler = states[i].sampler;
    scatter_event(&path, &sampler, path.ray, states[i].hit, true);
    states[i].sampler = sampler;
    go_on(&path, i);
}

// Shades the hits of meshes, ends shadow rays, and finds the light of rays that hit nothing.
@compute @workgroup_size(64)
fn shade_others(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= atomicLoad(&counts[OTHERS]) {
        return;
    }
    let i = listed(OTHERS, id.x);
    path_time = states[i].time;
    var path = states[i].path;
    if path.shadows > 0u {
        end_shadow(&path, states[i].hit);
    } else {
        var sampler = states[i].sampler;
        scatter_event(&path, &sampler, path.ray, states[i].hit, false);
        states[i].sampler = sampler;
    }
    go_on(&path, i);
}
