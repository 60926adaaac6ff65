// Connects the picture, the panels and the bars.

import { Connection } from "./connection.js";
import { element } from "./controls.js";
import { Panels } from "./panels.js";
import { Viewport } from "./viewport.js";

const $ = (id) => document.getElementById(id);
const connection = new Connection();
const viewport = new Viewport(connection);
const panels = new Panels($("panels"), connection, viewport);
let state = null;

function say(text, bad = false) {
  panels.say(text, bad);
}

const press = (button, on) => button.setAttribute("aria-pressed", String(on));

connection.addEventListener("online", () => { $("offline").hidden = true; });
connection.addEventListener("offline", () => { $("offline").hidden = false; });
connection.addEventListener("problem", ({ detail }) => say(detail, true));
connection.addEventListener("state", ({ detail }) => {
  const note = state?.note;
  const told = state?.warnings.join("\n") ?? "";
  state = detail;
  $("scene").textContent = state.scene;
  $("scene").title = [state.summary, ...state.warnings].join("\n");
  document.title = `${state.scene} – Vellus live`;
  $("busy").hidden = !state.busy;
  $("busy").textContent = state.busy ? `${state.busy} …` : "";
  press($("pause"), state.paused);
  press($("denoise"), state.denoise);
  $("denoise").disabled = Boolean(state.no_denoiser);
  $("denoise").title = state.no_denoiser ?? "Clean the picture (N)";
  if (!$("exposure").matches(":active") && !connection.merged.has("exposure")) {
    wanted = state.exposure;
    $("exposure").value = wanted;
    $("stops").textContent = wanted.toFixed(2);
  }
  $("undo").disabled = !state.can_undo;
  $("redo").disabled = !state.can_redo;
  const names = ["A", "B"];
  names.forEach((name, i) => {
    press($(name.toLowerCase()), state.version === i);
    const model = i === state.version ? state.model : state.other.model;
    $(name.toLowerCase()).title = `Version ${name} of fibres, model, groom and lights: ${model} (V)`;
  });
  const [from, to] = state.version === 0 ? names : [...names].reverse();
  $("copy").textContent = `${from} → ${to}`;
  $("copy").title = `Copy version ${from} to version ${to}`;
  viewport.setSize(state.size, state.crop);
  press($("crop"), Boolean(state.crop) || viewport.mode === "crop");
  panels.update(state);
  if (state.warnings.length && state.warnings.join("\n") !== told) {
    const more = state.warnings.length > 1 ? ` (and ${state.warnings.length - 1} more: see the scene's name)` : "";
    say(`${state.warnings[0]}${more}`, true);
  }
  if (state.note && state.note !== note) say(state.note, true);
});

viewport.addEventListener("frame", ({ detail }) => {
  const facts = [
    ["Samples", `${detail.samples} / ${state?.target ?? "?"}`],
    ["Pixels", detail.coarse === 1 ? "full" : `1/${detail.coarse}`],
    ["Noise", detail.noise === null ? "–" : `${(100 * detail.noise).toFixed(2)} %`],
    ["Mrays/s", detail.mrays.toFixed(2)],
    ["Response", viewport.latency ? `${viewport.latency.toFixed(0)} ms` : "–"],
    ["Picture", detail.done ? "done" : state?.paused ? "paused" : "refining"],
  ];
  if (detail.latency > 0) viewport.latency = detail.latency;
  $("facts").replaceChildren(...facts.map(([name, value]) => element("div", {},
    element("dt", { text: name }), element("dd", { text: value }))));
  document.documentElement.dataset.frame = detail.frame;
  document.documentElement.dataset.coarse = detail.coarse;
  document.documentElement.dataset.samples = detail.samples;
  document.documentElement.dataset.denoised = detail.denoised;
});

const actions = {
  pause: () => connection.send({ type: "pause", on: !state.paused }),
  home: () => connection.send({ type: "home" }),
  pick: () => viewport.setMode(viewport.mode === "pick" ? "move" : "pick"),
  crop: () => {
    if (state.crop) connection.send({ type: "crop", area: null });
    else viewport.setMode(viewport.mode === "crop" ? "move" : "crop");
  },
  denoise: () => $("denoise").disabled || connection.send({ type: "denoise", on: !state.denoise }),
  undo: () => $("undo").disabled || connection.send({ type: "undo" }),
  redo: () => $("redo").disabled || connection.send({ type: "redo" }),
  a: () => connection.send({ type: "version", index: 0 }),
  b: () => connection.send({ type: "version", index: 1 }),
  copy: () => connection.send({ type: "copy-version" }),
  help: () => {
    $("keys").hidden = !$("keys").hidden;
    $("help").setAttribute("aria-expanded", String(!$("keys").hidden));
  },
  theme: () => {
    const theme = document.documentElement.dataset.theme === "light" ? "dark" : "light";
    localStorage.setItem("vellus-theme", theme);
    document.documentElement.dataset.theme = theme;
  },
};
for (const [id, action] of Object.entries(actions)) $(id).addEventListener("click", () => state && action());
viewport.addEventListener("mode", ({ detail }) => {
  press($("pick"), detail === "pick");
  press($("crop"), detail === "crop" || Boolean(state?.crop));
});

// The exposure that this page wants: several keys may come before the server has answered the first.
let wanted = 0;
const expose = (stops) => {
  const limited = Math.min(20, Math.max(-20, stops));
  wanted = limited;
  $("stops").textContent = limited.toFixed(2);
  connection.stream("exposure", { type: "exposure", stops: limited });
};
$("exposure").addEventListener("input", () => expose(Number($("exposure").value)));

document.addEventListener("keydown", (event) => {
  // A text field has an undo of its own.
  const typing = event.target.matches("input:not([type=range]):not([type=checkbox]), textarea");
  if (!state || typing || event.altKey) return;
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) {
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    if (key === "z" && !event.shiftKey) actions.undo();
    else actions.redo();
    return;
  }
  if (event.target.matches("select")) return;
  const keys = {
    p: actions.pause, h: actions.home, i: actions.pick, c: actions.crop, n: actions.denoise, "?": actions.help,
    v: () => connection.send({ type: "version", index: 1 - state.version }),
    f: () => viewport.focus({ x: 0.5, y: 0.5 }),
    "[": () => expose(wanted - 0.25), "]": () => expose(wanted + 0.25),
    Escape: () => {
      if (!$("keys").hidden) {
        actions.help();
        return;
      }
      viewport.setMode("move");
      viewport.setMark(null);
      if (state.crop) connection.send({ type: "crop", area: null });
    },
  };
  keys[event.key]?.();
});

for (const type of ["dragenter", "dragover"]) {
  addEventListener(type, (event) => {
    event.preventDefault();
    document.body.classList.add("drop");
  });
}
addEventListener("dragleave", (event) => event.relatedTarget || document.body.classList.remove("drop"));
addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("drop");
  const file = event.dataTransfer.files[0];
  if (file) panels.load(file);
});

const preferred = matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark";
document.documentElement.dataset.theme = localStorage.getItem("vellus-theme") ?? preferred;
