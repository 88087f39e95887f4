// The connection of a live view's page with its server.

export class Link {
  constructor(id) {
    this.id = id;
  }

  connect() {
    const socket = (this.socket = new WebSocket(`ws://${location.host}${location.pathname}ws`));
    socket.binaryType = "arraybuffer";
    socket.onmessage = (message) => {
      if (typeof message.data === "string") this.hear(JSON.parse(message.data));
      else if (!this.leaving) this.receive(message.data);
    };
    socket.onopen = () => this.onlink?.(true);
    socket.onclose = () => {
      this.onlink?.(false);
      setTimeout(() => this.connect(), 1000);
    };
  }

  // A page that computes its motion by itself needs no frames.
  receive() {}

  hear(state) {
    if (state.notes) {
      this.onnotes?.(state.notes);
      return;
    }
    if (state.scene !== this.id) {
      // what still comes before the page has gone belongs to the new scene
      this.leaving = true;
      this.onleave?.();
      location.reload();
      return;
    }
    this.onstate?.(state);
  }

  send(message) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }
}
