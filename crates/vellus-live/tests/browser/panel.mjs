// The panel at two widths of the window, and what is typed into it. Arguments and requirements: as live.mjs.

import { strict as assert } from "node:assert";
import { readFileSync } from "node:fs";
import { launch, openPage, problems, toolsOf, url } from "./common.mjs";

const browser = await launch();
const page = await openPage(browser, { viewport: { width: 1400, height: 900 } });
const { changes, press, settled, shot } = toolsOf(page);
const number = (label) => page.getByRole("spinbutton", { name: label }).first();

try {
  await page.goto(url);
  await settled();
  await page.locator(".vf-row").first().waitFor();
  await shot("panel-1400");

  // Colour, gloss and tips come before physics.
  const text = await page.locator("#panels").textContent();
  const words = ["Darker tips", "Coat colour", "Gloss", "Cuticle", "Medulla", "Model"];
  const order = words.map((word) => text.indexOf(word));
  assert.deepEqual(order, [...order].sort((a, b) => a - b));
  assert.ok(order[0] >= 0);

  // Escape closes the help, also while its button has the focus, and does nothing else.
  await press("?");
  await page.getByText("Mouse and keys").waitFor();
  await page.keyboard.press("Escape");
  await page.getByText("Mouse and keys").waitFor({ state: "hidden" });
  assert.equal(await page.locator("#help").getAttribute("aria-expanded"), "false");

  // Typed numbers stay as they are, also after the answer of the server. The nearest valid one replaces others.
  const kept = [["Length", "0.5", "0.5"], ["Density", "0.505", "0.505"], ["Brightness", "1.2345", "1.2345"],
    ["Clump size", "7.4", "7"], ["Length", "9", "5"], ["Length", "", "5"], ["Length", "1", "1"], ["Density", "1", "1"],
    ["Coat colour, Red", "0.5", "0.5"], ["Coat colour, Green", "0.123456", "0.123456"],
    ["Darker tips", "1.005", "1.005"]];
  for (const [label, typed, expected] of kept) {
    await number(label).fill(typed);
    await number(label).press("Enter");
    await number(label).blur();
    await settled();
    assert.equal(await number(label).inputValue(), expected, `${label} ${typed}`);
  }
  assert.equal(await number("Coat colour, Red").inputValue(), "0.5");

  // The words of the command, which CSS does not know.
  const word = page.getByRole("textbox", { name: "Coat colour by name" });
  await changes("a coat by name", 1, async () => {
    await word.fill("ginger");
    await word.press("Enter");
    await page.waitForTimeout(500);
  });
  assert.equal(await number("Coat colour, Red").inputValue(), "0.72");
  await word.fill("kapa");
  await word.press("Enter");
  await page.getByText("one of arctic").waitFor();

  // Lamps turn, and are saved as they are.
  await number("Rotate lights").fill("90");
  await number("Rotate lights").press("Enter");
  await settled();
  for (const [name, file] of [["Scene USD", "scene.usdc"], ["Lights USD", "lights.usda"]]) {
    const download = page.waitForEvent("download", { timeout: 60_000 });
    await press(name);
    const saved = await download;
    assert.equal(saved.suggestedFilename(), file);
    if (file === "lights.usda") assert.match(readFileSync(await saved.path(), "utf8"), /def \w+Light /);
  }

  // A narrower window: all names of presets and all controls are visible as a whole.
  await page.setViewportSize({ width: 1000, height: 800 });
  await press("Fibre");
  await settled();
  await shot("panel-1000");
  const presets = page.getByRole("combobox", { name: "Preset" }).first();
  assert.ok((await presets.boundingBox()).width >= 150, "the list of presets is narrow");
  const cut = await page.evaluate(() => [...document.querySelectorAll("#panels :is(button, select, input, label)")]
    .filter((one) => one.checkVisibility() && one.getBoundingClientRect().right > innerWidth + 0.5)
    .map((one) => one.outerHTML));
  assert.deepEqual(cut, []);
  assert.deepEqual(problems, []);
  console.log("the panel keeps what is typed");
} finally {
  await browser.close();
}
