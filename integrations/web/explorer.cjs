// Tries the fibre explorer in a browser: node explorer.cjs PAGE CHROMIUM [FOLDER]
//
// Every control must change a picture, undo and redo must restore it, and the console must stay empty. With a folder,
// it writes screenshots there. Exit code 77: playwright-core is missing.

const path = require("node:path");
const { pathToFileURL } = require("node:url");

let chromium;
try {
  ({ chromium } = require("playwright-core"));
} catch {
  console.error("playwright-core is missing");
  process.exit(77);
}

const [page, executablePath, folder] = process.argv.slice(2);

function need(condition, message) {
  if (!condition) throw new Error(message);
}

/** All views as one text. */
const views = (tab) => tab.evaluate(() => [...document.querySelectorAll("[data-view]")].map((view) =>
  view instanceof HTMLCanvasElement ? view.toDataURL() : view.innerHTML).join() +
  document.querySelector(".vv-energies").textContent);

/** The views once two looks at them agree. */
async function settled(tab) {
  let last = "";
  for (let i = 0; i < 100; i++) {
    await tab.waitForTimeout(60);
    const now = await views(tab);
    if (now === last) return now;
    last = now;
  }
  throw new Error("the views do not settle");
}

async function main() {
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
  const tab = await browser.newPage({ viewport: { width: 1280, height: 900 } });
  const problems = [];
  tab.on("console", (message) => problems.push(`console: ${message.text()}`));
  tab.on("pageerror", (error) => problems.push(`error: ${error.message}`));
  tab.on("request", (request) => {
    if (/^https?:/.test(request.url())) problems.push(`request: ${request.url()}`);
  });
  await tab.goto(pathToFileURL(path.resolve(page)).href);
  await tab.waitForSelector("body[data-ready]");
  const start = await settled(tab);
  let steps = 0;

  // Each slider moves by a tenth. The share of pigment only matters for the next colour.
  const keys = await tab.$$eval("input[type=range]", (all) => all.map((input) => input.dataset.key));
  const undo = tab.locator("[data-action=undo]");
  for (const key of keys.filter((key) => key !== "medulla_pigment")) {
    const before = await settled(tab);
    const slider = tab.locator(`input[type=range][data-key="${key}"]`).first();
    await slider.focus();
    await tab.keyboard.press("PageUp");
    const after = await settled(tab);
    need(after !== before, `the slider ${key} changes nothing`);
    need(await slider.getAttribute("aria-label"), `the slider ${key} has no label`);
    steps++;
    if (key !== "theta" && key !== "h") {
      await undo.click();
      need((await settled(tab)) === before, `undo of ${key} does not restore the views`);
    } else {
      await slider.focus();
      await tab.keyboard.press("PageDown");
      await settled(tab);
    }
  }

  // Redo, by the keyboard.
  await tab.selectOption("[data-key=preset]", "cat");
  const cat = await settled(tab);
  need(cat !== start, "a preset changes nothing");
  await tab.locator("[data-action=reset]").focus();
  await tab.keyboard.press("Control+z");
  need((await settled(tab)) !== cat, "Ctrl+Z changes nothing");
  await tab.keyboard.press("Control+y");
  need((await settled(tab)) === cat, "Ctrl+Y does not restore the preset");

  // Number fields, selections, check boxes.
  await tab.locator("input[data-number=kappa]").fill("0.4");
  await tab.keyboard.press("Enter");
  need((await settled(tab)) !== cat, "the number field changes nothing");
  for (const [key, value] of [["exit", "open"], ["preset", "human-published"]]) {
    const before = await settled(tab);
    await tab.selectOption(`[data-key=${key}]`, value);
    need((await settled(tab)) !== before, `${key} changes nothing`);
  }
  for (const box of ["[data-key=whole]", "[data-key=whole]"]) {
    const before = await settled(tab);
    await tab.locator(box).click();
    need((await settled(tab)) !== before, `${box} changes nothing`);
  }
  const before = await settled(tab);
  await tab.locator("[data-key=picker]").fill("#d08040");
  need((await settled(tab)) !== before, "the colour picker changes nothing");

  // Two looks.
  const a = await settled(tab);
  await tab.locator("[data-look=B]").check({ force: true });
  const b = await settled(tab);
  need(a !== b, "look B is look A");
  await tab.locator("#compare").check();
  need((await settled(tab)) !== b, "the comparison draws nothing");
  await tab.locator("#compare").uncheck();
  await tab.locator("[data-look=A]").check({ force: true });
  need((await settled(tab)) === a, "look A is lost");
  await tab.locator("[data-action=copy]").click();
  await tab.locator("[data-look=B]").check({ force: true });
  need((await settled(tab)) === a, "the copy of look A differs");

  // A drag in the cross-section.
  const box = await tab.locator("[data-view=section]").boundingBox();
  await tab.mouse.move(box.x + box.width / 2, box.y + 0.5 * box.height);
  await tab.mouse.down();
  await tab.mouse.move(box.x + box.width / 2, box.y + 0.3 * box.height, { steps: 5 });
  await tab.mouse.up();
  need((await settled(tab)) !== a, "a drag in the cross-section changes nothing");

  if (folder) {
    await tab.reload();
    await tab.waitForSelector("body[data-ready]");
    for (const [width, height, scheme] of [[1280, 1000, "light"], [820, 1180, "dark"]]) {
      await tab.setViewportSize({ width, height });
      await tab.emulateMedia({ colorScheme: scheme });
      await settled(tab);
      const wide = await tab.evaluate(() => document.documentElement.scrollWidth);
      need(wide <= width, `the page is ${wide} wide in a window of ${width}`);
      await tab.screenshot({ path: path.join(folder, `explorer-${width}.png`) });
    }
  }
  // Without WebAssembly there is a message.
  const bare = await browser.newPage();
  await bare.addInitScript(() => delete globalThis.WebAssembly);
  await bare.goto(pathToFileURL(path.resolve(page)).href);
  await bare.waitForFunction(() => document.getElementById("failure").textContent.includes("WebAssembly"));
  await browser.close();
  need(problems.length === 0, problems.join("\n"));
  console.log(`explorer: ${steps} sliders and all other controls change the views; the console is empty`);
}

main().catch((error) => {
  console.error(error.message);
  process.exit(1);
});
