// The fibres of the looks: the fibre panel of each look, how its colour varies over the coat, and the views.

import { createFiberPanel } from "./fiber-panel.js";
import { createFiberViews } from "./fiber-views.js";
import { check, element, slider } from "./controls.js";

// The server keeps numbers in single precision, and angles in radians.
const near = (a, b) => Math.abs(a - b) <= 1e-5 + 1e-4 * Math.max(Math.abs(a), Math.abs(b));
const same = (a, b) => Object.keys(b).every((key) => {
  if (typeof b[key] !== "number" && !Array.isArray(b[key])) return a[key] === b[key];
  const [x, y] = [a[key], b[key]].map((value) => [value].flat());
  return x.length === y.length && x.every((value, i) => near(value, y[i]));
});

export class FiberPanel {
  constructor(connection) {
    this.connection = connection;
    const ask = (request) => connection.ask({ type: "ask", request });
    this.source = { ask, color: (text) => ask({ named_color: text }) };
    this.selected = 0;
    this.panels = [];
    this.look = element("select", { "aria-label": "Look", onchange: () => this.choose(Number(this.look.value)) });
    this.model = element("select", { "aria-label": "Reflectance model", onchange: () =>
      connection.send({ type: "model", name: this.model.value }) });
    this.pattern = check({ label: "Keep the pattern of the scene", change: (pattern) => this.sendCoat({ pattern }),
      hint: "Strands keep their own colours. A new colour of the fibre replaces them" });
    this.tip = slider({ label: "Darker tips", min: 0.05, max: 50, step: 0.01, unit: "×", log: true,
      hint: "1 is even. Above 1 the tips are darker, below 1 they are paler",
      change: (tip) => this.sendCoat({ tip }) });
    this.holder = element("div", { class: "vellus" });
    this.root = element("div", { class: "body" },
      element("label", { class: "line field" }, element("span", { text: "Look" }), this.look),
      this.pattern.row, this.tip.row, this.holder,
      element("label", { class: "line field" }, element("span", { text: "Model" }), this.model));
    this.shape = element("div", { class: "vellus" });
    this.views = createFiberViews(this.shape, this.source, { controls: true });
  }

  get name() {
    return this.looks?.[this.selected]?.name ?? "look";
  }

  choose(index) {
    this.selected = index;
    this.show();
  }

  sendCoat(change) {
    Object.assign(this.coat, change);
    const { pattern, tip } = this.coat;
    this.connection.stream(`coat ${this.selected}`, { type: "coat", look: this.selected, pattern, tip });
  }

  // Shows the views of a strand that was clicked.
  inspect({ look, fiber, theta, h }) {
    if (this.looks[look] && look !== this.selected) this.choose(look);
    this.draw(fiber, { theta: Math.max(-89, Math.min(89, theta)), h, whole: false });
  }

  // The views cost time, so they are only drawn while they are visible.
  draw(fiber, more = {}) {
    this.shown = [fiber, { ...this.shown?.[1], other: this.others?.[this.selected] ?? null, ...more }];
    if (this.shape.closest("details")?.open) this.views.show(...this.shown);
  }

  update(state) {
    if (state.scene !== this.scene) {
      this.scene = state.scene;
      this.panels = [];
      this.shown = null;
      this.holder.replaceChildren();
      this.selected = 0;
    }
    this.looks = state.looks;
    const [fiber] = this.shown ?? [];
    const others = JSON.stringify(state.other.fibers);
    if (others !== JSON.stringify(this.others)) {
      this.others = state.other.fibers;
      if (fiber) this.draw(fiber);
    }
    this.model.replaceChildren(...state.models.map((name) => element("option", { value: name, text: name })));
    this.model.value = state.model;
    this.show();
  }

  show() {
    const look = this.looks[this.selected];
    this.root.hidden = !look;
    if (!look) return;
    const options = this.looks.map(({ name }, i) => element("option", { value: i, text: name }));
    if (document.activeElement !== this.look || this.look.options.length !== options.length) {
      this.look.replaceChildren(...options);
    }
    this.look.value = this.selected;
    this.coat = { pattern: look.pattern, tip: look.tip };
    this.pattern.row.hidden = !look.patterned;
    this.pattern.set(look.pattern);
    this.tip.set(look.tip);
    const own = this.panels[this.selected] ??= this.make(this.selected, look.fiber);
    this.panels.forEach((other, i) => { other.root.hidden = i !== this.selected; });
    // Another page, or a command that this page did not send, has changed the fibre.
    const { panel } = own;
    const sending = this.connection.merged.has(`look ${this.selected}`);
    if (panel && !own.moving && !sending && !same(panel.fiber, look.fiber)) {
      panel.set(look.fiber);
    }
  }

  make(index, fiber) {
    const made = { root: element("div"), panel: null, moving: false };
    this.holder.append(made.root);
    const onchange = (next, { done }) => {
      made.moving = !done;
      this.draw(next);
      if (same(next, this.looks[index].fiber)) return;
      this.connection.stream(`look ${index}`, { type: "look", look: index, fiber: next });
    };
    createFiberPanel(made.root, this.source, { fiber, onchange, history: false }).then((panel) => {
      made.panel = panel;
      if (this.selected === index) this.draw(panel.fiber);
    }, (error) => this.connection.emit("problem", error.message));
    return made;
  }
}
