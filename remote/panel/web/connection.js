// The WebSocket to the program: token, messages, reconnection, and the regular `alive` of a panel that armed the drives.

const FIRST_PAUSE_MS = 250, LONGEST_PAUSE_MS = 5000, SILENCE_MS = 3000;

/** Token of the link (`#TOKEN`), which leaves the address bar and stays in the session storage of this tab. */
function takeToken() {
  const token = location.hash.slice(1);
  if (token) {
    sessionStorage.setItem("token", token);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token") ?? "";
}

/**
 * Emits every message of the program under its kind, binary frames as "chunk", and "open" and "lost".
 * `description` and `state` hold the last ones.
 */
export class Connection {
  description = null;
  state = null;
  open = false;
  #handlers = new Map();
  #socket = null;
  #pause = FIRST_PAUSE_MS;
  #lastMessage = 0;
  #aliveReasons = new Set();

  constructor() {
    this.token = takeToken();
    addEventListener("hashchange", () => this.#restart());
    addEventListener("online", () => this.#connect());
    const ticker = new Worker("/ticker.js");
    ticker.onmessage = () => this.#tick();
  }

  /** Calls `handler(message)` for each message of `kind`. */
  on(kind, handler) {
    this.#handlers.set(kind, [...(this.#handlers.get(kind) ?? []), handler]);
  }

  /** Calls `handler(description)` when the picked part of the description differs from before. */
  onChange(pick, handler) {
    let before = "";
    this.on("description", (description) => {
      const now = JSON.stringify(pick(description));
      if (now !== before) handler(description);
      before = now;
    });
  }

  start() {
    this.#connect();
  }

  /** Sends an order; returns false if there is no connection. */
  send(order) {
    if (!this.open) return false;
    this.#socket.send(JSON.stringify(order));
    return true;
  }

  /** Sends `alive` every 100 ms as long as at least one reason is on. */
  keepAlive(reason, on) {
    if (on) this.#aliveReasons.add(reason);
    else this.#aliveReasons.delete(reason);
  }

  #emit(kind, message) {
    for (const handler of this.#handlers.get(kind) ?? []) {
      try { handler(message); } catch (error) { console.error(error); }   // one view must not stop the others
    }
  }

  #restart() {
    this.token = takeToken();
    this.#lose(this.#socket);
    this.#connect();
  }

  #connect() {
    if (this.#socket) return;
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/session?token=${encodeURIComponent(this.token)}`);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    this.#lastMessage = performance.now();
    socket.onopen = () => this.#opened();
    socket.onmessage = (event) => { if (socket === this.#socket) this.#receive(event.data); };
    socket.onclose = () => this.#lose(socket);
  }

  #opened() {
    this.open = true;
    this.#emit("open");
  }

  #receive(data) {
    this.#lastMessage = performance.now();
    if (data instanceof ArrayBuffer) return this.#emit("chunk", data);
    const message = JSON.parse(data);
    if (message.kind === "description") {
      this.description = message;
      this.#pause = FIRST_PAUSE_MS;
    }
    if (message.kind === "state") {
      this.state = message;
      this.keepAlive("owner", message.owner);
    }
    this.#emit(message.kind, message);
  }

  #lose(socket) {
    if (!socket || socket !== this.#socket) return;
    const wasOpen = this.open;
    this.#socket = null;
    this.open = false;
    this.#aliveReasons.clear();
    socket.close();
    this.#emit("lost", { wasOpen, pause: this.#pause });
    setTimeout(() => this.#connect(), this.#pause);
    this.#pause = Math.min(LONGEST_PAUSE_MS, this.#pause * 1.7);
  }

  #tick() {
    if (this.#aliveReasons.size) this.send({ do: "alive" });
    if (this.#socket && performance.now() - this.#lastMessage > SILENCE_MS) this.#lose(this.#socket);
  }
}
