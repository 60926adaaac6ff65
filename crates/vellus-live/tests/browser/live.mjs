// Uses every control of the page in Chromium, and compares pictures. Arguments: the address of the page, and
// optionally a folder for screenshots. It needs playwright-core: NODE_PATH names the folder that contains it.
//
//   npm install --prefix /tmp/pw playwright-core
//   NODE_PATH=/tmp/pw/node_modules cargo test -p vellus-live --test browser -- --ignored --nocapture

import { createRequire } from "node:module";
import { strict as assert } from "node:assert";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const { chromium } = createRequire(import.meta.url)("playwright-core");
const [url, folder] = process.argv.slice(2);
if (folder) mkdirSync(folder, { recursive: true });
const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, colorScheme: "dark" });
const problems = [];
const watch = (one) => {
  one.on("console", (message) => message.type() === "error" && problems.push(message.text()));
  one.on("pageerror", (error) => problems.push(error.stack ?? String(error)));
};
watch(page);

const shot = (name) => folder && page.screenshot({ path: join(folder, `${name}.png`) });
const frame = (one = page) => one.evaluate(() => Number(document.documentElement.dataset.frame ?? 0));
// Waits until the picture is at full resolution after the last command.
async function settled(one = page) {
  await one.waitForTimeout(500);
  await one.waitForFunction(() => document.documentElement.dataset.coarse === "1", null, { timeout: 120_000 });
}
// A small copy of the picture, as numbers.
const pixels = (one = page) => one.evaluate(() => {
  const small = new OffscreenCanvas(60, 40).getContext("2d");
  small.drawImage(document.getElementById("canvas"), 0, 0, 60, 40);
  return [...small.getImageData(0, 0, 60, 40).data];
});
const difference = (a, b) => a.reduce((sum, x, i) => sum + Math.abs(x - b[i]), 0) / a.length;
// Does something, and requires that the picture changes by more than `least` levels on average.
async function changes(name, least, act) {
  const before = await pixels();
  await act();
  await settled();
  const found = difference(before, await pixels());
  console.log(`${name}: pictures differ by ${found.toFixed(2)} levels`);
  assert.ok(found > least, `${name} changes the picture by ${found} levels only`);
}
// Sets a slider by its label to a position from 0 to 1.
async function slide(label, position) {
  const slider = page.getByRole("slider", { name: label, exact: true }).first();
  await slider.evaluate((input, t) => {
    input.value = Number(input.min) + (Number(input.max) - Number(input.min)) * t;
    input.dispatchEvent(new Event("input", { bubbles: true }));
    input.dispatchEvent(new Event("change", { bubbles: true }));
  }, position);
}
const press = (name) => page.getByRole("button", { name, exact: true }).click();
const open = (title) => page.locator("summary", { hasText: new RegExp(`^${title}$`) }).click();
const note = () => page.locator("#note").textContent();

try {
  await page.goto(url);
  await settled();
  await page.locator(".vf-row").first().waitFor();
  await shot("start");
  const view = page.locator("#view");
  const box = await view.boundingBox();
  const middle = [box.x + box.width / 2, box.y + box.height / 2];

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
  await press("Crop");
  await page.mouse.move(middle[0] - 80, middle[1] - 60);
  await page.mouse.down();
  await page.mouse.move(middle[0] + 80, middle[1] + 60, { steps: 3 });
  await page.mouse.up();
  await page.locator("#overlay rect").waitFor({ state: "attached" });
  await settled();
  await page.keyboard.press("Escape");
  await page.locator("#overlay rect").waitFor({ state: "detached" });
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
  await changes("coat colour", 1, async () => {
    await page.locator('input[data-key="picker"]').fill("#b03020");
    await page.waitForTimeout(500);
  });
  await changes("darker tips", 0.1, () => slide("Darker tips", 0.9));
  await changes("undo", 0.1, () => page.locator('[data-action="undo"]').first().click());
  await changes("redo", 0.1, () => page.locator('[data-action="redo"]').first().click());
  await changes("preset", 0.1, async () => {
    await page.getByRole("combobox", { name: "Preset" }).first().selectOption({ index: 3 });
    await page.waitForTimeout(300);
  });
  await changes("model", 0.1, () =>
    page.getByRole("combobox", { name: "Reflectance model" }).selectOption({ index: 6 }));
  await page.getByRole("combobox", { name: "Reflectance model" }).selectOption({ index: 0 });

  // Groom and lights.
  await changes("length", 1, async () => {
    await slide("Length", 0.75);
    await page.waitForTimeout(300);
    await page.locator("#busy").waitFor({ state: "hidden", timeout: 120_000 });
  });
  await slide("Clumping", 0.8);
  await slide("Clump size", 0.5);
  await slide("Density", 0.5);
  await page.waitForTimeout(300);
  await page.locator("#busy").waitFor({ state: "hidden", timeout: 120_000 });
  await shot("groom");
  await changes("groom of the scene", 1, async () => {
    await press("Groom of the scene");
    await page.waitForTimeout(300);
    await page.locator("#busy").waitFor({ state: "hidden", timeout: 120_000 });
  });
  // A sky of one colour looks the same from all sides.
  await slide("Rotate sky", 0.9);
  await changes("brightness", 1, () => slide("Brightness", 0.4));
  const move = page.getByRole("slider", { name: "Move x", exact: true });
  if (await move.count()) await changes("move a lamp", 0.1, () => slide("Move x", 0.9));

  // Camera and picture.
  await open("Camera");
  await changes("view angle", 1, () => slide("View angle", 0.9));
  await slide("Lens radius", 0.5);
  await press("Home");
  await slide("Samples", 0.3);
  await page.getByRole("combobox", { name: "Size of the picture" }).selectOption("480x320");
  await settled();

  // Files.
  for (const [name, file] of [["Look TOML", ".toml"], ["Look USD", ".usda"], ["Strands USD", ".usda"],
    ["Camera USD", ".usda"], ["PNG", ".png"], ["EXR", ".exr"]]) {
    await settled();
    const download = page.waitForEvent("download", { timeout: 60_000 });
    await press(name);
    const saved = await download;
    assert.ok(saved.suggestedFilename().endsWith(file), saved.suggestedFilename());
    assert.ok(readFileSync(await saved.path()).length > 100, name);
    console.log(`saved ${saved.suggestedFilename()}`);
  }
  const garbage = join(tmpdir(), "vellus-garbage.hair");
  writeFileSync(garbage, Buffer.alloc(20 << 20, 0xa7));
  const expected = problems.length;
  await page.locator('input[type="file"]').setInputFiles(garbage);
  await page.waitForFunction(() => document.getElementById("note").classList.contains("bad"));
  console.log(`garbage: ${await note()}`);
  await page.waitForTimeout(200);
  // Chromium reports the refused upload in the console. Nothing else may be there.
  const refused = problems.splice(expected).filter((text) => !text.includes("422"));
  assert.deepEqual(refused, []);

  // Two pages share the state.
  const second = await browser.newPage({ viewport: { width: 820, height: 1100 } });
  watch(second);
  await second.goto(url);
  await settled(second);
  await press("Pause");
  await second.waitForFunction(() => document.getElementById("pause").getAttribute("aria-pressed") === "true");
  await second.locator("#pause").click();
  if (folder) await second.screenshot({ path: join(folder, "tablet.png") });
  await second.close();

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
