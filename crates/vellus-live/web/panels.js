// The panels at the side: fibres, lights, groom, camera, picture, and the strand that was clicked.

import { FiberPanel } from "./fiber.js";
import { button, element, facts, panel, plain, slider } from "./controls.js";

const SIZES = [[480, 320], [720, 480], [960, 640], [1200, 800], [1440, 960], [1920, 1280]];

export class Panels {
  constructor(root, connection, viewport) {
    this.connection = connection;
    this.fiber = new FiberPanel(connection);
    this.lights = element("div", { class: "body" });
    this.strand = element("div", {}, element("p", { class: "hint", text: "Press Inspect, then click a strand." }));
    const views = panel("Views of the fibre", false, this.fiber.shape);
    views.addEventListener("toggle", () => this.fiber.shown && this.fiber.draw(this.fiber.shown[0]));
    const all = [
      panel("Fibre", true, this.fiber.root),
      panel("Groom", true, ...this.groom()),
      panel("Lights", true, ...this.light()),
      panel("Camera", false, ...this.camera()),
      panel("Strand", false, this.strand),
      views,
      panel("Save and load", true, ...this.files()),
    ];
    const jump = (one) => button(one.dataset.short, () => {
      one.open = true;
      one.scrollIntoView({ block: "start" });
    }, one.querySelector("summary").textContent);
    root.append(element("nav", { "aria-label": "Panels" }, ...all.map(jump)), ...all);
    viewport.addEventListener("pick", ({ detail }) => this.picked(detail));
  }

  groom() {
    const values = { density: 1, length: 1, clump: 0, clump_strands: 40 };
    const send = (name, x) => {
      values[name] = x;
      this.connection.stream("groom", { type: "groom", ...values });
    };
    const define = (name, options) => slider({ ...options, change: (x) => send(name, x) });
    const sliders = {
      density: define("density", { label: "Density", min: 0.01, max: 4, step: 0.01, unit: "×",
        hint: "Strands relative to the scene; above 1 there are more between them" }),
      length: define("length", { label: "Length", min: 0.1, max: 5, step: 0.01, unit: "×", log: true,
        hint: "Length relative to the scene" }),
      clump: define("clump", { label: "Clumping", min: 0, max: 1, step: 0.01,
        hint: "How far tips of a clump move together" }),
      clump_strands: define("clump_strands", { label: "Clump size", min: 2, max: 1000, step: 1, log: true, whole: true,
        hint: "Strands per clump" }),
    };
    this.onGroom = (groom) => {
      Object.assign(values, groom);
      for (const [name, control] of Object.entries(sliders)) control.set(groom[name]);
    };
    const reset = button("Groom of the scene", () =>
      this.connection.send({ type: "groom", density: 1, length: 1, clump: 0, clump_strands: 40 }));
    return [...Object.values(sliders).map((control) => control.row), element("div", { class: "line" }, reset)];
  }

  light() {
    this.azimuth = slider({ label: "Rotate lights", min: -180, max: 180, step: 1, unit: "°",
      hint: "Lamps and skies turn around the middle of the scene",
      change: (degrees) => this.connection.stream("azimuth", { type: "azimuth", degrees }) });
    return [this.azimuth.row, this.lights];
  }

  // Makes the controls of the lights of a scene.
  makeLights(lights) {
    this.lightRows = lights.map((light, index) => {
      const values = { gain: light.gain, shift: [...light.shift] };
      const send = () => this.connection.stream(`light ${index}`, { type: "light", light: index, ...values });
      const gain = slider({ label: "Brightness", min: 0, max: 10, step: 0.01, unit: "×",
        change: (x) => { values.gain = x; send(); } });
      const reach = Math.max(1, this.distance);
      const axes = ["x", "y", "z"].map((axis, k) => slider({ label: `Move ${axis}`, min: -reach, max: reach,
        step: reach > 20 ? 0.1 : 0.01, change: (x) => { values.shift[k] = x; send(); } }));
      const rows = light.movable ? [gain, ...axes] : [gain];
      return {
        root: element("div", { class: "group", role: "group", "aria-label": `Light ${light.name}` },
          element("h2", { text: light.name === light.kind ? light.name : `${light.name} (${light.kind})` }),
          ...rows.map((control) => control.row)),
        set: (state) => {
          Object.assign(values, { gain: state.gain, shift: [...state.shift] });
          gain.set(state.gain);
          axes.forEach((axis, k) => axis.set(state.shift[k]));
        },
      };
    });
    this.lights.replaceChildren(...this.lightRows.map((row) => row.root));
  }

  camera() {
    let lens = { angle: 30, radius: 0 };
    const send = () => this.connection.stream("lens", { type: "lens", ...lens });
    const angle = slider({ label: "View angle", min: 1, max: 150, step: 0.1, unit: "°", log: true,
      change: (x) => { lens.angle = x; send(); } });
    const aperture = slider({ label: "Lens radius", min: 0, max: 5, step: 0.01,
      hint: "0 is a pinhole. A larger lens blurs what is out of focus",
      change: (x) => { lens.radius = x; send(); } });
    const numbers = element("dl", { class: "facts" });
    const position = (p) => p.map((x) => x.toFixed(2)).join("  ");
    this.onCamera = (camera) => {
      lens = { angle: camera.angle, radius: camera.radius };
      angle.set(camera.angle);
      aperture.set(camera.radius);
      numbers.replaceChildren(...facts([["Position", position(camera.eye)], ["Target", position(camera.target)],
        ["Focus distance", camera.focus.toFixed(2)]]));
    };
    return [angle.row, aperture.row, numbers];
  }

  files() {
    const size = element("select", { "aria-label": "Size of the picture", onchange: () => {
      const [width, height] = size.value.split("x").map(Number);
      this.connection.send({ type: "size", width, height });
    } });
    const target = slider({ label: "Samples", min: 1, max: 4096, step: 1, log: true, whole: true,
      hint: "Samples a pixel", change: (samples) => this.connection.stream("target", { type: "target", samples }) });
    const save = (text, file, name, hint) => button(text, () => this.save(file(), name()), hint);
    const look = () => this.fiber.selected;
    const saves = element("div", { class: "line", role: "group", "aria-label": "Save" },
      save("Look TOML", () => `look-${look()}.toml`, () => `${this.fiber.name}.toml`,
        "The fibre, for vellus render --fiber. Not the tips and the groom"),
      save("Look USD", () => `look-${look()}.usda`, () => `${this.fiber.name}.usda`,
        "The fibre as a USD material. Not the tips and the groom"),
      save("Scene USD", () => "scene.usdc", () => "scene.usdc",
        "All as shown: strands with colour, tips, length, density and clumps, meshes, lights and camera"),
      save("Lights USD", () => "lights.usda", () => "lights.usda", "The lights as they are now"),
      save("Camera USD", () => "camera.usda", () => "camera.usda", "The camera"),
      save("PNG", () => "picture.png", () => "picture.png", "The picture with its exposure"),
      save("EXR", () => "picture.exr", () => "picture.exr", "The picture without exposure"));
    const input = element("input", { type: "file", accept: ".abc,.hair,.tfx,.data,.ply,.npy,.npz,.obj", hidden: true, onchange: () => {
      if (input.files[0]) this.load(input.files[0]);
      input.value = "";
    } });
    const open = element("select", { "aria-label": "Open a scene of the folder", onchange: () => {
      if (open.value) this.connection.send({ type: "open", file: open.value });
    } });
    this.onFiles = (state) => {
      const sizes = SIZES.some(([w, h]) => w === state.size[0] && h === state.size[1]) ? SIZES : [state.size, ...SIZES];
      size.replaceChildren(...sizes.map(([w, h]) => element("option", { value: `${w}x${h}`, text: `${w} × ${h}` })));
      size.value = state.size.join("x");
      target.set(state.target);
      open.hidden = state.files.length === 0;
      open.replaceChildren(element("option", { value: "", text: "Open from the folder …" }),
        ...state.files.map((file) => element("option", { value: file, text: plain(file) })));
    };
    return [
      element("label", { class: "line" }, "Size", size), target.row,
      element("h2", { text: "Save" }), saves,
      element("p", { class: "hint", text: "Scene USD has everything but images. Look TOML has one fibre." }),
      element("h2", { text: "Load" }), element("div", { class: "line" },
        button("Load a groom …", () => input.click()), input, open),
      element("p", { class: "hint", text: "Or drop an .abc, .hair, .tfx, .ply, .npz or .obj file on the page." }),
    ];
  }

  // Fetches a file and saves it. An error shows its message instead of a broken file.
  async save(file, name) {
    this.say("saving …");
    try {
      const response = await this.connection.post(`save/${file}`);
      if (!response.ok) throw new Error(await response.text());
      const url = URL.createObjectURL(await response.blob());
      element("a", { href: url, download: name }).click();
      setTimeout(() => URL.revokeObjectURL(url), 10_000);
      const missing = file === "scene.usdc" && this.images > 0;
      this.say(missing ? `saved ${name}, without the images of the scene (${this.images})` : `saved ${name}`, missing);
    } catch (error) {
      this.say(error.message, true);
    }
  }

  async load(file) {
    this.say(`loading ${file.name} …`);
    try {
      const response = await this.connection.post(`load?${encodeURIComponent(file.name)}`, file);
      const text = await response.text();
      this.say(response.ok ? `${file.name}: ${text}` : `${file.name}: ${text}`, !response.ok);
    } catch (error) {
      this.say(`${file.name}: ${error.message}`, true);
    }
  }

  say(text, bad = false) {
    const note = document.getElementById("note");
    note.textContent = text;
    note.classList.toggle("bad", bad);
  }

  picked(answer) {
    if (!answer.hit) {
      this.strand.replaceChildren(element("p", { class: "hint", text: "There is no object." }));
      return;
    }
    const number = (x) => (Math.abs(x) >= 1e4 || Math.abs(x) < 1e-3 ? x.toExponential(3) : x.toPrecision(4));
    const pairs = [["Object", answer.name], ["Point", answer.point.map(number).join("  ")],
      ["Distance", number(answer.distance)]];
    if (answer.strand) {
      const { number: id, h, theta } = answer.strand;
      pairs.push(["Strand", String(id)], ["Offset h", h.toFixed(3)], ["Inclination θ", `${theta.toFixed(1)}°`]);
      this.fiber.inspect(answer.strand);
    }
    const list = element("dl", { class: "facts" }, ...facts(pairs));
    this.strand.replaceChildren(list, ...(answer.strand ? [button("Show its lobes", () => {
      this.fiber.shape.closest("details").open = true;
      this.fiber.shape.scrollIntoView({ block: "start" });
    })] : []));
    this.strand.closest("details").open = true;
    this.strand.scrollIntoView({ block: "nearest" });
  }

  update(state) {
    this.distance = Math.hypot(...state.camera.eye.map((x, k) => x - state.camera.target[k]));
    const key = JSON.stringify([state.scene, state.lights.map((light) => [light.name, light.kind])]);
    if (key !== this.key) {
      this.key = key;
      this.makeLights(state.lights);
    }
    state.lights.forEach((light, i) => this.lightRows[i].set(light));
    this.azimuth.set(state.azimuth);
    this.images = state.images;
    this.onGroom(state.groom);
    this.onCamera(state.camera);
    this.onFiles(state);
    this.fiber.update(state);
  }
}
