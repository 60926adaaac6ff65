// Checks the golden vectors with the model as WebAssembly: node vectors.cjs VELLUS_VIEWS.wasm FOLDER
//
// It is also an example of the module's three functions without a browser.

const fs = require("node:fs");

const [file, folder] = process.argv.slice(2);
const instance = new WebAssembly.Instance(new WebAssembly.Module(fs.readFileSync(file)));
const { memory, vellus_alloc, vellus_answer, vellus_free } = instance.exports;

/** Sends a request to the model, and returns its answer. */
function ask(request) {
  const text = new TextEncoder().encode(JSON.stringify(request));
  const room = vellus_alloc(text.length);
  new Uint8Array(memory.buffer, room, text.length).set(text);
  const block = vellus_answer(room, text.length);
  vellus_free(room, text.length);
  const length = new DataView(memory.buffer).getUint32(block, true);
  const answer = JSON.parse(new TextDecoder().decode(new Uint8Array(memory.buffer, block + 4, length)));
  vellus_free(block, length + 4);
  if (answer.error) throw new Error(answer.error);
  return answer;
}

/** The rows of a table, without its header. */
const table = (name) => fs.readFileSync(`${folder}/${name}`, "utf8").trim().split("\n").map((line) => line.split(","));

const [names, ...fibers] = table("fibers.csv");
const queries = table("queries.csv").slice(1).map((row) => row.map(Number));
let worst = 0;
fibers.forEach((row, index) => {
  const value = (text, i) => [names[i], names[i] === "exit" ? text : Number(text)];
  const fiber = Object.fromEntries(row.map(value).slice(1));
  const own = queries.filter((query) => query[0] === index);
  const { values } = ask({ ask: "values", fiber, queries: own.map((query) => query.slice(1, 9)) });
  own.forEach((query, i) => values[i].forEach((value, c) => {
    worst = Math.max(worst, Math.abs(value - query[9 + c]) / query[12]);
  }));
});
console.log(`${queries.length} queries, largest error ${worst.toFixed(2)} tolerances`);
if (queries.length !== 2000 || !(worst <= 1)) process.exit(1);
