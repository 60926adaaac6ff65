// Small controls: a slider with a number, a check box, buttons, and panels.

let count = 0;

export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") made.textContent = value;
    else if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== false) made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children);
  return made;
}

// A number as people write it: the server's single precision has six digits.
const text = (x) => String(Number(Number(x).toPrecision(6)));

// A slider and a number for one value. `log` spaces the slider by factors. `set` shows a value without a change. The
// slider moves by steps. A typed number stays as it is, unless it is out of range, or the value is a `whole` number.
export function slider({ label, min, max, step, unit = "", log = false, whole = false, hint = "", change }) {
  const id = `control-${++count}`;
  const to = log ? Math.log : (x) => x;
  const from = log ? Math.exp : (x) => x;
  const digits = Math.max(0, Math.ceil(-Math.log10(step)));
  const limit = (x) => Math.min(max, Math.max(min, whole ? Math.round(x) : x));
  const round = (x) => limit(Number(x.toFixed(digits)));
  let current = min;
  const range = element("input", {
    type: "range", min: to(min), max: to(max), step: log ? "any" : step, "aria-labelledby": id,
  });
  const number = element("input", { type: "number", min, max, step, "aria-labelledby": id });
  const show = (x) => {
    current = x;
    if (document.activeElement !== number) number.value = text(x);
    range.value = to(x);
    range.setAttribute("aria-valuetext", `${text(x)} ${unit}`.trim());
  };
  range.addEventListener("input", () => {
    current = round(from(Number(range.value)));
    number.value = text(current);
    change(current);
  });
  number.addEventListener("change", () => {
    if (Number.isFinite(number.valueAsNumber)) {
      current = limit(number.valueAsNumber);
      range.value = to(current);
      change(current);
    }
    number.value = String(current);
  });
  const row = element("div", { class: "row", title: hint },
    element("label", { id, text: label }), range, number, element("span", { class: "unit", text: unit }));
  const busy = () => document.activeElement === range && range.matches(":active");
  return { row, set: (x) => busy() || show(x), get: () => Number(number.value), disable: (off) => {
    range.disabled = off;
    number.disabled = off;
  } };
}

// A name with its control characters, and those that change the direction of text, as numbers.
export function plain(name) {
  return name.replace(/[\p{Cc}\p{Cf}\u2028\u2029]/gu, (c) => `\\u{${c.codePointAt(0).toString(16)}}`);
}

export function check({ label, hint = "", change }) {
  const input = element("input", { type: "checkbox", onchange: () => change(input.checked) });
  const row = element("label", { class: "line", title: hint }, input, label);
  return { row, set: (on) => { input.checked = on; }, get: () => input.checked };
}

export function button(text, onclick, hint = "") {
  return element("button", { type: "button", text, onclick, title: hint });
}

// A panel that can be closed. It remembers whether it is open.
export function panel(title, open, ...children) {
  const key = `vellus-panel-${title}`;
  const stored = localStorage.getItem(key);
  const details = element("details", { open: stored === null ? open : stored === "1" },
    element("summary", { text: title }), element("div", { class: "body" }, ...children));
  details.dataset.short = title.split(" ")[0];
  details.addEventListener("toggle", () => localStorage.setItem(key, details.open ? "1" : "0"));
  return details;
}

export const facts = (pairs) => pairs.flatMap(([name, value]) =>
  [element("dt", { text: name }), element("dd", { text: value })]);
