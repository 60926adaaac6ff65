// The fibre explorer: the panel and the views on one static page. The model runs in the page, as WebAssembly.
//
// `cargo xtask explorer` builds one file from this folder and the module, so that the page also works from a disk.

import { createFiberPanel } from "./fiber-panel.js";
import { createFiberViews } from "./fiber-views.js";

/** The module's bytes: from the page itself, where they are compressed, or from the file beside it. */
async function moduleBytes() {
  const embedded = document.getElementById("vellus-wasm");
  if (embedded) {
    const packed = Uint8Array.from(atob(embedded.textContent.trim()), (letter) => letter.charCodeAt(0));
    const bytes = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(bytes).arrayBuffer();
  }
  const response = await fetch("vellus.wasm");
  if (!response.ok) throw new Error(`vellus.wasm: ${response.status} ${response.statusText}`);
  return new Uint8Array(await response.arrayBuffer());
}

/** A source of answers for the panel and the views. */
async function createWasmSource() {
  if (typeof WebAssembly !== "object") throw new Error("this browser has no WebAssembly");
  const { instance } = await WebAssembly.instantiate(await moduleBytes(), {});
  const { memory, vellus_alloc: alloc, vellus_free: free, vellus_answer: answer } = instance.exports;
  return {
    async ask(request) {
      const bytes = new TextEncoder().encode(JSON.stringify(request));
      const place = alloc(bytes.length);
      if (place === 0) throw new Error("no memory is left");
      // A call may grow the memory, and views of it are then void.
      new Uint8Array(memory.buffer, place, bytes.length).set(bytes);
      const block = answer(place, bytes.length);
      free(place, bytes.length);
      if (block === 0) throw new Error("no memory is left");
      const length = new DataView(memory.buffer).getUint32(block, true);
      const text = new TextDecoder().decode(new Uint8Array(memory.buffer, block + 4, length));
      free(block, length + 4);
      return JSON.parse(text);
    },
  };
}

async function startExplorer() {
  const source = await createWasmSource();
  const main = document.querySelector("main");
  const compare = document.getElementById("compare");
  const views = createFiberViews(document.getElementById("views"), source);
  const panel = await createFiberPanel(document.getElementById("panel"), source, {
    fiber: { preset: "red-fox", melanin: [0.2, 0.6] },
    onchange: (fiber, { other }) => views.show(fiber, { other: compare.checked ? other : null }),
  });
  compare.addEventListener("change", () => views.show(panel.fiber, { other: compare.checked ? panel.other : null }));
  main.hidden = false;
  await views.show(panel.fiber, { theta: 0, h: 0.3 });
  document.body.dataset.ready = "true";
}

startExplorer().catch((error) => {
  document.getElementById("failure").textContent =
    `The fibre explorer cannot start: ${error.message ?? error}. It needs a browser with WebAssembly and SIMD.`;
});
