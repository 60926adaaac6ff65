// Uses every control of the page in Chromium, and compares pictures. Arguments: the address of the page, and
// optionally a folder for screenshots. It needs playwright-core: NODE_PATH names the folder that contains it.
// With axe-core in the same folder, it also looks for barriers.
//
//   npm install --prefix /tmp/pw playwright-core axe-core
//   NODE_PATH=/tmp/pw/node_modules cargo test -p vellus-live browser -- --ignored --nocapture

import { strict as assert } from "node:assert";
import { readFileSync } from "node:fs";
import { difference, launch, openPage, problems, require, toolsOf, url } from "./common.mjs";

const browser = await launch();
const page = await openPage(browser);
const { changes, frame, middle: middleOf, open, pixels, press, settled, shot, slide } = toolsOf(page);

// Mean difference of neighbouring pixels at full resolution, in levels.
const roughness = () => page.evaluate(() => {
  const canvas = document.getElementById("canvas");
  const { data, width } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let sum = 0;
  for (let i = 0; i + 4 * width < data.length; i += 4) sum += Math.abs(data[i] - data[i + 4]);
  return sum / (data.length / 4);
});
// Looks for barriers with axe-core, in both themes, with all panels open.
async function barriers() {
  let path;
  try {
    path = require.resolve("axe-core/axe.min.js");
  } catch {
    console.log("skipped: axe-core is missing");
    return;
  }
  // The page refuses foreign scripts, so the source is evaluated by the debugger.
  await page.evaluate(readFileSync(path, "utf8"));
  for (const theme of ["dark", "light"]) {
    await page.evaluate((name) => {
      document.documentElement.dataset.theme = name;
      for (const one of document.querySelectorAll("details")) one.open = true;
      document.getElementById("keys").hidden = false;
    }, theme);
    await page.waitForTimeout(500);
    const { violations, passes } = await page.evaluate(() => globalThis.axe.run());
    const shown = violations.map(({ impact, id, nodes }) =>
      `${impact} ${id}: ${nodes.map((one) => one.html).join(" ")}`);
    console.log(`axe-core, ${theme}: ${passes.length} rules hold, ${violations.length} do not\n${shown.join("\n")}`);
    assert.deepEqual(violations.filter(({ impact }) => ["serious", "critical"].includes(impact)), []);
  }
}

try {
  await page.goto(url);
  await settled();
  await page.locator(".vf-row").first().waitFor();
  await shot("start");
  // Pictures are compared below. The denoiser works while they refine, so it would change them later.
  if (!await page.locator("#denoise").isDisabled()) {
    await page.waitForFunction(() => document.documentElement.dataset.denoised === "true");
    await press("Denoise");
    await page.waitForFunction(() => document.documentElement.dataset.denoised === "false");
  }
  const view = page.locator("#view");
  const middle = await middleOf();

  // The picture: mouse and keys.
  await changes("orbit", 1, async () => {
    await page.mouse.move(...middle);
    await page.mouse.down();
    await page.mouse.move(middle[0] + 150, middle[1] + 20, { steps: 8 });
    await page.mouse.up();
  });
  await changes("pan", 1, async () => {
    await page.mouse.move(...middle);
    await page.mouse.down({ button: "right" });
    await page.mouse.move(middle[0] + 90, middle[1], { steps: 4 });
    await page.mouse.up({ button: "right" });
  });
  await changes("zoom", 1, () => page.mouse.wheel(0, -400));
  await changes("home", 1, () => press("Home"));
  await view.focus();
  await changes("arrow keys", 1, async () => {
    for (let i = 0; i < 6; i++) await page.keyboard.press("ArrowLeft");
  });
  await changes("shift + arrow keys", 1, async () => {
    for (let i = 0; i < 4; i++) await page.keyboard.press("Shift+ArrowUp");
  });
  await changes("plus key", 0.5, async () => {
    for (let i = 0; i < 4; i++) await page.keyboard.press("+");
  });
  await changes("home key", 1, () => page.keyboard.press("h"));
  await changes("exposure key", 1, async () => {
    for (let i = 0; i < 4; i++) {
      await page.keyboard.press("]");
      await page.waitForTimeout(100);
    }
  });
  await changes("exposure", 1, () => page.locator("#exposure").fill("0"));
  await page.mouse.dblclick(middle[0], middle[1]);
  await settled();
  await press("Home");
  await settled();

  // The time from a drag to its first picture, measured by the page.
  const times = [];
  await page.mouse.move(...middle);
  await page.mouse.down();
  for (let i = 0; i < 20; i++) {
    const last = await frame();
    const started = performance.now();
    await page.mouse.move(middle[0] + 7 * (i % 5), middle[1] + i);
    await page.waitForFunction((n) => Number(document.documentElement.dataset.frame) > n, last, { polling: 5 });
    times.push(performance.now() - started);
  }
  await page.mouse.up();
  times.sort((a, b) => a - b);
  const [median, worst] = [times[10], times[19]].map((x) => x.toFixed(0));
  const facts = await page.locator("#facts").textContent();
  console.log(`drag to picture, in the browser: median ${median} ms, longest ${worst} ms; ${facts}`);
  await press("Home");
  await settled();

  // Pause, crop, inspect, help, theme.
  await press("Pause");
  const paused = await frame();
  await page.waitForTimeout(600);
  assert.ok((await frame()) - paused <= 1, "a paused picture refines");
  await press("Pause");
  // Outside of the crop nothing changes, not even with another exposure.
  await press("Crop");
  await page.mouse.move(middle[0] - 80, middle[1] - 60);
  await page.mouse.down();
  await page.mouse.move(middle[0] + 80, middle[1] + 60, { steps: 3 });
  await page.mouse.up();
  await page.locator("#overlay rect").waitFor({ state: "attached" });
  await settled();
  const corner = (list) => list.slice(0, 4 * 60 * 4);
  const cropped = await pixels();
  await changes("exposure in a crop", 0.5, () => slide("Exposure", 0.9));
  assert.ok(difference(corner(cropped), corner(await pixels())) < 0.01, "the crop changes pixels outside of it");
  await page.locator("#exposure").fill("0");
  await settled();
  await page.keyboard.press("Escape");
  await page.locator("#overlay rect").waitFor({ state: "detached" });
  await settled();

  // Denoising: neighbouring pixels differ less.
  if (await page.locator("#denoise").isDisabled()) {
    console.log(`skipped: denoise (${(await page.locator("#denoise").getAttribute("title")).split(";")[0]})`);
  } else {
    await page.locator("#denoise").focus();
    await slide("Samples", 0);
    await press("Home");
    await settled();
    const noisy = await roughness();
    await press("Denoise");
    await page.waitForFunction(() => document.documentElement.dataset.denoised === "true");
    const clean = await roughness();
    console.log(`denoise: neighbours differ by ${noisy.toFixed(2)} levels before, ${clean.toFixed(2)} after`);
    assert.ok(clean < 0.8 * noisy, "the denoiser does not clean the picture");
    await press("Denoise");
    await slide("Samples", 0.6);
  }
  await press("Inspect");
  await page.mouse.click(...middle);
  await page.locator("dt", { hasText: "Inclination θ" }).waitFor();
  await press("Show its lobes");
  await page.locator(".vv-view").first().waitFor();
  await page.waitForTimeout(800);
  await shot("inspect");
  await press("Inspect");
  await open("Views of the fibre");
  await press("?");
  await page.getByText("Mouse and keys").waitFor();
  await press("?");
  await press("Theme");
  await shot("light");
  await press("Theme");

  // Fibre.
  await changes("colour by name", 1, async () => {
    await page.getByRole("textbox", { name: "Coat colour by name" }).fill("darkgreen");
    await page.keyboard.press("Enter");
    await page.waitForTimeout(500);
  });
  await page.getByRole("textbox", { name: "Coat colour by name" }).fill("no colour");
  await page.keyboard.press("Enter");
  await page.getByText("'no colour' is no colour").waitFor();
  await changes("coat colour", 1, async () => {
    await page.locator('input[data-key="picker"]').fill("#b03020");
    await page.waitForTimeout(500);
  });
  await changes("darker tips", 0.1, () => slide("Darker tips", 0.9));
  await changes("preset", 0.1, async () => {
    await page.getByRole("combobox", { name: "Preset" }).first().selectOption({ index: 3 });
    await page.waitForTimeout(300);
  });
  await changes("model", 0.1, () =>
    page.getByRole("combobox", { name: "Reflectance model" }).selectOption({ index: 6 }));

  // Every kind of change has undo and redo, by button and by key.
  const steps = [["model", "undo"], ["preset", "Control+z"], ["darker tips", "undo"], ["coat colour", "Control+z"]];
  for (const [name, how] of steps) {
    await changes(`undo of ${name}`, 0.1, () => (how === "undo" ? press("Undo") : page.keyboard.press(how)));
  }
  for (const how of ["redo", "Control+y", "redo", "Control+Shift+z"]) {
    await changes(`redo by ${how}`, 0.1, () => (how === "redo" ? press("Redo") : page.keyboard.press(how)));
  }

  // Two versions: version B still has the first fur and model. Then two models of the same fibre.
  await changes("version B", 1, () => press("B"));
  assert.equal(await page.getByRole("combobox", { name: "Reflectance model" }).inputValue(), "vellus");
  await page.locator("#view").focus();
  await changes("version A by key", 1, () => page.keyboard.press("v"));
  await press("A → B");
  await press("B");
  await page.getByRole("combobox", { name: "Reflectance model" }).selectOption("vellus");
  await settled();
  await press("A");
  await settled();
  await page.getByRole("combobox", { name: "Reflectance model" }).selectOption("chiang2016");
  await settled();
  await changes("two models", 0.1, () => press("B"));
  await press("A");
  await page.getByRole("combobox", { name: "Reflectance model" }).selectOption("vellus");
  await settled();

  // Groom and lights.
  await changes("length", 1, async () => {
    await slide("Length", 0.75);
    await page.waitForTimeout(300);
  });
  await changes("undo of length", 1, () => press("Undo"));
  await changes("redo of length", 1, () => press("Redo"));
  for (const [label, position] of [["Clumping", 0.8], ["Clump size", 0.5], ["Density", 0.3]]) {
    await changes(label, 0.1, () => slide(label, position));
  }
  await shot("groom");
  await changes("groom of the scene", 1, () => press("Groom of the scene"));
  await slide("Rotate lights", 0.9);
  await changes("brightness", 1, () => slide("Brightness", 0.4));
  await changes("undo of brightness", 1, () => press("Undo"));
  await changes("redo of brightness", 1, () => press("Redo"));
  const move = page.getByRole("slider", { name: "Move x", exact: true });
  if (await move.count()) {
    await changes("move a lamp", 0.1, () => slide("Move x", 0.9));
    await changes("undo of a moved lamp", 0.1, () => press("Undo"));
  }

  // Camera and picture.
  await open("Camera");
  await changes("view angle", 1, () => slide("View angle", 0.9));
  await slide("Lens radius", 0.5);
  await press("Home");
  await slide("Samples", 0.3);
  await page.getByRole("combobox", { name: "Size of the picture" }).selectOption("480x320");
  await settled();

  // Files.
  for (const [name, file] of [["Look TOML", ".toml"], ["Look USD", ".usda"], ["Scene USD", ".usdc"],
    ["Lights USD", ".usda"],
    ["Camera USD", ".usda"], ["PNG", ".png"], ["EXR", ".exr"]]) {
    await settled();
    const download = page.waitForEvent("download", { timeout: 60_000 });
    await press(name);
    const saved = await download;
    assert.ok(saved.suggestedFilename().endsWith(file), saved.suggestedFilename());
    assert.ok(readFileSync(await saved.path()).length > 100, name);
    console.log(`saved ${saved.suggestedFilename()}`);
  }
  await barriers();

  // Every control has a name for screen readers.
  const unnamed = await page.evaluate(() => [...document.querySelectorAll("button, input, select")].filter((one) =>
    one.type !== "file" && !one.ariaLabel && !one.getAttribute("aria-labelledby") && !one.textContent.trim()
      && !(one.labels?.length)).map((one) => one.outerHTML));
  assert.deepEqual(unnamed, []);
  assert.deepEqual(problems, []);
  console.log("all controls work, and the console is empty");
} finally {
  await browser.close();
}
