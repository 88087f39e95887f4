// One loop: the clock goes on, and picture, tables, plots and the bar below the picture follow it.

export class Loop {
  constructor(source, picture, tables, transport) {
    Object.assign(this, { source, picture, tables, transport });
    this.last = 0;
  }

  start() {
    requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    this.start();
    this.onframe?.((now - this.last) / 1000);
    if (this.source.advance(now)) this.picture.redraw();
    if (this.source.shown !== null) this.picture.keepUp((now - this.last) / 1000);
    this.last = now;
    if (this.picture.stale) {
      this.picture.pose(this.source.reached);
      for (const table of this.tables) table.show(this.picture.row);
    }
    this.transport.show();
    this.source.plot(now);
    this.picture.render();
  }
}
