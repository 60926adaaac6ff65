// What may go wrong: a lost connection, malformed messages, dropped garbage, and two browsers at once.

import { strict as assert } from "node:assert";
import net from "node:net";
import { difference, launch, openPage, problems, toolsOf, url } from "./common.mjs";

/** A proxy before the server, whose connections can be cut. */
class Proxy {
  constructor(port) {
    this.sockets = new Set();
    this.open = true;
    this.server = net.createServer((client) => {
      if (!this.open) {
        client.destroy();
        return;
      }
      const server = net.connect(port, "127.0.0.1");
      for (const [one, other] of [[client, server], [server, client]]) {
        this.sockets.add(one);
        one.on("error", () => other.destroy());
        one.on("close", () => { this.sockets.delete(one); other.destroy(); });
        one.pipe(other);
      }
    });
  }

  listen() {
    return new Promise((resolve) => this.server.listen(0, "127.0.0.1", () => resolve(this.server.address().port)));
  }

  cut() {
    this.open = false;
    for (const socket of this.sockets) socket.destroy();
  }
}

const proxy = new Proxy(Number(new URL(url).port));
const behind = `http://127.0.0.1:${await proxy.listen()}/`;
const [first, second] = [await launch(), await launch()];
const [page, other] = [await openPage(first), await openPage(second)];
const [tools, others] = [toolsOf(page), toolsOf(other)];
const drag = async (one, helper, dx) => {
  const [x, y] = await helper.middle();
  await one.mouse.move(x, y);
  await one.mouse.down();
  await one.mouse.move(x + dx, y + 10, { steps: 6 });
  await one.mouse.up();
};

try {
  await page.goto(behind);
  await other.goto(url);
  await tools.settled();
  await others.settled();

  // Two browsers drag at once. Both show the same camera at the end.
  await Promise.all([drag(page, tools, 120), drag(other, others, -90)]);
  const same = async () => {
    await tools.settled();
    await others.settled();
    await page.waitForTimeout(1500);
    return difference(await tools.pixels(), await others.pixels());
  };
  const apart = await same();
  console.log(`two browsers: pictures differ by ${apart.toFixed(2)} levels`);
  // The pictures may have different numbers of samples.
  assert.ok(apart < 3, "two browsers show different pictures");

  // A lost connection: the page says so, keeps its picture, and survives its controls.
  const kept = await tools.pixels();
  proxy.cut();
  await page.locator("#offline").waitFor({ state: "visible" });
  assert.ok(difference(kept, await tools.pixels()) < 3, "the picture is gone");
  await drag(page, tools, 50);
  await tools.slide("Exposure", 0.7);
  await tools.press("Home");
  assert.match(await tools.note(), /connection is lost/);
  await tools.shot("lost");
  // Another page changes the view meanwhile.
  await others.changes("other page", 1, () => drag(other, others, 200));
  await page.waitForTimeout(1500);
  proxy.open = true;
  const started = performance.now();
  await page.locator("#offline").waitFor({ state: "hidden" });
  console.log(`the connection is back after ${(performance.now() - started).toFixed(0)} ms`);
  assert.ok(await same() < 3, "the page shows an old picture");
  await tools.changes("drag after the loss", 1, () => drag(page, tools, 150));
  // Chromium reports each refused connection. Nothing else may be in the console.
  const refused = (text) => /WebSocket connection to|ERR_(CONNECTION|EMPTY|SOCKET)/.test(text);
  assert.deepEqual(problems.splice(0).filter((text) => !refused(text)), []);

  // Messages of random bytes, cut commands and one that is too long, from a socket of the page.
  const answers = await page.evaluate(async () => {
    const address = Object.assign(new URL("ws", location.href), { protocol: "ws:" });
    const good = '{"type":"groom","density":1,"length":1,"clump":0,"clump_strands":40,"id":1}';
    const socket = new WebSocket(address);
    await new Promise((resolve) => { socket.onopen = resolve; });
    let errors = 0;
    const count = new Promise((resolve) => {
      socket.onmessage = ({ data }) => {
        if (typeof data === "string" && data.startsWith('{"id"') || data.includes?.('"error"')) errors += 1;
        if (errors === 300) resolve();
      };
    });
    for (let i = 0; i < 100; i++) {
      socket.send(good.slice(0, 1 + i % (good.length - 1)));
      socket.send(crypto.getRandomValues(new Uint8Array(1 + i * 7)));
      socket.send(JSON.stringify({ type: "orbit", x: "left", y: [i] }));
    }
    await count;
    const closed = new Promise((resolve) => { socket.onclose = resolve; });
    socket.send("x".repeat(1 << 20));
    await closed;
    return errors;
  });
  console.log(`malformed messages: ${answers} errors; the socket with a message of 1 MB is closed`);
  assert.ok(await page.locator("#offline").isHidden(), "the page's own connection is closed");
  assert.deepEqual(problems.splice(0).filter((text) => !refused(text)), []);

  // 20 MB of garbage, dropped on the page.
  const before = await page.locator("#scene").textContent();
  for (const name of ["a.hair", "a.tfx", "a.obj", "a.usda", "a.jpg", "no ending"]) {
    await page.evaluate((name) => {
      document.getElementById("note").classList.remove("bad");
      const bytes = new Uint8Array(20 << 20);
      for (let i = 0; i < bytes.length; i += 65536) crypto.getRandomValues(bytes.subarray(i, i + 65536));
      const data = new DataTransfer();
      data.items.add(new File([bytes], name));
      for (const type of ["dragenter", "dragover", "drop"]) {
        document.body.dispatchEvent(new DragEvent(type, { dataTransfer: data, bubbles: true, cancelable: true }));
      }
    }, name);
    await page.locator("#note.bad").waitFor({ timeout: 60_000 });
    console.log(`garbage: ${await tools.note()}`);
  }
  assert.equal(await page.locator("#scene").textContent(), before);
  await page.waitForTimeout(200);
  assert.deepEqual(problems.splice(0).filter((text) => !text.includes("422")), []);

  // One browser is killed. The other goes on.
  await second.close();
  await tools.changes("drag after the other browser has ended", 1, () => drag(page, tools, 150));

  // Keyboard alone: Tab reaches every control, and Space and arrows change it.
  await page.locator("body").press("Tab");
  const reached = new Set();
  for (let i = 0; i < 150; i++) {
    reached.add(await page.evaluate(() => document.activeElement.id || document.activeElement.ariaLabel
      || document.activeElement.getAttribute("aria-labelledby") || document.activeElement.textContent));
    await page.keyboard.press("Tab");
  }
  for (const name of ["pause", "home", "pick", "crop", "exposure", "a", "b", "copy", "theme", "help", "view",
    "Reflectance model", "Preset", "Coat colour by name", "PNG", "Load a groom …"]) {
    assert.ok(reached.has(name), `Tab does not reach ${name}`);
  }
  await page.getByRole("slider", { name: "Darker tips" }).focus();
  await page.keyboard.press("End");
  await tools.settled();
  assert.equal(await page.locator("#undo").isEnabled(), true);
  await page.locator("#undo").focus();
  await page.keyboard.press("Space");
  await page.waitForFunction(() => document.getElementById("undo").disabled);
  assert.deepEqual(problems, []);
  console.log("the page survives, and Tab reaches its controls");
} finally {
  await first.close();
  await second.close();
  proxy.cut();
  proxy.server.close();
}
