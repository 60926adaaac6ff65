// Drags at random for ten minutes, in the picture and on sliders, and requires that neither the server nor the page
// needs much more memory at the end. VELLUS_LIVE_SECONDS is another duration.

import { strict as assert } from "node:assert";
import { readFileSync } from "node:fs";
import { launch, openPage, problems, toolsOf, url } from "./common.mjs";

const seconds = Number(process.env.VELLUS_LIVE_SECONDS ?? 600);
const browser = await launch();
const page = await openPage(browser);
const { frame, middle: middleOf, settled } = toolsOf(page);

// Knuth's MMIX generator: the same drags in each run.
let seed = 1n;
const random = () => {
  seed = (seed * 6364136223846793005n + 1442695040888963407n) & 0xffffffffffffffffn;
  return Number(seed >> 40n) / 2 ** 24;
};
const within = (low, high) => low + (high - low) * random();

const resident = () => {
  const status = readFileSync(`/proc/${process.env.VELLUS_LIVE_PID}/status`, "utf8");
  return Number(/VmRSS:\s+(\d+)/.exec(status)[1]) / 1024;
};

try {
  await page.goto(url);
  await settled();
  const debug = await page.context().newCDPSession(page);
  await debug.send("Performance.enable");
  const measure = async (name) => {
    await debug.send("HeapProfiler.collectGarbage");
    const { metrics } = await debug.send("Performance.getMetrics");
    const of = (key) => metrics.find((one) => one.name === key).value;
    const heap = of("JSHeapUsedSize") / 2 ** 20;
    const found = { server: resident(), heap, nodes: of("Nodes"), frames: await frame() };
    console.log(`${name}: server ${found.server.toFixed(0)} MB, page ${found.heap.toFixed(2)} MB of JavaScript, `
      + `${found.nodes} nodes, ${found.frames} pictures`);
    return found;
  };
  const middle = await middleOf();
  const first = await measure("start");
  const start = performance.now();
  const passed = () => (performance.now() - start) / 1000;
  let warm = null;
  let drags = 0;
  while (passed() < seconds) {
    const kind = random();
    if (kind < 0.7) {
      const button = kind < 0.5 ? "left" : "right";
      await page.mouse.move(middle[0] + within(-200, 200), middle[1] + within(-150, 150));
      await page.mouse.down({ button });
      for (let i = 0; i < 12; i++) {
        await page.mouse.move(middle[0] + within(-200, 200), middle[1] + within(-150, 150), { steps: 2 });
      }
      await page.mouse.up({ button });
    } else if (kind < 0.8) {
      await page.mouse.move(...middle);
      await page.mouse.wheel(0, within(-300, 300));
    } else {
      const sliders = page.locator("#panels input[type=range]:not(:disabled)");
      const one = sliders.nth(Math.floor(within(0, await sliders.count())));
      await one.scrollIntoViewIfNeeded().catch(() => {});
      const box = await one.boundingBox();
      if (!box) continue;
      await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
      await page.mouse.down();
      for (let i = 0; i < 8; i++) {
        await page.mouse.move(box.x + within(0, box.width), box.y + box.height / 2);
      }
      await page.mouse.up();
    }
    drags += 1;
    // The camera comes back, so that the scene is in view most of the time.
    if (drags % 20 === 0) await page.locator("#home").click();
    if (!warm && passed() > seconds / 5) warm = await measure(`after ${passed().toFixed(0)} s`);
  }
  await page.locator("#busy").waitFor({ state: "hidden", timeout: 120_000 });
  const end = await measure(`end, after ${drags} drags in ${passed().toFixed(0)} s`);
  // A leak of one picture of 960 × 640 bytes × 4 in a hundred would be a hundred megabytes. Strands of another length
  // and the allocator's free lists change the server by less than the bounds.
  // The allocator may give memory back for a while, so the largest of the earlier numbers counts.
  const before = Math.max(first.server, warm.server);
  assert.ok(end.server < 1.15 * before + 32, "the server needs more and more memory");
  // The page keeps at most some decoded answers between two collections.
  assert.ok(end.heap < 1.3 * warm.heap + 1, "the page needs more and more memory");
  // The views of the fibre are complete only when nothing moves: that adds 157 elements and their text.
  assert.ok(end.nodes < 1.3 * warm.nodes + 500, "the page has more and more nodes");
  assert.deepEqual(problems, []);
} finally {
  await browser.close();
}
