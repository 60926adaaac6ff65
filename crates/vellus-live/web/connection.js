// The WebSocket to the server: commands, answers, states and pictures. It connects again after a loss.

const RETRY = [250, 500, 1000, 2000];

export class Connection extends EventTarget {
  constructor() {
    super();
    this.waiting = new Map();
    this.next = 1;
    this.losses = 0;
    this.merged = new Map();
    this.connect();
  }

  get open() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  connect() {
    const url = new URL("ws", location.href);
    url.protocol = "ws:";
    this.socket = new WebSocket(url);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.losses = 0;
      this.emit("online");
    };
    this.socket.onmessage = ({ data }) => (typeof data === "string" ? this.text(JSON.parse(data)) : this.picture(data));
    this.socket.onclose = () => {
      this.emit("offline");
      for (const { reject } of this.waiting.values()) reject(new Error("the connection is lost"));
      this.waiting.clear();
      this.merged.clear();
      setTimeout(() => this.connect(), RETRY[Math.min(this.losses++, RETRY.length - 1)]);
    };
  }

  emit(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  text(message) {
    if (message.type === "hello") {
      this.token = message.token;
      return;
    }
    if (message.type === "state") {
      this.emit("state", message);
      return;
    }
    const waiting = this.waiting.get(message.id);
    this.waiting.delete(message.id);
    if (message.type === "reply") waiting?.resolve(message.answer);
    else if (waiting) waiting.reject(new Error(message.message));
    else this.emit("problem", message.message);
  }

  async picture(data) {
    const length = new DataView(data).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    const socket = this.socket;
    try {
      const bitmap = await createImageBitmap(new Blob([new Uint8Array(data, 4 + length)], { type: "image/png" }));
      this.emit("picture", { header, bitmap });
    } finally {
      // The server sends the next picture when this one is shown.
      if (socket.readyState === WebSocket.OPEN) socket.send('{"type":"ack"}');
    }
  }

  // Sends or fetches a file. The server takes such requests only with the token of its own page.
  post(path, body) {
    return fetch(path, { method: "POST", body, headers: { "X-Vellus-Token": this.token ?? "" } });
  }

  // Sends a command, and resolves to its answer.
  ask(command) {
    if (!this.open) return Promise.reject(new Error("the connection is lost"));
    const id = this.next++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.socket.send(JSON.stringify({ ...command, id }));
    });
  }

  // Sends a command, and reports only an error.
  async send(command) {
    try {
      return await this.ask(command);
    } catch (error) {
      this.emit("problem", error.message);
      return null;
    }
  }

  // Sends a command that replaces or extends the last one of the same kind, while that one is not answered. A slider
  // or a drag then never fills the queue of the server.
  async stream(kind, command, join = (_, newer) => newer) {
    const waiting = this.merged.get(kind);
    if (waiting) {
      waiting.command = waiting.command ? join(waiting.command, command) : command;
      return;
    }
    const state = { command: null };
    this.merged.set(kind, state);
    await this.send(command);
    while (state.command && this.merged.get(kind) === state) {
      const latest = state.command;
      state.command = null;
      await this.send(latest);
    }
    if (this.merged.get(kind) === state) this.merged.delete(kind);
  }
}
