// What the tests of the page share: a browser, pictures to compare, and controls by their labels.

import { createRequire } from "node:module";
import { strict as assert } from "node:assert";
import { mkdirSync } from "node:fs";
import { join } from "node:path";

export const require = createRequire(import.meta.url);
const { chromium } = require("playwright-core");

export const [url, folder] = process.argv.slice(2);
if (folder) mkdirSync(folder, { recursive: true });

/** Everything that a page has written to its console as an error, and every exception. */
export const problems = [];

export async function launch(args = []) {
  const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
  return chromium.launch({ executablePath, args: ["--no-sandbox", ...args] });
}

export async function openPage(browser, options = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, colorScheme: "dark", ...options });
  page.on("console", (message) => message.type() === "error" && problems.push(message.text()));
  page.on("pageerror", (error) => problems.push(error.stack ?? String(error)));
  return page;
}

/** Functions for one page. */
export function toolsOf(page) {
  const tools = {
    shot: (name) => folder && page.screenshot({ path: join(folder, `${name}.png`) }),
    frame: () => page.evaluate(() => Number(document.documentElement.dataset.frame ?? 0)),
    // Waits until the picture is at full resolution after the last command.
    async settled() {
      await page.waitForTimeout(500);
      await page.locator("#busy").waitFor({ state: "hidden", timeout: 120_000 });
      await page.waitForFunction(() => document.documentElement.dataset.coarse === "1", null, { timeout: 120_000 });
    },
    // A small copy of the picture, as numbers.
    pixels: () => page.evaluate(() => {
      const small = new OffscreenCanvas(60, 40).getContext("2d");
      small.drawImage(document.getElementById("canvas"), 0, 0, 60, 40);
      return [...small.getImageData(0, 0, 60, 40).data];
    }),
    // Does something, and requires that the picture changes by more than `least` levels on average.
    async changes(name, least, act) {
      const before = await tools.pixels();
      await act();
      await tools.settled();
      const found = difference(before, await tools.pixels());
      console.log(`${name}: pictures differ by ${found.toFixed(2)} levels`);
      assert.ok(found > least, `${name} changes the picture by ${found} levels only`);
    },
    // Sets a slider by its label to a position from 0 to 1.
    async slide(label, position) {
      const slider = page.getByRole("slider", { name: label, exact: true }).first();
      await slider.evaluate((input, t) => {
        input.value = Number(input.min) + (Number(input.max) - Number(input.min)) * t;
        input.dispatchEvent(new Event("input", { bubbles: true }));
        input.dispatchEvent(new Event("change", { bubbles: true }));
      }, position);
    },
    // One click on a button, by its text.
    press: (name) => page.getByRole("button", { name, exact: true }).click(),
    // Opens or closes a panel.
    open: (title) => page.locator("summary", { hasText: new RegExp(`^${title}$`) }).click(),
    note: () => page.locator("#note").textContent(),
    async middle() {
      const box = await page.locator("#view").boundingBox();
      return [box.x + box.width / 2, box.y + box.height / 2];
    },
    // Sends a command past the controls, for a state that a test needs. Resolves to the error, if any.
    command: (command) => page.evaluate((command) => new Promise((resolve) => {
      const socket = new WebSocket(Object.assign(new URL("ws", location.href), { protocol: "ws:" }));
      socket.onopen = () => socket.send(JSON.stringify({ ...command, id: "test" }));
      socket.onmessage = ({ data }) => {
        const message = typeof data === "string" ? JSON.parse(data) : {};
        if (message.id !== "test") return;
        socket.close();
        resolve(message.type === "error" ? message.message : null);
      };
    }), command),
  };
  return tools;
}

export const difference = (a, b) => a.reduce((sum, x, i) => sum + Math.abs(x - b[i]), 0) / a.length;

export const median = (list) => [...list].sort((a, b) => a - b)[Math.floor(list.length / 2)];
