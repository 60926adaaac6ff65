// The fibre of a look: its parameters from the table of the server, presets, undo and redo, A and B, and the coat.

import { button, check, element, slider } from "./controls.js";

// Parameters that describe the colour in other ways than by absorption are hidden: the colour has controls of its own.
const COLORS = ["melanin", "reflectance", "azimuthal_roughness_color"];

export class FiberPanel {
  constructor(connection) {
    this.connection = connection;
    this.root = element("div", { class: "body" });
    this.selected = 0;
    this.past = [];
    this.future = [];
    this.kept = { A: null, B: null };
    this.ready = fetch("parameters.json").then((response) => response.json()).then((table) => this.build(table));
  }

  get name() {
    return this.looks?.[this.selected]?.name ?? "look";
  }

  build({ parameters, presets }) {
    const text = (label, options) => element("select", { "aria-label": label },
      ...options.map(([value, name]) => element("option", { value, text: name })));
    this.look = text("Look", []);
    this.look.addEventListener("change", () => this.choose(Number(this.look.value)));
    this.preset = text("Preset", [["", "Preset …"], ...presets.map(({ name }) => [name, name])]);
    this.preset.addEventListener("change", () => {
      const found = presets.find(({ name }) => name === this.preset.value);
      if (found) this.set({ ...found.fiber });
      this.preset.value = "";
    });
    this.undo = button("Undo", () => this.back(this.past, this.future), "Undo the last change of the fibre");
    this.redo = button("Redo", () => this.back(this.future, this.past), "Redo the change");
    const keep = ["A", "B"].map((name) => {
      const made = button(name, () => this.compare(name), `Shows fibre ${name}. Shift + click stores the fibre`);
      made.setAttribute("aria-pressed", "false");
      return made;
    });
    this.keep = keep;
    this.color = element("input", { type: "color", "aria-label": "Colour of a dense coat", value: "#808080" });
    this.color.addEventListener("input", () => this.setColor(this.color.value));
    this.pattern = check({ label: "Keep the pattern of the scene", hint: "Strands keep their own colours",
      change: (pattern) => this.sendCoat({ pattern }) });
    this.tip = slider({ label: "Darker tips", min: 0.05, max: 50, step: 0.01, unit: "×", log: true,
      hint: "Absorption at the tip relative to the root. 1 is even; above 1 is darker",
      change: (tip) => this.sendCoat({ tip }) });
    this.controls = parameters.filter(({ name }) => !COLORS.includes(name)).map((parameter) => this.control(parameter));
    this.root.replaceChildren(
      element("div", { class: "line" }, this.look, this.preset),
      element("div", { class: "line" }, this.undo, this.redo, element("span", { class: "hint", text: "Compare" }),
        ...keep, button("Store A", () => this.store("A")), button("Store B", () => this.store("B"))),
      element("h3", { text: "Colour of the coat" }),
      element("label", { class: "line" }, this.color, "Colour of a dense coat"),
      this.pattern.row, this.tip.row,
      element("h3", { text: "Fibre" }),
      ...this.controls.flatMap(({ rows }) => rows),
    );
    if (this.looks) this.show();
  }

  // The sliders of a parameter, one for each channel.
  control({ name, label, channels, min, max, unit, hint }) {
    const step = max - min > 20 ? 0.1 : 0.001;
    const sliders = channels.map((channel, k) => slider({
      label: channel ? `${label} ${channel}` : label, min, max, step, unit, hint,
      change: (x) => {
        const fiber = structuredClone(this.fiber);
        if (channels.length > 1) fiber[name][k] = x;
        else fiber[name] = x;
        this.set(fiber, `${name} ${k}`);
      },
    }));
    const set = (fiber) => {
      const value = fiber[name];
      for (const [k, control] of sliders.entries()) {
        control.row.hidden = value === undefined;
        if (value !== undefined) control.set(channels.length > 1 ? value[k] : value);
      }
    };
    return { rows: sliders.map((control) => control.row), set };
  }

  // Sends a fibre. Changes of the same slider within a second are one step of undo.
  set(fiber, kind = null) {
    const now = Date.now();
    if (!(kind && kind === this.kind && now - this.time < 1000)) this.past.push(structuredClone(this.current()));
    if (this.past.length > 200) this.past.shift();
    [this.kind, this.time] = [kind, now];
    this.future = [];
    this.send(fiber);
  }

  current() {
    return { look: this.selected, fiber: this.fiber, coat: { pattern: this.coat.pattern, tip: this.coat.tip } };
  }

  send(fiber) {
    this.fiber = fiber;
    this.show();
    this.connection.stream(`look ${this.selected}`, { type: "look", look: this.selected, fiber });
  }

  sendCoat(change) {
    this.past.push(structuredClone(this.current()));
    this.future = [];
    Object.assign(this.coat, change);
    const { pattern, tip } = this.coat;
    this.connection.stream(`coat ${this.selected}`, { type: "coat", look: this.selected, pattern, tip });
  }

  async apply({ look, fiber, coat }) {
    await this.connection.send({ type: "look", look, fiber });
    await this.connection.send({ type: "coat", look, ...coat });
  }

  back(from, to) {
    const step = from.pop();
    if (!step) return;
    to.push(structuredClone(this.current()));
    this.kind = null;
    this.apply(step);
    this.show();
  }

  store(name) {
    this.kept[name] = structuredClone(this.current());
    this.show();
  }

  compare(name) {
    if (this.kept[name]) this.apply(this.kept[name]);
    else this.store(name);
  }

  // The server finds the absorption that gives a coat this colour.
  setColor(hex) {
    const linear = [1, 3, 5].map((i) => {
      const s = Number.parseInt(hex.slice(i, i + 2), 16) / 255;
      return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
    });
    const fiber = structuredClone(this.fiber);
    delete fiber.sigma_ca;
    delete fiber.sigma_ma;
    fiber.reflectance = linear.map((x) => Math.min(0.98, Math.max(0.002, x)));
    if (Date.now() - (this.colored ?? 0) > 1000) this.past.push(structuredClone(this.current()));
    this.colored = Date.now();
    this.future = [];
    this.connection.stream(`look ${this.selected}`, { type: "look", look: this.selected, fiber });
  }

  choose(index) {
    this.selected = index;
    this.fiber = this.looks[index].fiber;
    this.coat = this.looks[index];
    this.show();
  }

  inspect(strand) {
    if (strand.look !== this.selected && this.looks[strand.look]) this.choose(strand.look);
  }

  lobes() {}

  update(state) {
    this.looks = state.looks;
    if (this.selected >= this.looks.length) this.selected = 0;
    const look = this.looks[this.selected];
    if (!look) return;
    this.fiber = structuredClone(look.fiber);
    this.coat = { ...look };
    this.show();
  }

  show() {
    if (!this.look || !this.fiber) return;
    this.look.replaceChildren(...this.looks.map(({ name }, i) => element("option", { value: i, text: name })));
    this.look.value = this.selected;
    this.look.hidden = this.looks.length < 2;
    this.undo.disabled = this.past.length === 0;
    this.redo.disabled = this.future.length === 0;
    for (const made of this.keep) made.textContent = this.kept[made.textContent[0]] ? `${made.textContent[0]} ✓` : made.textContent[0];
    this.pattern.row.hidden = !this.coat.patterned;
    this.pattern.set(this.coat.pattern);
    this.tip.set(this.coat.tip);
    for (const control of this.controls) control.set(this.fiber);
  }
}
