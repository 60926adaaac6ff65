// The picture: it shows frames, and turns the mouse, touches and keys into camera commands.

const DEGREES = 0.35; // Degrees of an orbit per CSS pixel.
const KEY_DEGREES = 6;

const sum = (a, b) => ({ ...b, x: a.x + b.x, y: a.y + b.y });

export class Viewport extends EventTarget {
  constructor(connection) {
    super();
    this.connection = connection;
    this.view = document.getElementById("view");
    this.canvas = document.getElementById("canvas");
    this.overlay = document.getElementById("overlay");
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.size = [960, 640];
    this.mode = "move";
    this.pointers = new Map();
    this.crop = null;
    this.mark = null;
    connection.addEventListener("picture", ({ detail }) => this.show(detail));
    new ResizeObserver(() => this.layout()).observe(this.view);
    this.listen();
  }

  show({ header, bitmap }) {
    const [left, top, right, bottom] = header.area;
    const [w, h] = [this.canvas.width, this.canvas.height];
    this.context.imageSmoothingEnabled = header.coarse > 1;
    this.context.drawImage(bitmap, left * w, top * h, (right - left) * w, (bottom - top) * h);
    bitmap.close();
    this.header = header;
    this.dispatchEvent(new CustomEvent("frame", { detail: header }));
  }

  setSize([width, height], crop) {
    if (width !== this.size[0] || height !== this.size[1]) {
      this.size = [width, height];
      [this.canvas.width, this.canvas.height] = [width, height];
    }
    this.crop = crop;
    this.layout();
  }

  // Fits the picture into the view.
  layout() {
    const { clientWidth: w, clientHeight: h } = this.view;
    const scale = Math.min(w / this.size[0], h / this.size[1]);
    this.box = { width: this.size[0] * scale, height: this.size[1] * scale };
    this.box.left = (w - this.box.width) / 2;
    this.box.top = (h - this.box.height) / 2;
    for (const [name, value] of Object.entries(this.box)) this.canvas.style[name] = `${value}px`;
    this.draw();
  }

  draw() {
    const { left, top, width, height } = this.box;
    const shapes = [];
    const rect = this.dragged ?? this.crop;
    if (rect) {
      const [l, t, r, b] = rect;
      shapes.push(`<rect x="${left + l * width}" y="${top + t * height}" width="${Math.max(0, (r - l) * width)}"
        height="${Math.max(0, (b - t) * height)}"/>`);
    }
    if (this.mark) shapes.push(`<circle cx="${left + this.mark.x * width}" cy="${top + this.mark.y * height}" r="8"/>`);
    this.overlay.innerHTML = shapes.join("");
  }

  setMark(mark) {
    this.mark = mark;
    this.draw();
  }

  setMode(mode) {
    this.mode = mode;
    for (const name of ["pick", "crop"]) this.view.classList.toggle(name, mode === name);
    this.dispatchEvent(new CustomEvent("mode", { detail: mode }));
  }

  // The position of an event in the picture, as shares of its size.
  at(event) {
    const outer = this.view.getBoundingClientRect();
    const limit = (x) => Math.min(1, Math.max(0, x));
    return {
      x: limit((event.clientX - outer.left - this.box.left) / this.box.width),
      y: limit((event.clientY - outer.top - this.box.top) / this.box.height),
    };
  }

  orbit(x, y) {
    this.moved();
    this.connection.stream("orbit", { type: "orbit", x, y }, sum);
  }

  pan(x, y) {
    this.moved();
    this.connection.stream("pan", { type: "pan", x, y }, sum);
  }

  zoom(factor) {
    this.moved();
    const limit = (x) => Math.min(100, Math.max(0.01, x));
    const join = (a, b) => ({ ...b, factor: limit(a.factor * b.factor) });
    this.connection.stream("zoom", { type: "zoom", factor: limit(factor) }, join);
  }

  // A mark belongs to one camera.
  moved() {
    if (this.mark) this.setMark(null);
  }

  listen() {
    const view = this.view;
    view.addEventListener("contextmenu", (event) => event.preventDefault());
    view.addEventListener("pointerdown", (event) => {
      if (event.target.closest("#keys")) return;
      view.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      this.start = { ...this.at(event), moved: false };
    });
    view.addEventListener("pointermove", (event) => this.drag(event));
    const end = (event) => {
      if (!this.pointers.delete(event.pointerId) || event.type === "pointercancel") return;
      this.release(event);
    };
    view.addEventListener("pointerup", end);
    view.addEventListener("pointercancel", end);
    view.addEventListener("dblclick", (event) => this.focus(this.at(event)));
    view.addEventListener("wheel", (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 16 : 1;
      this.zoom(Math.exp(Math.max(-200, Math.min(200, event.deltaY * lines)) * 0.0015));
    }, { passive: false });
    view.addEventListener("keydown", (event) => this.key(event));
  }

  drag(event) {
    const last = this.pointers.get(event.pointerId);
    if (!last) return;
    const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
    if (dx === 0 && dy === 0) return;
    if (this.pointers.size === 2) {
      const [a, b] = [...this.pointers.values()];
      const before = Math.hypot(a.x - b.x, a.y - b.y);
      Object.assign(last, { x: event.clientX, y: event.clientY });
      const after = Math.hypot(a.x - b.x, a.y - b.y);
      if (before > 0 && after > 0) this.zoom(before / after);
      this.pan(-dx / 2 / this.box.height, dy / 2 / this.box.height);
      return;
    }
    Object.assign(last, { x: event.clientX, y: event.clientY });
    this.start.moved = true;
    if (this.mode === "crop") {
      const here = this.at(event);
      this.dragged = [Math.min(here.x, this.start.x), Math.min(here.y, this.start.y),
        Math.max(here.x, this.start.x), Math.max(here.y, this.start.y)];
      this.draw();
    } else if (event.shiftKey || event.buttons & 6) {
      this.pan(-dx / this.box.height, dy / this.box.height);
    } else {
      this.orbit(-dx * DEGREES, dy * DEGREES);
    }
  }

  release(event) {
    if (this.mode === "crop" && this.dragged) {
      this.connection.send({ type: "crop", area: this.dragged });
      this.dragged = null;
      this.setMode("move");
    } else if (this.mode === "pick" && !this.start.moved) {
      this.pick(this.at(event));
    }
  }

  async pick(place) {
    const answer = await this.connection.send({ type: "pick", ...place });
    if (!answer) return;
    this.setMark(place);
    this.dispatchEvent(new CustomEvent("pick", { detail: answer }));
  }

  focus(place) {
    this.connection.send({ type: "focus", ...place });
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const arrow = arrows[event.key];
    if (arrow) {
      if (event.shiftKey) this.pan(arrow[0] * 0.05, arrow[1] * 0.05);
      else this.orbit(arrow[0] * KEY_DEGREES, arrow[1] * KEY_DEGREES);
    } else if (event.key === "+" || event.key === "=") this.zoom(0.9);
    else if (event.key === "-") this.zoom(1 / 0.9);
    else if (event.key === "Enter" && this.mode === "pick") this.pick({ x: 0.5, y: 0.5 });
    else return;
    event.preventDefault();
  }
}
