// The views of a fibre: cross-section with traced rays, lobes around and along it, θ–φ profile, energy by lobe.
//
// Use:
//   import { createFiberViews } from "./fiber-views.js";
//   const views = createFiberViews(element, source, { controls: true, onlight });
//   views.show(fiber, { theta, h, other });
//
// `source` is that of fiber-panel.js. `theta` is the inclination of the light in degrees, in [−89, 89]; `h` is the
// offset in [−1, 1]; `whole: true` averages the lobes over the width. `other` is a second fibre or null: its totals
// are drawn as dashed lines. Fields that are left out keep their values. `show` returns a promise that ends when the
// newest views are drawn. With `controls`, sliders for θ and h are above the views, and the cross-section can be
// dragged; `onlight({ theta, h, whole })` is called when the user moves them. The element gets the class
// `vellus-views`.

import { createSlider, make } from "./fiber-panel.js";

/** The names of the lobes on the page, and the class of their colour. */
const LOBE_NAMES = ["R", "TT", "TRT", "TTˢ", "TRTˢ", "rest"];

/** The radius of the fibre in the cross-section, which is 320 wide. */
const SECTION_RADIUS = 102;

/** Decades that the picture of the profile spans. */
const DECADES = 3.5;

const SVG = "http://www.w3.org/2000/svg";

/** An SVG element with attributes, and text or children. */
function draw(name, attributes = {}, ...children) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

const mean = (rgb) => (rgb[0] + rgb[1] + rgb[2]) / 3;
const fixed = (x) => x.toFixed(1);
const line = (points) => points.map(([x, y]) => `${fixed(x)},${fixed(y)}`).join(" ");

/** The total of the lobes at one sample. */
function totalAt(lobes, i) {
  return lobes.reduce((sum, lobe) => sum + mean(lobe[i]), 0);
}

/** The rays through the cross-section. The light comes from the right. */
function drawSection(svg, answer) {
  const [size, middle] = [SECTION_RADIUS, 160];
  const at = ([y, z]) => [middle + size * y, middle - size * z];
  const shapes = [
    draw("circle", { cx: middle, cy: middle, r: size, class: "vv-cortex" }),
    draw("circle", { cx: middle, cy: middle, r: size * answer.medulla, class: "vv-medulla" }),
  ];
  const largest = Math.max(1e-9, ...answer.rays.map((ray) => mean(ray.weight)));
  const brightest = Math.max(1e-9, ...answer.scattered.map((path) => mean(path.weight)));
  for (const path of answer.scattered) {
    const opacity = 0.25 + 0.6 * Math.sqrt(mean(path.weight) / brightest);
    const points = line(path.points.slice(1).map(at));
    shapes.push(draw("polyline", { points, class: "vv-ray vv-lobe3 vv-thin", "stroke-opacity": opacity.toFixed(2) }));
  }
  // The weakest first, so that strong rays lie above.
  for (const [i, ray] of [...answer.rays.entries()].reverse()) {
    const share = Math.sqrt(mean(ray.weight) / largest);
    const points = ray.points.map(at);
    const style = { class: `vv-ray vv-lobe${i}`, "stroke-opacity": (0.3 + 0.7 * share).toFixed(2),
      "stroke-width": (1 + 2.5 * share).toFixed(2) };
    shapes.push(draw("polyline", { points: line(points.slice(1)), ...style, "marker-end": `url(#vv-arrow${i})` }));
    const [a, b] = points.slice(-2);
    const [x, y] = [b[0] + 0.22 * (b[0] - a[0]), b[1] + 0.22 * (b[1] - a[1])];
    const text = `${ray.lobe} ${(100 * mean(ray.weight)).toFixed(1)} %`;
    // Beside a flat arrow, the text is above or below it.
    const isFlat = Math.abs(b[0] - a[0]) > Math.abs(b[1] - a[1]);
    const down = isFlat ? (b[1] <= a[1] ? -8 : 16) : 4;
    const anchor = x < middle - 40 ? "start" : x > middle + 40 ? "end" : "middle";
    shapes.push(draw("text", { x: fixed(Math.min(Math.max(x, 4), 316)), y: fixed(Math.min(Math.max(y + down, 12), 314)),
      "text-anchor": anchor, class: `vv-tag vv-text${i}` }, text));
  }
  const incoming = answer.rays[0].points.slice(0, 2).map(at);
  const from = [316, incoming[0][1]];
  shapes.push(draw("polyline", { points: line([from, incoming[1]]), class: "vv-light" }));
  const arrow = (i) => draw("marker", { id: `vv-arrow${i}`, viewBox: "0 0 8 8", refX: 6, refY: 4, markerWidth: 8,
    markerHeight: 8, orient: "auto", markerUnits: "userSpaceOnUse" },
    draw("path", { d: "M0,0 L8,4 L0,8 z", class: `vv-fill${i}` }));
  svg.replaceChildren(draw("defs", {}, ...[0, 1, 2].map(arrow)), ...shapes);
}

/** The lobes around the fibre. The radius is the square root of N, so that areas show shares of the light. */
function drawPolar(svg, answer, other) {
  const [size, middle] = [124, 160];
  const totals = answer.phi.map((_, i) => totalAt(answer.lobes, i));
  const otherTotals = other ? other.phi.map((_, i) => totalAt(other.lobes, i)) : [];
  const largest = Math.max(1e-9, ...totals, ...otherTotals);
  const at = (degrees, share) => {
    const [angle, radius] = [(degrees * Math.PI) / 180, size * Math.sqrt(Math.max(share, 0))];
    return [middle + radius * Math.cos(angle), middle - radius * Math.sin(angle)];
  };
  const shapes = [0.1, 0.5, 1].map((share) =>
    draw("circle", { cx: middle, cy: middle, r: fixed(size * Math.sqrt(share)), class: "vv-grid" }));
  for (let degrees = 0; degrees < 360; degrees += 45) {
    const [[x, y], [tx, ty]] = [at(degrees, 1), at(degrees, 1.26)];
    shapes.push(draw("line", { x1: middle, y1: middle, x2: fixed(x), y2: fixed(y), class: "vv-grid" }));
    const shown = degrees > 180 ? degrees - 360 : degrees;
    shapes.push(draw("text", { x: fixed(tx), y: fixed(ty + 4), "text-anchor": "middle", class: "vv-axis" },
      `${shown}°`.replace("-", "−")));
  }
  answer.lobes.forEach((lobe, i) => {
    const points = lobe.map((rgb, j) => at(answer.phi[j], mean(rgb) / largest));
    shapes.push(draw("polygon", { points: line(points), class: `vv-shape vv-lobe${i} vv-wash${i}` }));
  });
  const outline = (answer, totals, kind) =>
    draw("polygon", { points: line(totals.map((x, j) => at(answer.phi[j], x / largest))), class: kind });
  shapes.push(outline(answer, totals, "vv-total"));
  if (other) shapes.push(outline(other, otherTotals, "vv-total vv-other"));
  shapes.push(draw("text", { x: 4, y: 314, class: "vv-axis" }, `outer circle: ${largest.toPrecision(2)} per radian`));
  svg.replaceChildren(...shapes);
}

/** The lobes along the fibre. The height is the square root, so that weak lobes are visible. */
function drawLongitudinal(svg, answer, other, theta) {
  const [left, right, top, bottom] = [16, 304, 12, 232];
  const totals = answer.theta_i.map((_, i) => totalAt(answer.lobes, i));
  const otherTotals = other ? other.theta_i.map((_, i) => totalAt(other.lobes, i)) : [];
  const largest = Math.max(1e-9, ...totals, ...otherTotals);
  const x = (theta) => left + ((theta + 90) / 180) * (right - left);
  const y = (value) => bottom - Math.sqrt(Math.max(value, 0) / largest) * (bottom - top);
  const shapes = [];
  for (const share of [0, 0.1, 0.5, 1]) {
    const height = y(share * largest);
    shapes.push(draw("line", { x1: left, x2: right, y1: height, y2: height, class: "vv-grid" }));
  }
  for (const degrees of [-90, -45, 0, 45, 90]) {
    shapes.push(draw("line", { x1: x(degrees), x2: x(degrees), y1: top, y2: bottom, class: "vv-grid" }));
    shapes.push(draw("text", { x: x(degrees), y: bottom + 16, "text-anchor": "middle", class: "vv-axis" },
      `${degrees}°`.replace("-", "−")));
  }
  const points = (values) => values.map((value, i) => [x(answer.theta_i[i]), y(value)]);
  answer.lobes.forEach((lobe, i) => {
    const ends = [[x(90), bottom], [x(-90), bottom]];
    shapes.push(draw("polygon", { points: line([...points(lobe.map(mean)), ...ends]),
      class: `vv-shape vv-lobe${i} vv-wash${i}` }));
  });
  shapes.push(draw("polyline", { points: line(points(totals)), class: "vv-total" }));
  if (other) shapes.push(draw("polyline", { points: line(points(otherTotals)), class: "vv-total vv-other" }));
  // A mirror would reflect the light here.
  shapes.push(draw("line", { x1: x(-theta), x2: x(-theta), y1: top, y2: bottom, class: "vv-mark" }));
  shapes.push(draw("text", { x: 4, y: 268, class: "vv-axis" },
    `top: ${largest.toPrecision(2)} per radian; dotted: the mirror direction`));
  svg.replaceChildren(...shapes);
}

/** The energies of the lobes over the offset, one above the other. */
function drawEnergy(svg, answer, other, h) {
  const [left, right, top, bottom] = [40, 312, 12, 232];
  const x = (h) => left + ((h + 1) / 2) * (right - left);
  const y = (share) => bottom - Math.min(share, 1) * (bottom - top);
  const shapes = [];
  const below = answer.h.map(() => 0);
  answer.lobes.forEach((lobe, i) => {
    const lower = answer.h.map((h, j) => [x(h), y(below[j])]).reverse();
    lobe.forEach((rgb, j) => (below[j] += mean(rgb)));
    const upper = answer.h.map((h, j) => [x(h), y(below[j])]);
    shapes.push(draw("polygon", { points: line([...upper, ...lower]), class: `vv-fill${i}` }));
  });
  if (other) {
    const points = other.h.map((h, j) => [x(h), y(totalAt(other.lobes, j))]);
    shapes.push(draw("polyline", { points: line(points), class: "vv-total vv-other" }));
  }
  for (const share of [0, 0.25, 0.5, 0.75, 1]) {
    shapes.push(draw("line", { x1: left, x2: right, y1: y(share), y2: y(share), class: "vv-grid" }));
    shapes.push(draw("text", { x: left - 6, y: y(share) + 4, "text-anchor": "end", class: "vv-axis" },
      `${100 * share} %`));
  }
  for (const offset of [-1, -0.5, 0, 0.5, 1]) {
    shapes.push(draw("text", { x: x(offset), y: bottom + 16, "text-anchor": "middle", class: "vv-axis" },
      String(offset).replace("-", "−")));
  }
  shapes.push(draw("text", { x: (left + right) / 2, y: bottom + 32, "text-anchor": "middle", class: "vv-axis" },
    "offset h"));
  shapes.push(draw("line", { x1: x(h), x2: x(h), y1: top, y2: bottom, class: "vv-mark" }));
  svg.replaceChildren(...shapes);
}

/** The profile: θ_i upwards, φ to the right. Brightness is the logarithm of the largest channel; the hue is kept. */
function drawProfile(canvas, answer) {
  const { rows, columns, values } = answer;
  [canvas.width, canvas.height] = [columns, rows];
  const context = canvas.getContext("2d");
  const image = context.createImageData(columns, rows);
  const largest = values.reduce((most, rgb) => Math.max(most, ...rgb), 1e-12);
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const rgb = values[row * columns + column];
      const most = Math.max(...rgb, 1e-30);
      const shade = Math.min(Math.max(1 + Math.log10(most / largest) / DECADES, 0), 1);
      const place = 4 * ((rows - 1 - row) * columns + column);
      for (let c = 0; c < 3; c++) image.data[place + c] = 255 * shade * Math.pow(rgb[c] / most, 1 / 2.2);
      image.data[place + 3] = 255;
    }
  }
  context.putImageData(image, 0, 0);
  return largest;
}

/** The table of energies, averaged over the width. */
function tableOf(answer, other) {
  const percent = (x) => (100 * x).toFixed(1);
  const cell = (x) => make("td", {}, percent(x));
  const row = (name, rgb, kind, more) => make("tr", {},
    make("th", { scope: "row" }, make("span", { class: `vv-key ${kind}` }), name), ...rgb.map(cell),
    ...(other ? [cell(mean(more))] : []));
  const rest = (total) => total.map((x) => Math.max(1 - x, 0));
  return make("table", { class: "vv-table" },
    make("thead", {}, make("tr", {}, ...["Lobe", "Red", "Green", "Blue", ...(other ? ["Other look"] : [])].map(
      (name) => make("th", { scope: "col" }, name)))),
    make("tbody", {}, ...LOBE_NAMES.map((name, i) => row(name, answer.mean[i], `vv-back${i}`, other?.mean[i])),
      row("Total", answer.total, "", other?.total),
      row("Absorbed", rest(answer.total), "", other && rest(other.total))));
}

/** Builds the views in an element. */
export function createFiberViews(element, source, { controls = true, onlight = () => {} } = {}) {
  element.classList.add("vellus", "vellus-views");
  const section = draw("svg", { viewBox: "0 0 320 320", role: "img", "data-view": "section" });
  const polar = draw("svg", { viewBox: "0 0 320 320", role: "img", "data-view": "polar" });
  const along = draw("svg", { viewBox: "0 0 320 272", role: "img", "data-view": "longitudinal" });
  const energy = draw("svg", { viewBox: "0 0 320 272", role: "img", "data-view": "energy" });
  const canvas = make("canvas", { role: "img", "data-view": "profile" });
  const scale = make("p", { class: "vv-note" });
  const table = make("div", { class: "vv-energies" });
  const message = make("p", { class: "vf-message", role: "status", "aria-live": "polite" });
  const figure = (title, note, ...children) =>
    make("figure", { class: "vv-view" }, make("figcaption", {}, make("strong", {}, title), " ", note), ...children);
  const axis = (text, kind) => make("span", { class: `vv-axis ${kind}`, "aria-hidden": "true" }, text);
  const light = { theta: 0, h: 0.3, whole: false };
  let [fiber, other] = [null, null];

  const moved = (part) => {
    Object.assign(light, part);
    onlight({ ...light });
    if (fiber) show(fiber);
  };
  const sliders = {
    theta: createSlider({ key: "theta", label: "Inclination θ", name: "Inclination of the light", unit: "°",
      range: [-89, 89], title: "Inclination of the light from the normal plane", change: (theta) => moved({ theta }) }),
    h: createSlider({ key: "h", label: "Offset h", name: "Offset of the light", range: [-1, 1],
      title: "Where the light meets the fibre: 0 is the middle, ±1 the edges", change: (h) => moved({ h }) }),
  };
  const whole = make("input", { type: "checkbox", "data-key": "whole" });
  whole.addEventListener("change", () => moved({ whole: whole.checked }));
  const bar = make("div", { class: "vv-bar" }, sliders.theta.element, sliders.h.element,
    make("label", { class: "vf-check" }, whole, " Lobes and profile over the whole width"));
  const legend = make("ul", { class: "vv-legend", "aria-label": "Lobes" }, ...LOBE_NAMES.map((name, i) =>
    make("li", {}, make("span", { class: `vv-key vv-back${i}` }), name)));
  element.replaceChildren(...(controls ? [bar] : []), legend, message,
    make("div", { class: "vv-grid-of-views" },
      figure("Cross-section", "light from the right; drag to move it", section),
      figure("Lobes around the fibre", "N(φ), radius as its square root", polar),
      figure("Lobes along the fibre", "height as the square root", along),
      figure("Profile", "reflected light by direction, logarithmic",
        make("div", { class: "vv-profile" }, axis("θ", "vv-theta"), axis("90°", "vv-top"),
          axis("−90°", "vv-bottom"), canvas, axis("φ = 0°", "vv-left"), axis("180°", "vv-middle"), axis("360°", "vv-right")), scale),
      figure("Energy by lobe", "over the offset; blank is absorbed", energy),
      figure("Energy in numbers", "mean over the width, in per cent", table)));

  function drag(event) {
    if (!controls || event.buttons === 0) return;
    const box = section.getBoundingClientRect();
    // The light at the height z has the offset −z.
    const z = ((0.5 - (event.clientY - box.top) / box.height) * 320) / SECTION_RADIUS;
    moved({ h: Number(Math.min(Math.max(-z, -1), 1).toFixed(3)) });
  }
  section.addEventListener("pointerdown", (event) => {
    section.setPointerCapture(event.pointerId);
    drag(event);
  });
  section.addEventListener("pointermove", drag);
  section.classList.toggle("vv-draggable", controls);

  async function ask(request) {
    const answer = await source.ask(request);
    if (answer.error) throw new Error(answer.error);
    return answer;
  }

  /** Asks for all views of the newest fibre and draws them. */
  async function update() {
    const [of, second, { theta, h, whole: all }] = [fiber, other, { ...light }];
    const hit = all ? { theta } : { theta, h };
    const both = async (request) => [
      await ask({ ...request, fiber: of }), second && (await ask({ ...request, fiber: second })),
    ];
    const rays = await ask({ ask: "section", fiber: of, theta, h, paths: 8 });
    drawSection(section, rays);
    section.setAttribute("aria-label", `Cross-section at offset ${h}: medulla radius ${rays.medulla}; `
      + rays.rays.map((ray) => `${ray.lobe} ${(100 * mean(ray.weight)).toFixed(1)} per cent`).join(", "));
    const [lobes, otherLobes] = await both({ ask: "polar", ...hit, samples: 360 });
    drawPolar(polar, lobes, otherLobes);
    polar.setAttribute("aria-label", `Lobes around the fibre, ${all ? "whole width" : `offset ${h}`}`);
    const [tilts, otherTilts] = await both({ ask: "longitudinal", ...hit, samples: 120 });
    drawLongitudinal(along, tilts, otherTilts, theta);
    along.setAttribute("aria-label", `Lobes along the fibre, light at ${theta} degrees`);
    const [energies, otherEnergies] = await both({ ask: "energy", theta, samples: 101 });
    drawEnergy(energy, energies, otherEnergies, h);
    energy.setAttribute("aria-label", "Energy by lobe over the offset; in all "
      + `${(100 * mean(energies.total)).toFixed(1)} per cent leave the fibre`);
    table.replaceChildren(tableOf(energies, otherEnergies));
    const values = await ask({ ask: "profile", fiber: of, ...hit, rows: 60, columns: 120 });
    const largest = drawProfile(canvas, values);
    canvas.setAttribute("aria-label", `Profile over inclination and azimuth, at most ${largest.toPrecision(3)}`);
    scale.textContent = `White: ${largest.toPrecision(3)} per steradian. Black: ${DECADES} decades less.`;
  }

  // One update runs at a time. Changes during it start one more.
  let running = null;
  let stale = false;
  async function run() {
    do {
      stale = false;
      try {
        await update();
        message.textContent = "";
      } catch (error) {
        message.textContent = String(error.message ?? error);
      }
      // The page handles events between updates.
      await new Promise((resolve) => setTimeout(resolve));
    } while (stale);
    running = null;
  }

  function show(next, more = {}) {
    fiber = next;
    if ("other" in more) other = more.other;
    for (const key of ["theta", "h", "whole"]) if (key in more) light[key] = more[key];
    sliders.theta.value = light.theta;
    sliders.h.value = light.h;
    whole.checked = light.whole;
    stale = true;
    running ??= run();
    return running;
  }

  return { show, get light() { return { ...light }; } };
}
