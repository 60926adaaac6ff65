// The fibre panel: all parameters of a fibre, presets, colours, two looks, undo and redo.
//
// Use:
//   import { createFiberPanel } from "./fiber-panel.js";
//   const panel = await createFiberPanel(element, source, { fiber, onchange });
//
// `source` has one method, `async ask(request)`: it takes a request of `vellus_views::answer` as an object and returns
// the answer as an object. The panel shows an `error`. It may have `async color(text)`, which gives a name of a colour
// as `{ color: [r, g, b] }` (linear) or an `error`; otherwise names are those of CSS. `fiber` (optional) is an object
// with parameters.
// `onchange(fiber, info)` gets the fibre of the active look, with every parameter, after each change. `info` has
// `look` ("A" or "B"), `other` (the fibre of the other look), and `done` (false while a slider moves).
// With `history: false`, the panel has neither two looks nor undo and redo: the page has its own.
//
// The panel has: `fiber` (the active fibre), `other`, `look`, `set(fiber)` (one step of undo), `undo()`, `redo()`,
// `select("A" or "B")`. Include style.css. The element gets the class `vellus-panel`.

/** The groups after the colour, by the keys of the parameters. Parameters that no group names come last. */
const PANEL_GROUPS = [
  ["Gloss", ["beta_m", "beta_n", "wet"]],
  ["Cuticle", ["eta", "layers", "alpha", "aspect_ratio"]],
  ["Medulla", ["kappa", "sigma_ms", "g", "sigma_ma", "medulla_air", "medulla_pigment", "exit"]],
  ["Cortex", ["sigma_ca"]],
];

const CHANNEL_NAMES = { r: "Red", g: "Green", b: "Blue" };

/** Short forms of units, for the eye alone. */
const SHORT_UNITS = { "1/radius": "1/r" };

/** The limits of a named colour. No fur reflects nothing or everything, and the cuticle reflects some white light. */
const NAMED = [0.01, 0.95];

/** The most steps of undo. */
const STEPS = 200;

/** Positions of a slider: 0 to SLIDER. */
const SLIDER = 1000;

/** A slider over a wide range gives small values most of its length: value = low + (high − low) t^power. */
function sliderPower([low, high]) {
  if (low < 0 || high <= 3) return 1;
  if (high > 100) return 5;
  return high === 100 ? 3 : 2;
}

function toSlider(value, range) {
  const t = (value - range[0]) / (range[1] - range[0]);
  return Math.round(SLIDER * Math.pow(Math.min(Math.max(t, 0), 1), 1 / sliderPower(range)));
}

function fromSlider(position, range) {
  const t = Math.pow(position / SLIDER, sliderPower(range));
  return tidy(Math.min(Math.max(range[0] + (range[1] - range[0]) * t, range[0]), range[1]));
}

/** A number with four significant digits. */
function tidy(x) {
  return Number(x.toPrecision(4));
}

/** An element with attributes and children. */
export function make(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value === true) element.setAttribute(key, "");
    else if (value !== false && value != null) element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
}

let lastId = 0;

/**
 * A labelled slider with a number field. `change(value, done)` is called while it moves, and with `done` at its end.
 * The result has `element`, `value` (get and set) and `enable(boolean)`.
 */
export function createSlider({ key, label, name, unit = "", range, title = "", change }) {
  const id = `vellus-${key}-${++lastId}`;
  const said = name ?? label;
  const slider = make("input", {
    type: "range", id, min: 0, max: SLIDER, step: 1, "aria-label": said, title, "data-key": key,
  });
  const field = make("input", {
    type: "number", min: range[0], max: range[1], step: "any", inputmode: "decimal", "data-number": key,
    "aria-label": `${said}${unit ? `, ${unit}` : ""}, from ${range[0]} to ${range[1]}`,
  });
  let current = range[0];
  const show = () => {
    slider.value = toSlider(current, range);
    slider.setAttribute("aria-valuetext", `${tidy(current)} ${unit}`.trim());
  };
  // Three digits of a small number fit the field.
  const write = () => (field.value = String(Math.abs(current) < 0.1 ? Number(current.toPrecision(3)) : tidy(current)));
  const moved = (done) => {
    current = fromSlider(Number(slider.value), range);
    slider.setAttribute("aria-valuetext", `${current} ${unit}`.trim());
    write();
    change(current, done);
  };
  slider.addEventListener("input", () => moved(false));
  slider.addEventListener("change", () => moved(true));
  field.addEventListener("change", () => {
    const typed = field.valueAsNumber;
    if (!Number.isFinite(typed)) return write();
    current = Math.min(Math.max(typed, range[0]), range[1]);
    show();
    // It stays as it was typed.
    field.value = String(current);
    change(current, true);
  });
  write();
  const element = make("div", { class: "vf-row" },
    make("label", { for: id, title, class: "vf-label" }, label), slider, field,
    make("span", { class: "vf-unit", "aria-hidden": "true", title: unit }, SHORT_UNITS[unit] ?? unit));
  return {
    element,
    get value() { return current; },
    set value(x) {
      // What was typed comes back in single precision.
      const changes = Math.fround(x) !== Math.fround(current);
      if (changes) current = x;
      show();
      if (changes && document.activeElement !== field) write();
    },
    enable(on) {
      slider.disabled = field.disabled = !on;
    },
  };
}

/** A colour in [0, 1], linear, as #rrggbb. */
export function toHex(rgb) {
  const encode = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * Math.pow(x, 1 / 2.4) - 0.055);
  const byte = (x) => Math.round(255 * encode(Math.min(Math.max(x, 0), 1)));
  return "#" + rgb.map((x) => byte(x).toString(16).padStart(2, "0")).join("");
}

function fromHex(hex) {
  const decode = (x) => (x <= 0.04045 ? x / 12.92 : Math.pow((x + 0.055) / 1.055, 2.4));
  return [1, 3, 5].map((i) => decode(parseInt(hex.slice(i, i + 2), 16) / 255));
}

/** An opaque colour of CSS, such as `red`, as `{ color }` in linear RGB, or an `error`. */
function namedColor(text) {
  const context = document.createElement("canvas").getContext("2d");
  if (CSS.supports("color", text)) context.fillStyle = text;
  const is = CSS.supports("color", text) && /^#[0-9a-f]{6}$/.test(context.fillStyle);
  return is ? { color: fromHex(context.fillStyle) }
    : { error: `${text} is no colour: write a name such as brown, or #rrggbb` };
}

/** The value of a parameter as an array of its channels. A fibre may have one number for all of them. */
function channelsOf(value, count) {
  return Array.isArray(value) ? value.slice() : Array(count).fill(value ?? 0);
}

/** Builds the panel in an element. */
export async function createFiberPanel(element, source, { fiber, onchange = () => {}, history = true } = {}) {
  element.classList.add("vellus", "vellus-panel");
  const table = await source.ask({ ask: "parameters" });
  if (table.error) throw new Error(table.error);
  const rows = new Map(table.parameters.map((row) => [row.key, row]));
  const stored = table.parameters.filter((row) => row.is_stored);
  const start = await source.ask({ ask: "check", fiber: fiber ?? table.base });
  if (start.error) throw new Error(start.error);

  // A look is a fibre and the melanin that its colour came from. A state is never changed, only replaced.
  const first = { fiber: start.fiber, melanin: channelsOf(fiber?.melanin, 2), preset: "" };
  let state = { A: first, B: first, active: "A" };
  let past = [];
  let future = [];
  // The state before a slider began to move.
  let before = null;

  const message = make("p", { class: "vf-message", role: "status", "aria-live": "polite" });
  const sliders = new Map();
  const linked = new Map();
  const choices = new Map();
  const active = () => state[state.active];
  const other = () => state[state.active === "A" ? "B" : "A"];

  function announce(done) {
    onchange(active().fiber, { look: state.active, other: other().fiber, done });
    askCoat();
  }

  /** Replaces the state. A finished change is one step of undo. */
  function replace(next, done) {
    before ??= state;
    state = next;
    if (done) {
      if (history) past = [...past, before].slice(-STEPS);
      future = [];
      before = null;
    }
    refresh();
    announce(done);
  }

  function change(part, done) {
    replace({ ...state, [state.active]: { ...active(), ...part } }, done);
  }

  function step(from, to) {
    if (from.length === 0) return;
    to.push(state);
    state = from.pop();
    before = null;
    refresh();
    announce(true);
  }

  const undo = () => step(past, future);
  const redo = () => step(future, past);

  // The newest request for the coat's colour or for a new colour is answered; older ones that wait are dropped.
  let waiting = null;
  let busy = false;
  async function later(work) {
    waiting = work;
    if (busy) return;
    busy = true;
    while (waiting) {
      const next = waiting;
      waiting = null;
      try {
        await next();
      } catch (error) {
        message.textContent = String(error.message ?? error);
      }
    }
    busy = false;
  }

  function showCoat(answer) {
    swatch.style.background = toHex(answer.coat);
    swatch.title = `Colour of a dense coat: ${answer.coat.map((x) => x.toFixed(3)).join(", ")}`;
    // The colour that was asked for stays, also if no pigment reaches it: the message says so.
    const asked = channelsOf(active().fiber.reflectance ?? answer.coat, 3);
    reflectance.forEach((slider, i) => (slider.value = asked[i]));
    picker.value = toHex(asked);
    message.textContent = answer.note ?? "";
  }

  function askCoat() {
    const asked = active().fiber;
    later(async () => {
      const answer = await source.ask({ ask: "check", fiber: asked });
      if (answer.error) message.textContent = answer.error;
      else if (asked === active().fiber) showCoat({ ...answer, note: active().note });
    });
  }

  function askColor(request, part, done) {
    const base = active().fiber;
    later(async () => {
      const answer = await source.ask({ ask: "color", fiber: base, ...request });
      if (answer.error) message.textContent = answer.error;
      else change({ fiber: answer.fiber, note: answer.note, preset: "", ...part }, done);
    });
  }

  function setChannel(row, channel, value, done) {
    const values = channelsOf(active().fiber[row.key], row.channels.length || 1);
    if (row.channels.length === 0) values[0] = value;
    else if (linked.get(row.key)?.checked) values.fill(value);
    else values[channel] = value;
    const changed = { ...active().fiber, [row.key]: row.channels.length ? values : values[0] };
    // Absorption by hand replaces the reflectance that it came from.
    if (row.key === "sigma_ca" || row.key === "sigma_ma") delete changed.reflectance;
    change({ fiber: changed, preset: "", note: null }, done);
  }

  /** The controls of a parameter: a list of choices, or sliders. */
  function rowOf(row) {
    const title = `${row.symbol}: ${row.description}`;
    if (row.choices.length > 0) {
      const list = make("select", { "data-key": row.key, "aria-label": row.label, title },
        ...row.choices.map((word) => make("option", { value: word }, word)));
      list.addEventListener("change", () =>
        change({ fiber: { ...active().fiber, [row.key]: list.value }, preset: "" }, true));
      choices.set(row.key, list);
      return [make("label", { class: "vf-wide" }, `${row.label} `, list)];
    }
    if (row.channels.length === 0) {
      const slider = createSlider({
        ...row, label: row.label, title, name: `${row.label}, ${row.key}`,
        change: (x, done) => setChannel(row, 0, x, done),
      });
      sliders.set(row.key, [slider]);
      return [slider.element];
    }
    const link = make("input", { type: "checkbox", checked: true, "data-link": row.key,
      "aria-label": `${row.label}: one value for all channels` });
    linked.set(row.key, link);
    const list = row.channels.map((channel, i) => {
      const short = channel.split(".").pop();
      return createSlider({
        key: channel, label: CHANNEL_NAMES[short] ?? short, title, unit: row.unit, range: row.range,
        name: `${row.label}, ${CHANNEL_NAMES[short] ?? short}`, change: (x, done) => setChannel(row, i, x, done),
      });
    });
    sliders.set(row.key, list);
    const head = make("div", { class: "vf-head", title }, make("span", {}, row.label),
      make("label", {}, link, " linked"));
    return [head, ...list.map((slider) => slider.element)];
  }

  function group(name, ...children) {
    return make("fieldset", {}, make("legend", {}, name), ...children);
  }

  // Looks, undo, presets.
  const radio = (key) => {
    const input = make("input", { type: "radio", name: `vellus-look-${++lastId}`, value: key, "data-look": key });
    input.addEventListener("change", () => select(key));
    return input;
  };
  const radios = { A: radio("A"), B: radio("B") };
  radios.B.name = radios.A.name;
  const button = (label, title, click, key) =>
    make("button", { type: "button", title, onclick: click, "data-action": key }, label);
  const undoButton = button("Undo", "Undo (Ctrl+Z)", undo, "undo");
  const redoButton = button("Redo", "Redo (Ctrl+Y)", redo, "redo");
  const copyButton = button("A → B", "", copy, "copy");
  const resetButton = button("Reset", "The fibre that the panel began with", () => replace(
    { ...state, [state.active]: first }, true), "reset");
  const options = table.presets.flatMap((preset) => [
    make("option", { value: preset.key }, preset.label),
    make("option", { value: `${preset.key}-published` }, `${preset.label}, as published`),
  ]);
  const presets = make("select", { "data-key": "preset", "aria-label": "Preset" },
    make("option", { value: "" }, "Choose a species"), ...options);
  presets.addEventListener("change", () => {
    const [key, published] = [presets.value.replace(/-published$/, ""), presets.value.endsWith("-published")];
    const found = table.presets.find((preset) => preset.key === key);
    if (found) {
      change({ fiber: published ? found.published : found.fiber, melanin: [0, 0], preset: presets.value, note: null },
        true);
    }
  });

  // Colours.
  const swatch = make("span", { class: "vf-swatch", role: "img", "aria-label": "Colour of a dense coat" });
  const picker = make("input", { type: "color", "data-key": "picker", "aria-label": "Colour of a dense coat" });
  const range = rows.get("reflectance").range;
  const setReflectance = (rgb, done) => askColor(
    { reflectance: rgb.map((x) => Math.min(Math.max(x, range[0]), range[1])) }, { melanin: [0, 0] }, done);
  picker.addEventListener("change", () => setReflectance(fromHex(picker.value), true));
  const word = make("input", { type: "text", class: "vf-word", "data-key": "color-name", size: 10,
    placeholder: "red, #a52a2a", title: "A name or #rrggbb, then Enter", "aria-label": "Coat colour by name",
    spellcheck: "false" });
  word.addEventListener("change", () => {
    const typed = word.value.trim();
    if (typed) later(async () => {
      const answer = await (source.color ? source.color(typed) : namedColor(typed));
      if (answer.error) message.textContent = answer.error;
      else setReflectance(answer.color.map((x) => Math.min(Math.max(x, NAMED[0]), NAMED[1])), true);
    });
  });
  const reflectance = rows.get("reflectance").channels.map((channel) => {
    const short = CHANNEL_NAMES[channel.split(".").pop()];
    return createSlider({
      key: channel, label: short, name: `Coat colour, ${short}`, range, title: rows.get("reflectance").description,
      change: (_, done) => setReflectance(reflectance.map((slider) => slider.value), done),
    });
  });
  const melanin = rows.get("melanin").channels.map((channel) => createSlider({
    key: channel, label: channel[0].toUpperCase() + channel.slice(1), range: rows.get("melanin").range,
    title: rows.get("melanin").description,
    change: (_, done) => {
      const value = melanin.map((slider) => slider.value);
      askColor({ melanin: value }, { melanin: value }, done);
    },
  }));

  const named = new Set(PANEL_GROUPS.flatMap(([, keys]) => keys));
  const extra = stored.filter((row) => !named.has(row.key));
  element.replaceChildren(
    make("div", { class: "vf-bar" }, ...(history ? [
      make("span", { class: "vf-looks", role: "radiogroup", "aria-label": "Look" },
        make("label", {}, radios.A, "Look A"), make("label", {}, radios.B, "Look B")),
      copyButton, make("span", { class: "vf-space" }), undoButton, redoButton, resetButton] : [])),
    make("div", { class: "vf-wide" }, make("label", {}, "Preset ", presets), history ? "" : resetButton, swatch),
    message,
    group("Colour",
      make("div", { class: "vf-head" }, make("span", {}, "Coat colour"), word, picker),
      ...reflectance.map((slider) => slider.element),
      make("div", { class: "vf-head" }, make("span", {}, "Melanin")),
      ...melanin.map((slider) => slider.element)),
    ...PANEL_GROUPS.map(([name, keys]) => group(name, ...keys.filter((key) => rows.has(key)).flatMap(
      (key) => rowOf(rows.get(key))))),
    ...extra.flatMap(rowOf),
  );
  element.addEventListener("keydown", (event) => {
    if (!history || !(event.ctrlKey || event.metaKey) || event.altKey) return;
    const key = event.key.toLowerCase();
    const back = key === "z" && !event.shiftKey;
    if (!back && key !== "y" && key !== "z") return;
    event.preventDefault();
    if (back) undo();
    else redo();
  });

  function select(key) {
    if (key !== state.active) replace({ ...state, active: key }, true);
  }

  function copy() {
    replace({ ...state, [state.active === "A" ? "B" : "A"]: active() }, true);
  }

  /** Shows the state in all controls. */
  function refresh() {
    const { fiber: shown, melanin: pigments, preset } = active();
    for (const [key, list] of choices) list.value = shown[key];
    for (const row of stored.filter((row) => row.choices.length === 0)) {
      const values = channelsOf(shown[row.key], row.channels.length || 1);
      sliders.get(row.key)?.forEach((slider, i) => (slider.value = values[i]));
      const link = linked.get(row.key);
      if (link && values.some((x) => x !== values[0])) link.checked = false;
    }
    melanin.forEach((slider, i) => (slider.value = pigments[i]));
    presets.value = preset;
    radios[state.active].checked = true;
    const to = state.active === "A" ? "B" : "A";
    copyButton.textContent = `${state.active} → ${to}`;
    copyButton.title = `Copy look ${state.active} to look ${to}`;
    copyButton.setAttribute("aria-label", copyButton.title);
    undoButton.disabled = past.length === 0;
    redoButton.disabled = future.length === 0;
    element.dataset.look = state.active;
  }

  refresh();
  showCoat(start);
  return {
    get fiber() { return active().fiber; },
    get other() { return other().fiber; },
    get look() { return state.active; },
    async set(next) {
      const answer = await source.ask({ ask: "check", fiber: next });
      if (answer.error) message.textContent = answer.error;
      else change({ fiber: answer.fiber, note: answer.note, melanin: [0, 0], preset: "" }, true);
    },
    undo, redo, select,
  };
}
